"""Bootstrap of an identification: the spread of the parameters over repetitions of the measurement.

With five or more runs, runs are drawn with replacement; with fewer, noise of each band's own variance is put
on the measured apparent inertia. The fits run on all cores.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from fmus.support.parallel import parallel_map
from motofmi.frequency_response.frf import FRF
from motofmi.frequency_response.response import Response
from motofmi.identification.parameter_fit import Identification, identify

ENOUGH_RUNS = 5
CHUNK = 25  # fits in one task


def bootstrap(found: Identification, model: Response, count: int = 1000, seed: int = 0,
              bounds: Mapping[str, tuple[float, float]] | None = None,
              processes: int | None = None) -> np.ndarray:  # fmt: skip
    """Parameter vectors (count, np) from `count` repetitions, started at the best fit; the same for any
    number of processes."""
    model = Response(
        model.component.with_values(**dict(zip(found.names, found.values, strict=True))),
        model.input,
        model.output,
        found.names,
    )
    seeds = np.array_split(np.random.SeedSequence(seed).generate_state(count), -(-count // CHUNK))

    def fits(some: np.ndarray) -> np.ndarray:
        repetitions = [_repetition(found.frfs, np.random.default_rng(s)) for s in some]
        return np.array([identify(frfs, model, found.method, bounds, starts=1).values for frfs in repetitions])

    return np.concatenate(parallel_map(fits, seeds, "bootstrap", processes))


def _repetition(frfs: Sequence[FRF], rng: np.random.Generator) -> list[FRF]:
    """The FRFs of a simulated repetition of the measurement."""
    if len(frfs) >= ENOUGH_RUNS:
        return [frfs[i] for i in rng.integers(len(frfs), size=len(frfs))]

    def noisy(frf: FRF) -> FRF:
        error = np.sqrt(frf.variance / 2) * (
            rng.standard_normal(len(frf.variance)) + 1j * rng.standard_normal(len(frf.variance))
        )
        return replace(frf, inertance=1 / (frf.apparent_inertia + error))

    return [noisy(frf) for frf in frfs]
