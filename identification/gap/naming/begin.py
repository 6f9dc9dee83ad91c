"""The first fit of a base whose values may be far off: over short stretches first, in which errors cannot add up.

With the initial states of each stretch free, a wrong frequency loses its phase only a little, and the fit has few
minima; what it finds starts the fit over longer ones, and at last over whole segments. A component that is unstable
then stays cut, into stretches over which its own motion grows by a stated factor.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fmus.errors import InputError
from identification.gap.data.flexible import Density
from identification.gap.data.sampled import Sampled
from identification.gap.data.told import KINDS, is_rough
from identification.gap.models.free_start import FreeStart
from identification.gap.naming.first_values import PATIENCE, first_values, poles
from identification.gap.naming.fitted import Fit
from identification.gap.naming.fitting import fit

STRETCHES = (1.0, 3.0)  # periods of the motion's middle frequency
MOST = 24  # stretches of a run that a first fit looks at
GROWTH = 20.0  # of an unstable motion over a segment
GOOD = 2.0  # reduced chi-square at which no other start is tried
SAME = 0.02  # of it, within which two starts have led to the same
CLOSER = 0.9  # of chi-square: what another way to join an input's samples must reach


def begin(model: FreeStart, runs: Sequence[Sampled]) -> Fit:
    """The base fitted from wherever its values are; its runs are cut where the base is unstable.

    Raises InputError where no start can be simulated.
    """
    best: Fit | None = None
    for start in first_values(model, runs):
        before = best
        for periods in (STRETCHES, STRETCHES[1:], ()):
            try:
                found = _staged(model, runs, start, periods)
            except InputError:
                continue
            again = before is not None and max(found.reduced, before.reduced) < (1 + SAME) * min(found.reduced, before.reduced)
            best = found if best is None or found.reduced < best.reduced else best
            if best.reduced < GOOD or again:
                return _joined(model, best)
    if best is None:
        raise InputError(f"{model.component.name} cannot be simulated near its values: give it values nearer to the component that was recorded")
    return _joined(model, best)


def _staged(model: FreeStart, runs: Sequence[Sampled], start: np.ndarray, periods: Sequence[float]) -> Fit:
    x = start
    for each in periods:
        short = [_excerpt(run, int(each * run.recording.rate / run.middle_frequency)) for run in runs]
        x = fit(model, short, x, iterations=PATIENCE).x
    return fit(model, [stable_segments(model, run, x) for run in runs], x, iterations=PATIENCE)


def _excerpt(run: Sampled, length: int) -> Sampled:
    """Some of the run's short stretches, evenly spread over it."""
    cut = run.cut(max(length, 16))
    if len(cut.segments) <= MOST:
        return cut
    keep = np.unique(np.linspace(0, len(cut.segments) - 1, MOST).astype(int))
    reduction = cut.reduction
    chosen = {int(k): i for i, k in enumerate(keep)}
    places = [i for i, owner in enumerate(reduction.segment_of) if owner in chosen]
    sizes = np.cumsum([0] + [kept * reduction.outputs for _, _, kept in reduction.spans])
    rows = np.concatenate([np.arange(sizes[i], sizes[i + 1]) for i in places])
    spans, owners = [reduction.spans[i] for i in places], [chosen[reduction.segment_of[i]] for i in places]
    fewer = replace(reduction, spans=spans, segment_of=owners, columns=[reduction.columns[i] for i in rows])
    return replace(cut, segments=[cut.segments[i] for i in keep], reduction=fewer, data=cut.data[rows], deviation=cut.deviation[rows], guess={})


def stable_segments(model: FreeStart, run: Sampled, x: np.ndarray) -> Sampled:
    """The run, cut where the component's own motion would grow too far over the whole of it."""
    growth = float(np.max(poles(model, x).real, initial=0.0))
    length = int(np.log(GROWTH) / max(growth, 1e-9) * run.recording.rate)
    return run.cut(length) if length < run.segments[0][1] - run.segments[0][0] else run


def _joined(model: FreeStart, found: Fit) -> Fit:
    """The fit with the inputs joined between their samples in the way that fits best, where they are rough."""
    runs = found.runs
    if not any(is_rough(run.recording[n]) for run in runs for n in run.test.inputs if n != run.test.imposed):
        return found
    for kind in KINDS[1:]:
        other = fit(model, [run.with_told(kind) for run in runs], found.x)
        if other.chi2 < CLOSER * found.chi2:
            found = other
    return found


def equal_noise(runs: Sequence[Sampled], found: Fit) -> list[Sampled]:
    """The runs with white noise as large as what the fit leaves: a first guess where the base is far off."""
    wider, first = [], 0
    for run in runs:
        last = first + len(run.data)
        scale = float(np.mean(found.residuals[first:last] ** 2))
        wider.append(run.with_densities([Density(d.frequency, d.density * scale) for d in run.densities], run.noise_source))
        first = last
    return wider
