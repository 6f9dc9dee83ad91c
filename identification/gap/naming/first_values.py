"""From where the first fit of a base begins, whose values may say nothing of the component that was recorded.

    own        the values that it has
    as fast    time in another unit, p -> p tau^-s (s the exponent of seconds in p's unit), tau = measured over own frequency
    imposed    those of the force that the measured motion takes: linear in mass, damping and stiffness, so found from anywhere
    as far     all times how much more it moves from rest than was measured
    and stiffer or softer
"""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import product

import numpy as np

from fmus.errors import InputError
from fmus.imposed import Imposed
from fmus.linear import linearise
from fmus.units import BASE, unit
from identification.gap.data.sampled import Sampled, sampled
from identification.gap.models.free_start import FreeStart
from identification.gap.naming.fitting import fit

STIFFER = 2.3  # logarithm of the factor
PATIENCE = 40  # iterations


def first_values(model: FreeStart, runs: Sequence[Sampled]) -> Iterator[np.ndarray]:
    """Vectors of a fit, the likeliest first; each is only made when it is asked for."""
    own = model.start()
    yield own
    base = np.arange(len(own)) < len(model.base)
    with suppress(InputError):
        for fast in _as_fast(model, runs, own):
            yield fast + too_large(model, runs, fast) * base
    yield from _imposed(model, runs)
    as_far = own + too_large(model, runs, own) * base
    yield as_far
    stiff = np.array([model.component.table[n].unit in ("N.m/rad", "N/m") for n in model.base] + [False] * len(model.own))
    yield from (x + shift * stiff for x in (as_far, own) for shift in (STIFFER, -STIFFER))


def too_large(model: FreeStart, runs: Sequence[Sampled], x: np.ndarray) -> float:
    """The logarithm of how much more the component answers from rest than was measured; 0 where nothing drives it."""
    try:
        ratios = np.concatenate([np.std(model.from_rest(run, x), axis=0) / np.std(run.measured, axis=0) for run in runs])
    except InputError:
        return 0.0
    ratio = float(np.median(ratios))
    return float(np.log(np.clip(ratio, 1e-6, 1e6))) if ratio > 0 else 0.0


def poles(model: FreeStart, x: np.ndarray) -> np.ndarray:
    """The poles (nx,) of the component's own motion about its rest; none where that is imposed."""
    component, values = model.component, model.values(x[: len(model.names)])
    if isinstance(component, Imposed) or not component.states:
        return np.zeros(0)
    return np.linalg.eigvals(linearise(component.with_values(**{n: values[n] for n in component.values})).A)


def _imposed(model: FreeStart, runs: Sequence[Sampled]) -> Iterator[np.ndarray]:
    """What fits the recorded input, where the first output that it accelerates is imposed. The motion's noise biases it."""
    test = runs[0].test
    seen = [n for n in test.outputs if n in test.component.states]
    driving = [n for n in test.driven if all(np.ptp(run.recording[n]) > 0 for run in runs)]
    for state, effort in product(seen, driving):
        with suppress(InputError):
            others = tuple(n for n in test.inputs if n != effort)
            turned = FreeStart(replace(test, inputs=(state, *others), outputs=(effort,), imposed=state, zeros={}, measured_effects={}))
            found = fit(turned, [sampled(run.recording, turned.stand) for run in runs], turned.start(), iterations=PATIENCE)
            yield np.concatenate([found.x[: len(model.base)], model.start()[len(model.base) :]])
            return


def _as_fast(model: FreeStart, runs: Sequence[Sampled], x: np.ndarray) -> Iterator[np.ndarray]:
    """The values with time in another unit, so that the slowest oscillation is as fast as what was measured."""
    own = np.abs([pole for pole in poles(model, x) if pole.imag > 0])
    if len(own):
        tau = 2 * np.pi * float(np.median([run.middle_frequency for run in runs])) / own.min()
        seconds = [unit(model.component.table[n].unit).exponents[BASE.index("s")] for n in model.base]
        yield x - np.log(tau) * np.array(seconds + [0] * len(model.own))
