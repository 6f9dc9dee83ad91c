"""The page of `motofmi explore` in a browser: the numbers and names of Python, every control, no request, the layout."""

import csv
import io
import json
import re
from importlib.util import find_spec
from xml.etree import ElementTree as Xml

import numpy as np
import pytest

import motofmi as mf
from fmus.support.errors import InputError, MissingToolError
from tests.accessibility import needs_axe, violations
from tests.browser import chromium, needs_browser
from tests.explore_page import (
    FLEXIBLE,
    MODE_OF_THE_COUPLED_FMUS,
    MODES_IN_THE_PAGE,
    RIGID,
    SPEEDS,
    Opened,
    complex_numbers,
    differing_modes,
    eigenvalue_error,
    modes_in_python,
    random_settings,
)
from vehicle_fmu import MODES

needs_zig = pytest.mark.skipif(find_spec("ziglang") is None, reason="needs ziglang (pip install motofmi[platforms])")
STIFFENED = """component = "PassiveRider"
effects = ["hardening_stiffness.cubic"]
source = "test"
[parameters]
arm_stiffness = 900.0
"""


def in_browser(test):
    return pytest.mark.slow(needs_browser(test))


@pytest.fixture(scope="module")
def browser():
    with chromium() as opened:
        yield opened


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    return mf.explore(out=tmp_path_factory.mktemp("page") / "explore.html")


@pytest.fixture
def page(browser, written):
    opened = Opened(browser, written.path)
    yield opened
    opened.window.close()
    assert opened.complaints == []


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
    with pytest.raises(MissingToolError, match=r"motofmi\[platforms\]"):
        mf.explore(device=tmp_path / "rider.toml", out=tmp_path / "page.html")
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
@pytest.mark.parametrize("vehicles", [RIGID, pytest.param(FLEXIBLE, marks=pytest.mark.study)])
def test_eigenvalues_and_names_are_those_of_python(page, vehicles):
    cases = list(random_settings(page.window.evaluate("page.data"), 2, 12, vehicles))
    for case, found in zip(cases, page.window.evaluate(MODES_IN_THE_PAGE, cases), strict=True):
        expected = modes_in_python(case)
        # two QR methods: 1e-9 of the largest eigenvalue is far above their rounding errors
        assert eigenvalue_error(found, expected) < 1e-9
        assert differing_modes(found, expected) == []
        for mode in found["curves"]:
            assert np.ravel(found["unstable"][mode]) == pytest.approx(np.ravel(expected.unstable[mode]), abs=2e-2)


RIDERS = {"full_mean_2011": "rider:full_mean_2011", "roll_1971": "rider:roll_1971",
          "mean_2011,roll_1971": ["rider:mean_2011", "rider:roll_1971"],
          "mean_2011,damper_low_2011": ["rider:mean_2011", "damper:low_2011"]}  # fmt: skip


@in_browser
@pytest.mark.parametrize("device", [pytest.param(n, marks=pytest.mark.study) if "full" in n else n for n in RIDERS])
def test_riders_who_lean_move_their_arms_or_have_a_damper_are_those_of_python(page, device):
    case = {"vehicle": "sharp_1971", "device": device, "changes": {"vehicle.trail": 0.1}}
    (found,) = page.window.evaluate(MODES_IN_THE_PAGE, [case])
    expected = mf.modes("sharp_1971", RIDERS[device], SPEEDS, set={"trail": 0.1})
    assert eigenvalue_error(found, expected) < 1e-9 and differing_modes(found, expected) == []


