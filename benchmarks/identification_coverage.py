"""Are the standard errors of identified parameters correct? Hundreds of simulated tests.

One rider, 200 noisy sweeps: bias and scatter in standard errors, and how many of the 95 % intervals hold.
A rider who differs by 3 % from run to run: the same for the mean of several runs, and for single recordings
with that spread stated. The estimators' ratio to the true inertance at 1 to 1.5 Hz stands beside them.
"""

from collections.abc import Iterable

import numpy as np

from motofmi.frequency_response.estimators import estimate
from motofmi.frequency_response.excitation import sweep
from motofmi.identification.parameter_fit import identify
from motofmi.virtual_rig.simulated_rig import steer_test
from motofmi.workflows.measured_rider import PARAMETERS, rider_from, rig_response

MODEL = rig_response()
TRUTH = MODEL.values
RUN_TO_RUN = 0.03


def run(progress, seeds: int = 200, runs: int = 4) -> dict:
    """The studies with `seeds` simulated data sets each."""
    return {
        "one_rider": one_rider(progress(range(seeds), "one rider")),
        "papers_estimator": one_rider(progress(range(seeds), "the papers' estimator"), "steer_torque"),
        "estimators_1_to_1.5_Hz": estimators(progress(range(seeds), "estimators")),
        "single_recordings_of_a_changing_rider": changing_rider(
            progress(range(seeds), "changing rider, single"), 1, RUN_TO_RUN
        ),
        f"{runs}_runs_of_a_changing_rider": changing_rider(
            progress(range(seeds), f"changing rider, {runs} runs"), runs
        ),
    }


def recording(values: np.ndarray, seed: int):
    """A noisy sweep of a rider with values of PARAMETERS (6,)."""
    return steer_test(rider_from(values), values[0], sweep(), seed=seed, oversampling=2)


def one_rider(seeds: Iterable[int], reference: str = "") -> dict:
    """Per parameter: bias and scatter in standard errors, coverage of the 95 % interval."""
    found = [identify([estimate(recording(TRUTH, seed), reference)], MODEL, starts=1) for seed in seeds]
    return _statistics(found)


def changing_rider(seeds: Iterable[int], runs: int, run_to_run: float | None = None) -> dict:
    """The same for the means of `runs` recordings of a rider whose parameters differ by 3 % from run to run."""
    found = []
    for seed in seeds:
        changes = np.random.default_rng(10_000 + seed).normal(0, RUN_TO_RUN, (runs, len(TRUTH)))
        frfs = [estimate(recording(TRUTH * np.exp(change), 1000 * seed + k)) for k, change in enumerate(changes)]
        found.append(identify(frfs, MODEL, starts=1, run_to_run=run_to_run))
    return {"run_to_run": float(np.sqrt(np.mean([f.run_to_run**2 for f in found]))), "parameters": _statistics(found)}


def estimators(seeds: Iterable[int]) -> dict:
    """|estimate / truth| of the inertance from 1 to 1.5 Hz, by reference of the cross-spectra; the mean over the
    seeds."""
    ratios: dict[str, list] = {"steer_torque": [], "steer_angle": [], "steer_angle_command": []}
    for seed in seeds:
        run = recording(TRUTH, seed)
        for reference, values in ratios.items():
            frf = estimate(run, reference).between(1.0, 1.5)
            values.append(frf.apparent_inertia * MODEL(frf.omega))
    return {reference: (1 / np.abs(np.mean(values, axis=0))).tolist() for reference, values in ratios.items()}


def _statistics(found) -> dict:
    errors = np.log([f.values for f in found]) - np.log(TRUTH)
    stated = np.sqrt([np.diag(f.covariance) for f in found])
    return {
        name: {
            "bias_in_standard_errors": float(np.mean(e) / np.mean(s)),
            "scatter_over_standard_error": float(np.std(e, ddof=1) / np.mean(s)),
            "coverage_95": float(np.mean(np.abs(e) < 1.96 * s)),
            "standard_error_percent": float(100 * np.mean(s)),
        }
        for name, e, s in zip(PARAMETERS, errors.T, stated.T, strict=True)
    }
