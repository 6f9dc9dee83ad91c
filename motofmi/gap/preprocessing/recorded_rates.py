"""Recorded states of which one is the rate of another: their columns must agree.

    x(t_2) - x(t_1) = k integral of y dt + o (t_2 - t_1),   k = 1

k differs from 1 where a sign or a unit of a column is wrong, and o is the offset of the rate's sensor. Both follow from
least squares over intervals of equal length. Noise, drift and lags of the sensors reduce the correlation of both sides:
without it nothing is concluded.
"""

from collections.abc import Sequence

import numpy as np
from scipy.integrate import cumulative_trapezoid

from fmus.declaration.component import Component
from fmus.declaration.units import unit
from fmus.support.errors import InputError
from motofmi.gap.experiments.state_rates import rates_of_states
from motofmi.recordings.recording import Recording

# Numbers of equal intervals of a recording: in long ones noise is small beside the change, in short ones drift is. Those
# with the larger correlation are taken.
INTERVALS = (20, 200)
CORRELATED = 0.9  # correlation [1] of both sides from which their ratio is that of the columns
MOST = 2.0  # ratio, or its inverse, from which it is a wrong unit and not the error of a sensor's scale


def require_rates(component: Component, runs: Sequence[Recording], imposed: str = "") -> None:
    """Raises InputError where a recorded state and its recorded rate contradict each other by their sign or unit.

    The rate of an imposed state is not compared with it.
    """
    rows = component.table
    for name, rates in rates_of_states(component).items():
        for rate in rates:
            of_unit = unit(rows[rate].unit).exponents == unit(f"{rows[name].unit}/s").exponents
            for run in runs if of_unit and name != imposed else ():
                if {name, rate} <= run.columns.keys() and (ratio := ratio_of_rates(run, name, rate)) is not None:
                    _require(ratio, run, name, rate)


def ratio_of_rates(run: Recording, name: str, rate: str) -> float | None:
    """The change [1] of a recorded state over the integral of its recorded rate; None where they are not correlated."""
    integral = cumulative_trapezoid(run[rate], run.time, initial=0.0)
    ratio, correlation = max(
        (_of_intervals(run, name, integral, count) for count in INTERVALS), key=lambda r: abs(r[1])
    )
    return ratio if abs(correlation) >= CORRELATED else None


def _of_intervals(run: Recording, name: str, integral: np.ndarray, count: int) -> tuple[float, float]:
    """The ratio by so many intervals of equal length without a gap, and the correlation; zeros without any motion."""
    edges = np.unique(np.linspace(0, len(run.time) - 1, count + 1).astype(int))
    spans, *sides = (np.diff(each[edges]) for each in (run.time, run[name], integral))
    whole = (spans < 1.5 * np.median(spans)) & np.all(np.isfinite(sides), axis=0)
    change, predicted = (side[whole] - np.mean(side[whole]) if whole.any() else np.zeros(1) for side in sides)
    product, power = float(change @ predicted), float(predicted @ predicted)
    lengths = float(np.linalg.norm(change)) * power**0.5
    return (product / power, product / lengths) if lengths else (0.0, 0.0)


def _require(ratio: float, run: Recording, name: str, rate: str) -> None:
    if not 1 / MOST < ratio < MOST:
        raise InputError(
            f"{run.file or run.name}: {rate} is the rate of {name}, and {name} changes by {ratio:.3g} times its "
            f"integral; expected 1. A sign or a unit of the two columns is wrong: give it with "
            f"{run.option(rate)} or {run.option(name, 'deg')}"
        )