@in_browser
@pytest.mark.parametrize(("device", "most"), [("full_mean_2011", 3e-4), ("mean_2011,roll_1971", 1e-4)])
def test_riders_of_every_kind_step(page, device, most):
    """With the coupling errors that the page states: 0.03 % with the full rider, else 0.01 %."""
    window = page.window
    window.evaluate("device => { page.settings.choose('B', {device}); page.refresh(['B']); page.settle(); }", device)
    frequency = window.evaluate("page.found.B.curves.wobble.im[nearestIndex(page.found.B.points, 30)]")
    found = window.evaluate(MODE_OF_THE_COUPLED_FMUS, frequency)
    exact = complex(*found["exact"])
    assert abs(complex(*found["coupled"]) - exact) < most * abs(exact)
    assert f"below {100 * most:g} %" in window.text_content("#live-text")
    window.click("[data-kick=frame]")  # where a leaning rider drives the roll torque, the push adds to it
    assert window.evaluate(GOES_ON, 0)
    assert window.evaluate("page.live.run.ok && Math.max(...page.live.rows.map(r => Math.abs(r[1])))") > 1e-3


@in_browser
def test_what_the_vehicle_cannot_have_is_not_offered(page):
    window = page.window
    window.select_option("#choose-vehicle", "benchmark_bicycle")
    offered = "name => !document.querySelector(`#choose-device option[value=${name}]`).disabled"
    assert not window.evaluate(offered, "roll_1971") and window.evaluate(offered, "full_mean_2011")
    assert "has no output" in window.text_content("#parameters")
    window.select_option("#choose-device", "mean_2011")
    window.select_option("#choose-device-2", "damper_low_2011")
    page.drawn()
    assert "B=benchmark_bicycle;mean_2011,damper_low_2011" in window.url
    assert "benchmark_bicycle with mean_2011 and damper_low_2011" in window.text_content("#charts")


@in_browser
def test_an_fmu_is_a_device_without_sliders(browser, tmp_path):
    fmu = mf.build(mf.rider("2_2011"), tmp_path).path
    opened = Opened(browser, mf.explore(device=fmu, out=tmp_path / "page.html").path)
    (found,) = opened.window.evaluate(
        MODES_IN_THE_PAGE, [{"vehicle": "reference_2011", "device": "2_2011.fmu", "changes": {}}]
    )
    expected = mf.modes("reference_2011", "rider:2_2011", SPEEDS)  # the FMU's Jacobian is the exact one
    assert eigenvalue_error(found, expected) < 1e-9 and differing_modes(found, expected) == []
    assert "2_2011.fmu is an FMU of another tool" in opened.window.text_content("#parameters")
    assert "cannot step" in opened.window.text_content("#live-text") and opened.window.is_disabled("#run")
    assert opened.complaints == []
    opened.window.close()


