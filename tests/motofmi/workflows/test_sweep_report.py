"""The report of a study: its first screen, and the links that show single runs in an explore page."""

import re
from html import unescape
from urllib.parse import unquote

import numpy as np
import pytest

import motofmi as mf
from motofmi.workflows.sweep.result import StudyResult
from tests.browser import chromium, needs_browser
from tests.pages import WIDER, Page, assert_is_a_report

pytest.importorskip("zarr", reason="the extra motofmi[scale] is not installed")
pytest.importorskip("pyarrow", reason="the extra motofmi[scale] is not installed")

# The values of a run in the page: configuration, mode and speed, and its eigenvalue there.
SHOWN = """() => { const {settings, found} = page, i = nearestIndex(found.B.points, settings.speed), {re, im} = found.B.curves[settings.mode];
  return {B: settings.B, A: settings.A, mode: settings.mode, speed: settings.speed, eigenvalue: [re[i], im[i]]}; }"""


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """Two riders and two dampings of the motorcycle, with and without a damper at the handlebar."""
    found = mf.sweep(device=["none", "damper:7.5"], speed=[20.0, 40.0], count=2, workers=1,
                     set={"rider": "~riders_2011", "steering_damping": [0.0, 10.0]},
                     out=tmp_path_factory.mktemp("out") / "study")  # fmt: skip
    return found, mf.open_study(found.folder).report()


def links(report):
    return [unescape(link) for link in re.findall(r'href="(explore\.html#[^"]*)"', report.read_text("utf-8"))]


@pytest.mark.slow
def test_the_report_begins_with_question_answer_and_picture(study):
    page = assert_is_a_report(study[1])
    assert re.search(r"Weave is unstable at some speed in \d+ of \d+ runs \([\d.]+ %\), first at \d+\.\d m/s", page.text)
    # Sharp's motorcycle of 1971 with a passive rider capsizes slowly at 20 and 40 m/s.
    assert "Capsize is unstable at some speed in 8 of 8 runs (100 %)" in page.text and "it has no map" in page.text
    assert "8 runs: 2 devices x 2 riders x 2 values of steering_damping." in page.text


@pytest.mark.slow
@needs_browser
def test_a_link_shows_the_run(study):
    found, report = study
    table = found.table.set_index("run")
    with chromium() as browser:
        window = browser.new_page(viewport={"width": 390, "height": 800})
        wrong = []
        window.on("pageerror", lambda error: wrong.append(str(error)))
        window.goto(report.as_uri())
        assert window.evaluate(WIDER) == []
        rows = window.locator("tr", has=window.locator("a[href^='explore.html']"))
        run = int(rows.first.locator("a").text_content())
        rows.first.locator("a").click()
        window.wait_for_selector("#charts svg")
        shown = window.evaluate(SHOWN)
    row = table.loc[run]
    assert (shown["mode"], shown["speed"]) == ("weave", row["weave_damping_speed"])
    assert shown["B"]["device"] == ("riders_2011,damper_7.5" if row["device"] == "damper:7.5" else "riders_2011")
    assert shown["B"]["values"]["device.arm_damping"] == row["rider.arm_damping"]
    assert shown["A"]["values"] == {} and shown["A"]["device"] == shown["B"]["device"]
    chosen = found.dataset["eigenvalue"].sel(mode="weave", speed=shown["speed"]).values.ravel()[run]
    assert complex(*shown["eigenvalue"]) == pytest.approx(chosen, rel=1e-9)
    assert wrong == []


@pytest.mark.slow
def test_every_run_of_a_table_has_its_address(study):
    found, report = study
    addresses = links(report)
    assert len(addresses) == 8 + 2  # the runs by damping ratio, and one of the map of each device
    for address in addresses:
        state = dict(part.split("=", 1) for part in address.partition("#")[2].split("&"))
        assert 20 <= float(state["speed"]) <= 40 and state["A"].startswith("sharp_1971;riders_2011")
        values = dict(v.split(":") for v in unquote(state["B"]).split(";")[2:])
        arms = float(values["device.arm_damping"])
        assert np.isclose(found.table["rider.arm_damping"], arms, rtol=0, atol=0).any()


@pytest.mark.slow
def test_a_device_of_another_tool_has_no_link(study, tmp_path):
    found, _ = study
    fmus = {**found.description, "device": [[{"name": "other", "sha256": "0"}], [{"name": "another", "sha256": "1"}]]}
    report = StudyResult(found.folder, fmus).report(tmp_path / "report.html")
    assert links(report) == [] and [path.name for path in tmp_path.iterdir()] == ["report.html"]
    assert "No explore page was written with this report: its vehicle or devices are FMUs" in Page(report).text
