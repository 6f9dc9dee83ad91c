"""The page of `motofmi explore` in a browser, and what is computed in it, beside the same in Python."""

import numpy as np
import pytest

import motofmi as mf
from tests.browser import needs_browser
from vehicle_fmu import MODES

SPEEDS = np.arange(1.0, 61.0)
PROMINENT = (
    "trail", "ground_trail", "caster_angle", "gravity", "steering_damping", "front_cornering_stiffness",
    "rear_cornering_stiffness", "front_cornering_stiffness_0", "rear_cornering_stiffness_0", "front_pKy1", "rear_pKy1",
)  # fmt: skip


def in_browser(test):
    """Marks a test that opens the page."""
    return pytest.mark.slow(needs_browser(test))


class Opened:
    """The page in a window of its own; what it logs and requests is in `complaints`."""

    def __init__(self, browser, path, address="", width=1280, **options):
        self.window = browser.new_page(viewport={"width": width, "height": 900}, reduced_motion="reduce", **options)
        self.complaints = []
        self.window.on("console", lambda message: self.complaints.append(message.text))
        self.window.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.window.on("request", lambda request: self._requested(request.url))
        self.own = path.as_uri()
        self.window.goto(f"{self.own}{address}")
        self.window.wait_for_selector("#charts svg")

    def _requested(self, url):
        if url.partition("#")[0] != self.own and not url.startswith(("data:", "blob:")):
            self.complaints.append(url)

    def drawn(self):
        """After the next frame, in which the page draws what has changed, and with all speeds."""
        self.window.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done())))")
        self.window.evaluate("page.settle()")

    def curves(self):
        return self.window.evaluate(
            "[...document.querySelectorAll('#charts .curve path')].map(p => p.getAttribute('d')).join()"
        )


MODES_IN_THE_PAGE = """async (cases) => cases.map(({vehicle, device, changes}) => {
  const settings = Object.assign(Object.create(Settings.prototype), {data: page.data, A: {vehicle, device, values: changes}});
  const system = new Coupled(settings.parts("A", page.libraries)), found = namedModes(system);
  const at = found.points.map((p, i) => i).filter(i => Math.abs(found.points[i] - Math.round(found.points[i])) < 1e-9);
  const pick = ({re, im}) => at.map(i => [re[i], im[i]]);
  system.free();
  return {spectra: at.map(i => [[...found.spectra[i].re], [...found.spectra[i].im]]), unstable: found.unstable, mixed: found.mixed,
          curves: Object.fromEntries(Object.entries(found.curves).map(([mode, curve]) => [mode, pick(curve)]))};
})"""


RIGID, FLEXIBLE = ("sharp_1971", "reference_2011", "benchmark_bicycle"), ("sharp_1994", "tum_2020")


def random_settings(data, seed, count, vehicles=RIGID + FLEXIBLE):
    """Vehicles and devices with random values of the parameters that the page has sliders for."""
    rng, modules = np.random.default_rng(seed), data["modules"]
    # Of the full rider arms that do not reach the bar are refused, and leaning riders do not fit every vehicle.
    devices = [
        n for n, c in data["choices"].items() if modules[c["module"]]["title"] not in ("FullRider", "RiderInRoll")
    ]
    for _ in range(count):
        vehicle, device = str(rng.choice(vehicles)), str(rng.choice(["none", *devices]))
        parts = {"vehicle": data["vehicles"][vehicle]} | (
            {} if device == "none" else {"device": data["choices"][device]}
        )
        changes = {
            f"{part}.{name}": float(value * rng.uniform(0.6, 1.7))
            for part, component in parts.items()
            for name, value in component["values"].items()
            if part == "device" or name in PROMINENT
        }
        yield {"vehicle": vehicle, "device": device, "changes": changes}


def modes_in_python(case):
    """The same setting through the public functions."""
    device = case["device"]
    named = None if device == "none" else f"damper:{device[7:]}" if device.startswith("damper_") else f"rider:{device}"
    return mf.modes(case["vehicle"], named, SPEEDS, set=case["changes"])


def complex_numbers(re, im):
    """Complex numbers from their parts, NaN where the page has none."""
    return np.array(re, float) + 1j * np.array(im, float)


def eigenvalue_error(found, expected):
    """The largest distance of an eigenvalue of the page to that of Python, relative to the largest eigenvalue."""
    errors = []
    for parts, eigenvalues in zip(found["spectra"], expected.eigenvalues, strict=True):
        apart = np.abs(complex_numbers(*parts)[:, None] - eigenvalues[None])
        errors.append(max(apart.min(axis=0).max(), apart.min(axis=1).max()) / np.abs(eigenvalues).max())
    return max(errors)


def differing_modes(found, expected):
    """The modes that have another eigenvalue in the page than in Python at some speed, or are in one of them alone."""
    differ = []
    for mode in MODES:
        ours = complex_numbers(*zip(*found["curves"].get(mode, [(None, None)] * len(SPEEDS)), strict=True))
        theirs = expected[mode].eigenvalue
        if not np.allclose(ours, theirs, rtol=1e-6, atol=1e-6, equal_nan=True):
            differ.append(mode)
    return differ


MODE_OF_THE_COUPLED_FMUS = """(wanted) => {
  const parts = page.settings.parts("B", page.libraries), system = new Coupled(parts), {n} = system, speed = 30;
  const found = eigen(system.matrix(speed), n), left = complexInverse(found.vectorRe, found.vectorIm, n), initial = {};
  const j = found.im.findIndex(im => Math.abs(im - wanted) < 0.5);
  system.states.forEach((s, i) => { const [part, name] = s.split("."); (initial[part] ??= {})[name] = 1e-3 * found.vectorRe[i * n + j]; });
  const run = new CoSimulation(parts, speed, initial), h = run.step;
  const coordinate = () => { const states = run.states(); let a = 0, b = 0;
    system.states.forEach((s, i) => { const [part, name] = s.split("."), x = states[part][name]; a += left[2 * (j * n + i)] * x; b += left[2 * (j * n + i) + 1] * x; });
    return [a, b]; };
  for (let k = 0; k < 20; k++) run.advance();
  const start = coordinate(), steps = Math.round(4 * 2 * Math.PI / found.im[j] / h);
  for (let k = 0; k < steps; k++) run.advance();
  const end = coordinate(), time = steps * h, turns = Math.round(found.im[j] * time / 2 / Math.PI);
  const angle = Math.atan2(end[1], end[0]) - Math.atan2(start[1], start[0]), expected = found.im[j] * time;
  const phase = angle + 2 * Math.PI * Math.round((expected - angle) / (2 * Math.PI));
  run.free(); system.free();
  return {step: h, exact: [found.re[j], found.im[j]], coupled: [Math.log(Math.hypot(...end) / Math.hypot(...start)) / time, phase / time]};
}"""
