"""Step responses: recordings that begin at rest, with constant inputs.

A slide that moves at constant rate under a constant force is fitted as well by any mass with that initial rate, and a
displacement from an unknown zero by any spring: with free initial states and offsets a constant input need not have an
influence, and friction cannot be identified. The initial states of a step response are known: it begins at rest, and
its inputs alone cause its motion.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from fmus.support.errors import InputError
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.initial_fit import equal_noise, with_best_interpolation
from motofmi.gap.estimation.starting_values import first_values
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run import SampledRun
from motofmi.recordings.resampling import sensor_noise

# Ratio of the misfit's standard deviation to that of the motion, from which on the motion is not the response to the
# inputs. It is 1 for a mass that is released from a deflection.
UNEXPLAINED = 0.5
# Standard deviation of an input over its mean, up to which the input is constant.
CONSTANT = 0.1
# Ratio of the first rate of an interval to its rms, below which the interval begins at rest. A mass with a time
# constant of one sampling interval reaches, over the first one, a mean of 0.37 of its final rate.
AT_REST = 0.4
ABOVE_NOISE = 10.0  # ratio of the rms of these differences to the noise, from which on they are those of the motion
TINY = 1e-300  # least standard deviation by which is divided: an output may be constant in an interval


def are_step_responses(runs: Sequence[SampledRun]) -> bool:
    """Whether every interval of the runs begins at rest, with inputs that are constant and not all zero."""
    return all(_has_constant_inputs(run) and _begins_at_rest(run) for run in runs)


def fit_from_rest(found: Fit) -> Fit | None:
    """The base of a fit, fitted again with every interval beginning at rest; None where the recordings are no step
    responses, or the inputs do not explain their motion."""
    runs = found.runs
    if not are_step_responses(runs):
        return None
    fitted: Any = found.model
    experiment = replace(fitted.experiment, from_rest=True)
    model = FreeInitialStateModel(experiment)
    whole = [replace(run, experiment=experiment, stable_length=None).cut(len(run.measured)) for run in runs]
    best: Fit | None = None
    for start in first_values(model, whole):
        with suppress(InputError):  # it cannot be simulated from this start
            again = fit(model, whole, start, beat=np.inf if best is None else best.chi2)
            best = again if best is None or again.chi2 < best.chi2 else best
    if best is None or not _explains_the_motion(best):
        return None
    best = with_best_interpolation(model, best)
    return fit(model, equal_noise(best.runs, best), best.x)


def _explains_the_motion(found: Fit) -> bool:
    """Whether a fit from rest leaves less than the share `UNEXPLAINED` of the motion in most intervals."""
    model: Any = found.model
    shares: list[float] = []
    for index, run in enumerate(found.runs):
        residuals = model.residuals_and_motion(run, found.of_run(index))[0]
        ends = np.cumsum([last - first for first, last in run.segments])[:-1]
        for left, (first, last) in zip(np.split(residuals, ends), run.segments, strict=True):
            motion = np.maximum(run.measured[first:last].std(axis=0), TINY)
            shares.append(float(np.max(left.std(axis=0) / motion)))
    return bool(np.median(shares) < UNEXPLAINED)


def _has_constant_inputs(run: SampledRun) -> bool:
    """Whether every recorded input is constant over each interval, with one that is not zero, and none is a motion."""
    inputs = [run.recording[name][first:last] for name in run.experiment.inputs for first, last in run.intervals]
    constant = all(u.std() <= CONSTANT * abs(u.mean()) for u in inputs)
    return not run.experiment.imposed and constant and any(np.any(u) for u in inputs)


def _begins_at_rest(run: SampledRun) -> bool:
    """Whether every interval begins at rest, by those outputs that are deflections or rates of elements.

    The first rate, of a deflection by differences, is compared with the rms of its interval.
    """
    elements = list(run.experiment.component.elements.values())
    rates = {element.rate for element in elements}
    known = rates | {element.deflection for element in elements}
    seen = [(name, y) for name, y in zip(run.experiment.outputs, run.measured.T, strict=True) if name in known]
    return bool(seen) and all(
        _first_share(y[first:last] if name in rates else _rates_of(y[first:last])) < AT_REST
        for name, y in seen
        for first, last in run.intervals
    )


def _rates_of(y: np.ndarray) -> np.ndarray:
    """The differences of a deflection (n,) over the fewest samples in which it changes by more than its noise, such as
    the step of an encoder."""
    noise, lag = sensor_noise(y), 1
    while lag < len(y) // 4 and np.std(y[lag:] - y[:-lag]) < ABOVE_NOISE * noise:
        lag *= 2
    return y[lag:] - y[:-lag]


def _first_share(rate: np.ndarray) -> float:
    """The first value of a rate (n,) over its rms; infinite where it does not move."""
    rms = float(np.sqrt(np.mean(rate**2)))
    return abs(float(rate[0])) / rms if rms > 0 else np.inf
