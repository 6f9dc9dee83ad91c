"""One fit against scipy's curve_fit as one would write it in MATLAB; a thousand bootstrap fits; reading a recording.

The rival is the 2011 paper's eq. 6 with the paper's method: the Nyquist plane, bounds, scipy's trust-region fit
(MATLAB's lsqcurvefit) with derivatives by differences. The same without bounds stands beside it.
"""

import tempfile
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from statistics import median
from time import perf_counter

import numpy as np
from scipy.optimize import curve_fit

from fmus.support.parallel import processes
from motofmi.frequency_response.estimators import estimate
from motofmi.frequency_response.excitation import sweep
from motofmi.frequency_response.frf import exact_frf
from motofmi.identification.bootstrap import bootstrap
from motofmi.identification.parameter_fit import Problem, identify
from motofmi.recordings.reading import read_recording, write_recording
from motofmi.virtual_rig.simulated_rig import steer_test
from motofmi.workflows.measured_rider import rig_response
from rider_fmu import riders
from rider_fmu.rigs.handlebar import HANDLEBAR_INERTIA

TYPICAL = np.array([0.2, 0.8, 1000.0, 100.0, 20.0, 5.0])


def run(progress, starts: int = 40, fits: int = 1000, rounds: int = 5) -> dict:
    """Seconds and ratios, medians over paired rounds."""
    recording = steer_test(riders.load("mean_2011"), HANDLEBAR_INERTIA, sweep(), seed=1)
    return {"fit": fit(recording, progress(range(starts), "fits")), "bootstrap": resampled(recording, fits),
            "reading": reading(recording, progress(range(rounds), "reading"))}  # fmt: skip


def inertance(omega, Is, It, ka, kt, ca, ct):
    """Eq. 6, real parts before imaginary parts."""
    torso = -(omega**2) * It + 1j * omega * (ca + ct) + ka + kt
    value = -torso * omega**2 / (-((1j * omega * ca + ka) ** 2) + (-(omega**2) * Is + 1j * omega * ca + ka) * torso)
    return np.concatenate([value.real, value.imag])


def fit(recording, starts) -> dict:
    """The same points, the same sum of squares, the same starting values."""
    measured = estimate(recording)
    target = np.concatenate([measured.inertance.real, measured.inertance.imag])
    problem = Problem([exact_frf(measured.frequency, measured.inertance)], rig_response(), "nyquist")
    seconds, costs = [], []
    for seed in starts:
        start = TYPICAL * np.exp(0.7 * np.random.default_rng(seed).standard_normal(6))
        times, cost = zip(*(_timed(solve, start) for solve in (
            lambda p: problem.solve(np.log(p))[1],
            lambda p: _cost(measured.omega, target, curve_fit(inertance, measured.omega, target, p, bounds=(0, np.inf))[0]),
            lambda p: _cost(measured.omega, target, curve_fit(inertance, measured.omega, target, p)[0]))), strict=True)  # fmt: skip
        seconds.append(times)
        costs.append(cost)
    ours, bounded, free = np.array(seconds).T
    best = np.min(costs)
    reached = np.mean(np.array(costs) < best * (1 + 1e-6), axis=0)
    return {"fit_ms": 1e3 * median(ours), "curve_fit_bounded_ms": 1e3 * median(bounded), "curve_fit_free_ms": 1e3 * median(free),
            "ratio_bounded": median(bounded / ours), "ratio_free": median(free / ours),
            "same_or_better_optimum": bool(np.all(np.array(costs)[:, :1] <= np.array(costs)[:, 1:] * (1 + 1e-9))),
            "starts_that_reach_the_best": dict(zip(("fit", "bounded", "free"), reached.tolist(), strict=True))}  # fmt: skip


def _timed(solve, start) -> tuple[float, float]:
    before = perf_counter()
    try:
        cost = solve(start)
    except RuntimeError:  # curve_fit does not converge
        cost = np.inf
    return perf_counter() - before, cost


def _cost(omega, target, p) -> float:
    return float(np.sum((inertance(omega, *p) - target) ** 2) / 2)


def resampled(recording, fits: int) -> dict:
    """Seconds for `fits` bootstrap fits on one core and on all, processes started included."""
    model = rig_response()
    found = identify([estimate(recording)], model)
    seconds = {}
    for count in sorted({1, processes()}):
        before = perf_counter()
        bootstrap(found, model, fits, processes=count)
        seconds[count] = perf_counter() - before
    return {"fits": fits, "seconds": seconds, "speed_up": seconds[1] / seconds[max(seconds)]}


def reading(recording, rounds) -> dict:
    """A 200 s recording as CSV: MB/s with units and checks, and with the FRF, against bare readers."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sweep.csv"
        write_recording(recording, path)
        readers: dict[str, Callable[[Path], object]] = {"read_recording": read_recording, "read and reduced to an FRF": lambda p: estimate(read_recording(p)),
                   "numpy.loadtxt": lambda p: np.loadtxt(p, delimiter=",", skiprows=1)}  # fmt: skip
        if find_spec("pandas"):
            readers["pandas.read_csv"] = import_module("pandas").read_csv
        seconds: dict[str, list[float]] = {name: [] for name in readers}
        for _ in rounds:
            for name, read in readers.items():
                before = perf_counter()
                read(path)
                seconds[name].append(perf_counter() - before)
        size = path.stat().st_size / 1e6
    return {"file_MB": size, "MB_per_s": {name: size / median(times) for name, times in seconds.items()}}
