"""Which states of a component are the rates of its other states."""

import numpy as np

from fmus.declaration.component import Component
from fmus.expressions.functions import NUMERIC

ROUNDING = 1e-12  # of a derivative that is the rate itself


def rates_of_states(component: Component) -> dict[str, list[str]]:
    """The states that are the rate of a state, by the name of each state."""
    states = component.states
    # NumPy numbers give inf or nan, and no exception, where the equations are not defined at the start values.
    start = {n: np.float64(x) for n, x in component.start_values().items()}
    with np.errstate(all="ignore"):
        rest = component.run(start, NUMERIC)
        probed = {n: component.run(start | {n: start[n] + 1.0}, NUMERIC) for n in states}
    return {
        name: [n for n in states if abs(probed[n][f"der({name})"] - rest[f"der({name})"] - 1.0) < ROUNDING]
        for name in states
    }
