"""Starting values of the initial fit, for a base whose values may be far from the recorded component.

They are tried in this order:

1. the values that fit the recordings in the frequency domain (see `frequency_domain_fit`);
2. the values of the component;
3. the values that fit the force which the measured motion requires; this force is linear in mass, damping and
   stiffness, so that the result does not depend on the start;
4. all values times the ratio of the simulated motion (from rest) to the measured one;
5. the stiffnesses multiplied and divided by exp(STIFFER).

Where several degrees of freedom are all driven and recorded, the values by inverse dynamics come before (see
`inverse_dynamics`), and the others are tried only where these cannot be simulated.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress

import numpy as np

from fmus.composition.imposed_motion import ImposedMotion
from fmus.declaration.component import Component
from fmus.declaration.units import is_stiffness
from fmus.linear_analysis.linearisation import linearise
from fmus.support.errors import InputError
from motofmi.gap.estimation.equation_error import effort_model
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.frequency_domain_fit import frequency_domain_start
from motofmi.gap.estimation.inverse_dynamics import imposed_motions, inverse_dynamics_fit
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run import SampledRun

STIFFER = 2.3  # logarithm of the factor
MAX_ITERATIONS = 40  # of a fit from one start


def values_by_inverse_dynamics(model: FreeInitialStateModel, runs: Sequence[SampledRun]) -> np.ndarray | None:
    """The starting vector by inverse dynamics; None where that is not possible."""
    found = inverse_dynamics_fit(model, motions, model.start()) if (motions := imposed_motions(model, runs)) else None
    return found[0] if found else None


def first_values(model: FreeInitialStateModel, runs: Sequence[SampledRun]) -> Iterator[np.ndarray]:
    """The other starting vectors, each once, the most promising first, computed on demand."""
    tried: list[np.ndarray] = []
    for x in _starting_vectors(model, runs):
        if not any(np.allclose(x, other) for other in tried):
            tried.append(x)
            yield x


def _starting_vectors(model: FreeInitialStateModel, runs: Sequence[SampledRun]) -> Iterator[np.ndarray]:
    own = model.start()
    base = np.arange(len(own)) < len(model.base)
    by_frequency = frequency_domain_start(model, runs)
    if by_frequency is not None:
        yield np.concatenate([by_frequency, own[len(by_frequency) :]])
    yield own
    yield from _imposed(model, runs)
    as_far = own + too_large(model, runs, own) * base
    yield as_far
    stiff = np.array([is_stiffness(model.component.table[n].unit) for n in model.base] + [False] * len(model.own))
    yield from (x + shift * stiff for x in (as_far, own) for shift in (STIFFER, -STIFFER))


def too_large(model: FreeInitialStateModel, runs: Sequence[SampledRun], x: np.ndarray) -> float:
    """The logarithm of simulated (from rest) over measured motion; 0 where nothing drives the component."""
    try:
        ratios = np.concatenate(
            [np.std(model.from_rest(run, x), axis=0) / np.std(run.measured, axis=0) for run in runs]
        )
    except InputError:
        return 0.0
    ratio = float(np.median(ratios))
    return float(np.log(np.clip(ratio, 1e-6, 1e6))) if ratio > 0 else 0.0


def poles(model: FreeInitialStateModel, x: np.ndarray, **at: np.ndarray) -> np.ndarray:
    """The poles (..., nx) of the component's free motion about rest, or about points at which some of its variables
    have given values (...); none where a motion is imposed, zero at points at which the equations are not finite."""
    component, values = model.component, model.values(x[: len(model.names)])
    if isinstance(component, ImposedMotion) or not component.states:
        return np.zeros(0)
    with np.errstate(all="ignore"):
        matrices = linearise(component.with_values(**within_bounds(component, values)), **at).A
    finite = np.all(np.isfinite(matrices), axis=(-2, -1), keepdims=True)
    return np.linalg.eigvals(np.where(finite, matrices, 0.0))


def within_bounds(component: Component, values: Mapping[str, float]) -> dict[str, float]:
    """The values of a component's parameters, each moved to its nearest bound where a fit has left its bounds."""
    table = component.table
    return {n: float(np.clip(values[n], table[n].min, table[n].max)) for n in component.values}


def _imposed(model: FreeInitialStateModel, runs: Sequence[SampledRun]) -> Iterator[np.ndarray]:
    """The values that fit the recorded input with an output imposed as motion; the noise of that output biases them."""
    with suppress(InputError):
        if (turned := effort_model(model, runs)) is not None:
            found = fit(*turned, turned[0].start(), iterations=MAX_ITERATIONS)
            yield np.concatenate([found.x[: len(model.base)], model.start()[len(model.base) :]])
