"""Where the equations of a component are not finite, such as the square root of a level that a simulation takes below
zero.

The search for values simulates far from the recorded motion. Each state is varied by itself over twice its recorded
range, the others at the middle of theirs.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from fmus.declaration.component import Component
from fmus.expressions.functions import NUMERIC
from fmus.support.errors import InputError
from motofmi.gap.preprocessing.sampled_run import SampledRun

POINTS = 41  # of each range
HINT = (
    "its {} {} not finite where {} is {:.3g} {}, which a search for values may reach: continue the equations there, as in "
    "m.sqrt(m.where(h > 1e-6, h, 1e-6 + 0 * h))"
)


@contextmanager
def where_not_finite(component: Component, runs: Sequence[SampledRun]) -> Iterator[None]:
    """Adds to an InputError that is raised meanwhile where the equations of the component are not finite."""
    try:
        yield
    except InputError as error:
        if not (hint := hint_where_not_finite(component, runs)):
            raise
        raise InputError(f"{error}; {hint}") from None


@np.errstate(all="ignore")
def hint_where_not_finite(component: Component, runs: Sequence[SampledRun]) -> str:
    """A sentence on the first state near whose recorded range a rate is not finite; empty without one."""
    ranges = {name: _range_of(component, name, runs) for name in (*component.states, *component.inputs)}
    middle = {name: (low + high) / 2 for name, (low, high) in ranges.items()} | {"time": 0.0}
    for state in component.states:
        low, high = ranges[state]
        values = np.linspace(low - (high - low) / 2, high + (high - low) / 2, POINTS)
        made = component.run({**component.values, **middle, state: values}, NUMERIC)
        rates = {n: y + 0 * values for n, y in made.items() if n.startswith("der(")}
        found = [name for name, rate in rates.items() if not np.all(np.isfinite(rate))]
        if found:
            nearest = values[~np.isfinite(rates[found[0]])]
            nearest = nearest[np.argmin(np.abs(nearest - middle[state]))]
            verb = "is" if len(found) == 1 else "are"
            return HINT.format(" and ".join(found), verb, state, nearest, component.table[state].unit)
    return ""


def _range_of(component: Component, name: str, runs: Sequence[SampledRun]) -> tuple[float, float]:
    """The range of a recorded variable, otherwise one about zero of the size of its start value."""
    recorded = [run.recording[name] for run in runs if name in run.recording.columns]
    if recorded:
        return min(float(np.nanmin(y)) for y in recorded), max(float(np.nanmax(y)) for y in recorded)
    start = abs(component.table[name].start) or 1.0
    return -start, start
