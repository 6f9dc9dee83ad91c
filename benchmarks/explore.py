"""The page of `motofmi explore` in headless Chromium: its numbers and names against Python at random settings, names
along random moves of the sliders, the time from a slider's move to the drawing, and the live co-simulation."""

import tempfile
from pathlib import Path
from statistics import median

import motofmi as mf
from tests.browser import chromium
from tests.explore_page import (
    FLEXIBLE,
    MODE_OF_THE_COUPLED_FMUS,
    MODES_IN_THE_PAGE,
    RIGID,
    Opened,
    differing_modes,
    eigenvalue_error,
    modes_in_python,
    random_settings,
)

# Milliseconds from the event of a slider to the end of the drawing, layout included, without the fine grid, which
# follows the last move.
SLIDER = """async ({moves}) => {
  page.settle = () => {};
  const slider = document.getElementById("p-vehicle-trail"), low = Number(slider.min), high = Number(slider.max), spent = [];
  for (let k = 0; k < moves; k++) {
    slider.value = low + (high - low) * (0.2 + 0.6 * ((k * 0.618) % 1));
    const start = performance.now();
    slider.dispatchEvent(new Event("input"));
    await new Promise(done => requestAnimationFrame(() => { document.body.getBoundingClientRect(); done(); }));
    spent.push(performance.now() - start);
  }
  delete page.settle;
  return spent;
}"""

# Milliseconds from the end of the moves to the drawing with all speeds, without the pause before it.
SETTLED = """({moves}) => Array.from({length: moves}, (_, k) => {
  page.settings.B.values["vehicle.trail"] = 0.08 + 0.001 * k;
  page.waiting.add("B");
  const start = performance.now();
  page.settle();
  document.body.getBoundingClientRect();
  return performance.now() - start;
})"""

# Seconds simulated in a second by the two FMUs in Chromium.
RATE = """({steps}) => {
  const run = new CoSimulation(page.settings.parts("B", page.libraries), 30);
  run.disturb({steer_torque: 1});
  for (let k = 0; k < steps / 10; k++) run.advance();
  const start = performance.now();
  for (let k = 0; k < steps; k++) run.advance();
  const rate = steps * run.step / ((performance.now() - start) / 1000);
  run.free();
  return rate;
}"""

# Random moves of one slider by up to a hundredth of its range. Two names are swapped when each has the other's former
# eigenvalue: both moved further than to that of the other.
SWAPS = """({moves, seed}) => {
  let state = seed;
  const random = () => (state = (state * 1103515245 + 12345) % 2147483648) / 2147483648;
  const settings = page.settings, keys = Object.entries(settings.components("B")).flatMap(([part, c]) => Object.keys(c.values)
    .filter(n => part === "device" || PROMINENT.includes(n)).map(n => `${part}.${n}`)), place = Object.fromEntries(keys.map(k => [k, 0.3]));
  let last = null, swaps = 0, count = 0;
  for (let k = 0; k < moves; k++) {
    const key = keys[Math.floor(random() * keys.length)], at = key.indexOf("."), own = settings.components("B")[key.slice(0, at)].values[key.slice(at + 1)];
    place[key] = Math.min(Math.max(place[key] + 0.02 * (random() - 0.5), 0.1), 0.9);
    const [low, high] = range(settings.row("B", key), own);
    settings.B.values[key] = low + place[key] * (high - low);
    page.compute("B", COARSE);
    const found = page.found.B, i = nearestIndex(found.points, 30), now = Object.fromEntries(Object.entries(found.curves).map(([m, c]) => [m, [c.re[i], c.im[i]]]));
    const far = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]), modes = Object.keys(now).filter(m => last?.[m]);
    for (const a of modes) for (const b of modes) if (a < b) {
      count++;
      if (far(now[a], last[b]) < far(now[a], last[a]) && far(now[b], last[a]) < far(now[b], last[b])) swaps++;
    }
    last = now;
  }
  return {moves, pairs: count, swaps};
}"""


def slider_times(window, moves: int = 60) -> tuple[list[float], float]:
    """Milliseconds from each move to its drawing, and the mean of the processor's time for one, layout included."""
    session = window.context.new_cdp_session(window)
    session.send("Performance.enable", {"timeDomain": "threadTicks"})

    def busy() -> float:
        return {m["name"]: m["value"] for m in session.send("Performance.getMetrics")["metrics"]}["TaskDuration"]

    window.evaluate(SLIDER, {"moves": 20})  # the compilers of the browser warm up
    before = busy()
    spent = window.evaluate(SLIDER, {"moves": moves})
    return spent, 1000 * (busy() - before) / moves


def live_run(window, rider: str) -> dict:
    """Communication step [s], rate over real time, and the errors of the modes of the FMUs that step in the page, as
    shares.

    The rate is the largest of ten: other work on the machine only lowers it.
    """
    rates = [window.evaluate(RATE, {"steps": 20_000}) for _ in range(10)]
    modes, errors = mf.modes("sharp_1971", f"rider:{rider}", [30.0]), {}
    for mode in ("weave", "wobble", "rider_wobble"):
        exact = modes[mode].eigenvalue[0]
        found = window.evaluate(MODE_OF_THE_COUPLED_FMUS, exact.imag)
        errors[mode] = abs(complex(*found["coupled"]) - exact) / abs(exact)
    return {"rate": max(rates), "step_s": found["step"], "mode_error": errors}


def run(progress, settings: int = 1000, moves: int = 10_000, at_once: int = 10,
        vehicles: tuple[str, ...] = RIGID + FLEXIBLE) -> dict:  # fmt: skip
    """Errors and names at random settings, swapped names along random moves, milliseconds of a slider, and the
    rate and the modes of the live co-simulation."""
    with tempfile.TemporaryDirectory() as folder, chromium() as browser:
        path = mf.explore(out=Path(folder) / "page.html").path
        opened, size = Opened(browser, path), path.stat().st_size
        window = opened.window
        live = live_run(window, "mean_2011")
        spent, busy = slider_times(window)
        settled = median(window.evaluate(SETTLED, {"moves": 20}))
        swapped = [window.evaluate(SWAPS, {"moves": 100, "seed": k}) for k in progress(range(moves // 100), "moves")]
        full = mf.explore("sharp_1971", "rider:full_mean_2011", out=Path(folder) / "full.html").path
        full_live = live_run(Opened(browser, full).window, "full_mean_2011")
        opened = Opened(browser, path)
        cases = list(random_settings(opened.window.evaluate("page.data"), 7, settings, vehicles))
        worst, equal = 0.0, 0
        for first in progress(range(0, settings, at_once), "random settings"):
            part = cases[first : first + at_once]
            for case, found in zip(part, opened.window.evaluate(MODES_IN_THE_PAGE, part), strict=True):
                expected = modes_in_python(case)
                worst = max(worst, eigenvalue_error(found, expected))
                equal += not differing_modes(found, expected)
    return {
        "settings": settings,
        "eigenvalue_error": worst,
        "settings_with_equal_names": equal / settings,
        "slider_moves": sum(s["moves"] for s in swapped),
        "swapped_names": sum(s["swaps"] for s in swapped),
        "slider_median_ms": median(spent),
        "slider_processor_ms": busy,
        "slider_speeds": 60,
        "settled_speeds": 591,
        "settled_ms": settled,
        "live": live,
        "live_full_rider": full_live,
        "page_MB": size / 1e6,
    }
