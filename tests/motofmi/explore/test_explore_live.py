"""The FMUs that step in the explore page: disturbed, exchanged, and without visible errors of the coupling."""

import pytest

import motofmi as mf
from tests.explore_page import MODE_OF_THE_COUPLED_FMUS, in_browser

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
@pytest.mark.parametrize(("device", "step"), [("full_mean_2011", "0.8 ms"), ("mean_2011,roll_1971", "1 ms")])
def test_riders_of_every_kind_step(page, device, step):
    """With the step and the coupling error that the page states."""
    window = page.window
    window.evaluate("device => { page.settings.choose('B', {device}); page.refresh(['B']); page.settle(); }", device)
    frequency = window.evaluate("page.found.B.curves.wobble.im[nearestIndex(page.found.B.points, 30)]")
    found = window.evaluate(MODE_OF_THE_COUPLED_FMUS, frequency)
    exact = complex(*found["exact"])
    assert abs(complex(*found["coupled"]) - exact) < 1e-4 * abs(exact)
    text = window.text_content("#live-text")
    assert f"step by {step}" in text and "below 0.01 %" in text
    window.click("[data-kick=frame]")  # where a leaning rider drives the roll torque, the push adds to it
    assert window.evaluate(GOES_ON, 0)
    assert window.evaluate("page.live.run.ok && Math.max(...page.live.rows.map(r => Math.abs(r[1])))") > 1e-3


@in_browser
@pytest.mark.parametrize("mode", ["weave", "wobble"])
def test_the_coupling_keeps_the_modes_within_a_hundredth_of_a_percent(page, mode):
    exact = mf.modes("sharp_1971", "rider:mean_2011", [30.0])[mode].eigenvalue[0]
    found = page.window.evaluate(MODE_OF_THE_COUPLED_FMUS, exact.imag)
    assert complex(*found["exact"]) == pytest.approx(exact, rel=1e-9)
    assert abs(complex(*found["coupled"]) - exact) < 1e-4 * abs(exact)
