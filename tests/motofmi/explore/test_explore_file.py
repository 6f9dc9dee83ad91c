"""The file that `motofmi explore` writes: what is refused, what it needs, and that it refers to nothing outside."""

import json
import re
import tomllib
from importlib.util import find_spec

import pytest

import motofmi as mf
from fmus.support.errors import InputError, MissingToolError
from tests import ROOT
from tests.explore_page import Opened, in_browser
from vehicle_fmu import MODES

needs_zig = pytest.mark.skipif(find_spec("ziglang") is None, reason="needs ziglang (pip install motofmi[platforms])")
STIFFENED = """component = "PassiveRider"
effects = ["hardening_stiffness.cubic"]
source = "test"
[parameters]
arm_stiffness = 900.0
"""


def test_what_does_not_go_together_is_refused(tmp_path):
    out = tmp_path / "page.html"
    with pytest.raises(InputError, match="cannot both hold the handlebar"):
        mf.explore(device="rider:mean_2011,rider:1_2011", out=out)
    with pytest.raises(InputError, match="lacks the parameters rear_mass"):
        mf.explore("benchmark_bicycle", "rider:roll_1971", out)
    assert not out.exists()


@pytest.mark.usefixtures("without_compiler")
def test_what_ships_needs_no_compiler(tmp_path):
    built = mf.explore("reference_2011", ["damper:7.5", "rider:mean_2011"], tmp_path / "page.html")
    assert (built.devices[1], built.size) == ("damper_7.5", built.path.stat().st_size)


@pytest.mark.usefixtures("without_compiler")
def test_where_a_compiler_is_missing_the_fix_is_named(tmp_path, monkeypatch):
    monkeypatch.setenv("MOTOFMI_CACHE", str(tmp_path / "cache"))
    (tmp_path / "rider.toml").write_text(STIFFENED)
    with pytest.raises(MissingToolError) as refused:
        mf.explore(device=tmp_path / "rider.toml", out=tmp_path / "page.html")
    message = str(refused.value)
    assert "\n" not in message and message.endswith("pip install 'motofmi[platforms]'")
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]
    assert any(requirement.startswith("ziglang") for requirement in extras["platforms"])
    assert not (tmp_path / "page.html").exists()


def test_one_device_is_compared_with_none(tmp_path):
    for given, sides in (("damper:7.5", ["none", "damper_7.5"]), (None, ["none", "mean_2011"])):
        page = mf.explore(device=given, out=tmp_path / "page.html").path.read_text("utf-8")
        assert f'"devices":{json.dumps(sides, separators=(",", ":"))}' in page


def test_the_page_is_one_file_below_two_megabytes_that_refers_to_no_other(written):
    text = written.path.read_text("utf-8")
    assert written.size == written.path.stat().st_size < 2_000_000
    assert not re.findall(r"""(?:src|href)\s*=\s*["']?https?:|@import|url\(\s*["']?http""", text)
    assert {"none", "mean_2011", "damper_low_2011"} <= set(written.devices) and "sharp_1971" in written.vehicles


@in_browser
def test_a_notebook_shows_the_page(browser, written):
    window, complaints = browser.new_page(), []
    window.on("pageerror", lambda error: complaints.append(str(error)))
    window.set_content(written._repr_html_())
    frame = window.frame_locator("iframe")
    frame.locator("#charts svg").first.wait_for()
    frame.locator("#view [data-value=speed]").click()
    frame.get_by_text("damping ratio [1]").first.wait_for()
    assert complaints == []
    window.close()


@pytest.mark.study
@in_browser
@needs_zig
def test_a_rider_of_the_gap_workflow_opens(browser, tmp_path):
    rider = tmp_path / "augmented_rider.toml"
    rider.write_text(STIFFENED)
    built = mf.explore(device=["rider:mean_2011", rider], out=tmp_path / "page.html")
    opened = Opened(browser, built.path)
    data = json.loads(opened.window.text_content("#data"))
    assert data["devices"] == ["mean_2011", "augmented_rider"]
    assert opened.window.evaluate("Object.keys(page.found.B.curves).length") == len(MODES) and opened.complaints == []
    opened.window.close()