@in_browser
def test_eigenvalues_of_matrices_with_known_ones(page):
    """Block-diagonal matrices of chosen eigenvalues in random orthogonal coordinates."""
    rng, cases, expected = np.random.default_rng(4), [], []
    for n in range(2, 12):
        reals, pairs = rng.normal(size=n % 3), rng.normal(size=((n - n % 3) // 2, 2))
        values = [*reals, *(complex(a, s * b) for a, b in pairs for s in (1, -1))]
        block = np.zeros((len(values),) * 2)
        block[range(len(reals)), range(len(reals))] = reals
        for k, (a, b) in enumerate(pairs):
            i = len(reals) + 2 * k
            block[i : i + 2, i : i + 2] = [[a, b], [-b, a]]
        Q, _ = np.linalg.qr(rng.normal(size=block.shape))
        cases.append((Q @ block @ Q.T).tolist())
        expected.append(values)
    found = page.window.evaluate(
        "cases => cases.map(A => { const {re, im} = eigenvalues(Float64Array.from(A.flat()), A.length); return [[...re], [...im]]; })",
        cases,
    )
    for parts, values in zip(found, expected, strict=True):
        assert np.sort_complex(complex_numbers(*parts)) == pytest.approx(np.sort_complex(values), abs=1e-12)


@in_browser
def test_every_slider_moves_a_curve(page):
    window = page.window
    for device, first in (("mean_2011", "p-"), ("damper_low_2011", "p-device")):
        window.click("#reset")
        window.select_option("#choose-device", device)
        page.drawn()
        window.evaluate("document.querySelectorAll('#parameters details').forEach(d => d.open = true)")
        for key in window.evaluate(
            "first => [...document.querySelectorAll('#parameters input[type=range]')].map(i => i.id).filter(id => id.startsWith(first))",
            first,
        ):
            before = page.curves()
            window.evaluate(
                "id => { const s = document.getElementById(id); s.value = 0.3 * s.min + 0.7 * s.max; s.dispatchEvent(new Event('input')); }",
                key,
            )
            page.drawn()
            # what a rider adds to the steer inertia is bound to the vehicle's parameter of that name
            bound = key == "p-vehicle-added_steer_inertia" and device == "mean_2011"
            assert (page.curves() != before) != bound, key


@in_browser
def test_the_speed_the_view_and_the_mode_are_chosen(page):
    window = page.window
    window.evaluate(
        "() => { const s = document.getElementById('speed'); s.value = 50; s.dispatchEvent(new Event('input')); }"
    )
    page.drawn()
    assert "50.0 m/s" in window.text_content("#readings")
    window.click("#view [data-value=speed]")
    page.drawn()
    assert "frequency [Hz]" in window.text_content("#charts") and window.locator("#charts .band").count() > 0
    window.click("#mode [data-value='A weave']")
    page.drawn()
    assert "weave of A" in window.text_content("#motion-text")
    assert window.locator("#motion .motorcycle path").count() > 30 and window.locator("#phasors .arrow").count() == 3


@in_browser
def test_unstable_speeds_and_the_reading_are_those_of_the_modes(page):
    expected = mf.modes("sharp_1971", "rider:mean_2011", SPEEDS)
    ((low, high),) = expected.unstable["weave"]
    row = page.window.locator("#readings table").nth(1).locator("tr", has_text="weave").first.text_content()
    assert f"{low:.1f} to {high:.1f}" in row and f"{expected['weave'].frequency[29]:.2f}" in row


@in_browser
def test_the_keyboard_moves_a_slider_and_its_number(page):
    slider = page.window.locator("#p-vehicle-trail")
    slider.focus()
    before = float(slider.input_value())
    page.window.keyboard.press("ArrowRight")
    page.drawn()
    assert float(slider.input_value()) > before and "vehicle.trail" in page.window.url


@in_browser
def test_an_address_reproduces_the_view(browser, written, page):
    address = "#view=speed&speed=42.5&side=A&mode=wobble&A=reference_2011;damper_low_2011;device.damping:9&B=benchmark_bicycle;none"
    again = Opened(browser, written.path, address)
    state = again.window.evaluate("({...page.settings, data: 0})")
    assert (state["view"], state["speed"], state["side"], state["mode"]) == ("speed", 42.5, "A", "wobble")
    assert state["A"] == {"vehicle": "reference_2011", "device": "damper_low_2011", "values": {"device.damping": 9}}
    assert state["B"] == {"vehicle": "benchmark_bicycle", "device": "none", "values": {}}
    assert again.curves() != page.curves() and again.complaints == []
    again.window.close()


@in_browser
def test_the_tables_and_the_drawing_are_downloaded(page):
    with page.window.expect_download() as download:
        page.window.click("#csv")
    rows = list(csv.DictReader(io.StringIO(download.value.path().read_text("utf-8"))))
    weave = {
        float(r["speed [m/s]"]): float(r["real [1/s]"])
        for r in rows
        if r["configuration"][0] == "B" and r["mode"] == "weave"
    }
    expected = mf.modes("sharp_1971", "rider:mean_2011", SPEEDS)["weave"].eigenvalue.real
    assert [weave[v] for v in SPEEDS] == pytest.approx(list(expected), rel=1e-9)
    with page.window.expect_download() as download:
        page.window.click("#svg")
    drawing = Xml.fromstring(download.value.path().read_text("utf-8"))
    assert len(drawing.findall(".//{*}path")) > 9 and "var(--weave)" in Xml.tostring(drawing, "unicode")


# Whether the co-simulation has gone on for 0.05 s after a time, within 300 frames.
GOES_ON = """(before) => new Promise((done) => {
  let frames = 0;
  const look = () => (page.live.run.time > before + 0.05 || ++frames > 300 ? done(page.live.run.time > before + 0.05) : requestAnimationFrame(look));
  look();
})"""


@in_browser
def test_the_fmus_run_are_disturbed_and_exchanged(page):
    window = page.window
    window.click("[data-kick=bar]")
    window.wait_for_selector("text=faster than real time")
    assert window.evaluate("Math.max(...page.live.rows.map(r => Math.abs(r[2])))") > 1e-3
    for device, title in (("damper_low_2011", "LinearDamper"), ("none", None), ("mean_2011", "PassiveRider")):
        before = window.evaluate("page.live.run.time")
        window.select_option("#choose-device", device)
        page.drawn()
        assert window.evaluate("page.live.run.devices[0]?.stepped.fmu.library.title ?? null") == title
        assert window.evaluate(GOES_ON, before)
        assert window.evaluate("page.live.running && page.live.run.ok")
    window.select_option("#choose-vehicle", "tum_2020")
    page.drawn()
    before = window.evaluate("page.live.run.time")
    assert window.evaluate(GOES_ON, before)
    window.click("#run")
    stopped = window.evaluate("page.live.run.time")
    page.drawn()
    assert window.evaluate("page.live.run.time") == stopped


@in_browser
@pytest.mark.parametrize("mode", ["weave", "wobble"])
def test_the_coupling_keeps_the_modes_within_a_hundredth_of_a_percent(page, mode):
    exact = mf.modes("sharp_1971", "rider:mean_2011", [30.0])[mode].eigenvalue[0]
    found = page.window.evaluate(MODE_OF_THE_COUPLED_FMUS, exact.imag)
    assert complex(*found["exact"]) == pytest.approx(exact, rel=1e-9)
    assert abs(complex(*found["coupled"]) - exact) < 1e-4 * abs(exact)


@in_browser
@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.parametrize("view", ["locus", "speed"])
def test_nothing_is_cut_or_wider_than_the_window(browser, written, width, view):
    opened = Opened(browser, written.path, f"#view={view}", width)
    wide = opened.window.evaluate(
        """() => [...document.querySelectorAll('main *')].filter(e => !e.closest('svg') && e.getBoundingClientRect().right > innerWidth + 1)
                 .map(e => e.tagName + '#' + e.id + '.' + e.className)"""
    )
    assert wide == [] and opened.window.evaluate("document.documentElement.scrollWidth <= innerWidth")
    cut = opened.window.evaluate(
        "[...document.querySelectorAll('.table')].filter(t => t.scrollWidth > t.clientWidth + 1).length"
    )
    assert cut == 0 and opened.complaints == []
    opened.window.close()


@in_browser
def test_dark_and_light_follow_the_system(browser, written):
    papers = set()
    for scheme in ("light", "dark"):
        opened = Opened(browser, written.path, color_scheme=scheme)
        papers.add(opened.window.evaluate("getComputedStyle(document.body).backgroundColor"))
        opened.window.emulate_media(media="print")  # of a dark page, too, on white paper
        assert opened.window.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
        opened.window.close()
    assert len(papers) == 2


@in_browser
@needs_axe
@pytest.mark.parametrize(("width", "scheme"), [(1280, "light"), (390, "dark")])
def test_axe_finds_nothing(browser, written, width, scheme):
    opened = Opened(browser, written.path, "#B=tum_2020;mean_2011", width, color_scheme=scheme)
    opened.window.evaluate("document.querySelectorAll('details').forEach(each => { each.open = true; })")
    assert violations(opened.window) == []
    opened.window.close()


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


@in_browser
def test_every_control_has_a_name(page):
    unnamed = page.window.evaluate(
        """() => [...document.querySelectorAll('input, select, button, svg[role], canvas')].filter(e =>
             !(e.labels?.length || e.getAttribute('aria-label') || e.textContent.trim())).map(e => e.outerHTML.slice(0, 80))"""
    )
    assert unnamed == []


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
