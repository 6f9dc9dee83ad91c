"""A component with an added force at its driven point, for effects on a component that declares no force elements.

    x' = f(x, u - F),   F = 0 unless an effect adds a term
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fmus.composition.added_acceleration import PER_INERTIA, WithAddedAcceleration
from fmus.composition.added_term import FORCE, WithAddedTerm, point_elements
from fmus.declaration.component import Component, Scope
from fmus.declaration.elements import Element
from fmus.declaration.units import is_force, unit
from fmus.declaration.variables import Variable
from fmus.expressions.functions import NUMERIC

LEAST_SLOPE = 1e-100  # of an acceleration by an effort, in place of zero


class WithAddedForce(WithAddedTerm):
    """A component with a force element `spring` between its driven point and the ground.

    effort is the driving input, deflection and rate the states of the driven point; deflection is empty where only the
    rate is a state, as of a wheel. further are efforts, deflections and rates of other driven points, with the element
    `at_<deflection>` or `at_<rate>` each. Raises InputError for another name.
    """

    effort: str
    deflection: str
    rate: str
    further: tuple[tuple[str, str, str], ...]

    def __init__(
        self, inner: Component, effort: str, deflection: str, rate: str,
        further: tuple[tuple[str, str, str], ...] = (), effects: tuple = (),
    ):  # fmt: skip
        points = ((effort, deflection, rate), *further)
        names = [pair for point in points for pair in zip(("input", "state", "state"), point, strict=True) if pair[1]]
        self._begin(inner, inner.name, names, effort=effort, deflection=deflection, rate=rate, further=further)
        others = {f"at_{d or r}": Element(f"{FORCE}_at_{d or r}", d, r) for _, d, r in further}
        self.forces = {FORCE: effort} | {
            element.force: point[0] for element, point in zip(others.values(), further, strict=True)
        }
        self.terms = tuple(self.forces)
        rows = {
            n: Variable("local", inner.table[e].unit, f"Force against {e}", name=n) for n, e in self.forces.items()
        }
        self._complete({**inner.table, **rows}, point_elements(deflection, rate, inner.table) | others, effects)

    def _with_terms(self, v: Scope, m: Any) -> dict[str, Any]:
        driving = {effort: v[effort] - v[force] for force, effort in self.forces.items()}
        return self.inner.run(self._inner_values(v) | driving, m)


def with_force_element(component: Component) -> Component:
    """The component, with a force element at every point that one of its inputs drives if it declares no elements
    itself.

    Where no input is a force or a torque, the element is at the acceleration, if there is one only, and its force is
    per unit of inertia: of several accelerations and of a mass matrix the reaction to a force is not known. Where no
    state is the derivative of another one, a linear or angular rate is a point without a deflection, as of a wheel.
    Without a point for an element the component is returned unchanged.
    """
    from fmus.equations.sympy_form import symbolic  # noqa: PLC0415 - imported on use: SymPy takes 0.4 s

    if component.elements:
        return component
    efforts = [n for n in component.inputs if is_force(component.table[n].unit)]
    form = symbolic(component)
    rates = dict(zip(component.states, form.rates, strict=True))
    moving = [n for n in component.states if unit(component.table[n].unit).exponents in PER_INERTIA]
    deflection_of = {str(rate): n for n, rate in rates.items() if str(rate) in component.states}
    deflection_of = deflection_of or dict.fromkeys(moving, "")
    if not efforts:
        alone = [(d, r) for r, d in deflection_of.items() if r in moving]
        return WithAddedAcceleration(component, *alone[0]) if len(alone) == 1 and not form.coupled else component
    # NumPy numbers give inf or nan, and no exception, where the equations are not defined at the start values.
    start = {n: np.float64(x) for n, x in component.start_values().items()}
    with np.errstate(all="ignore"):
        rest = component.run(start, NUMERIC)
        pushed = {effort: component.run(start | {effort: start[effort] + 1.0}, NUMERIC) for effort in efforts}
    slopes: dict[tuple[str, str], float] = {}
    for effort, changed in pushed.items():
        driven = [n for n in deflection_of if rates[n].has(form.symbols[effort])]
        changes = {(effort, n): float(changed[f"der({n})"] - rest[f"der({n})"]) for n in driven}
        slopes |= {pair: change if np.isfinite(change) else 1.0 for pair, change in changes.items()}
    points = [(effort, deflection_of[rate], rate) for effort, rate in _driven(efforts, slopes)]
    return WithAddedForce(component, *points[0], further=tuple(points[1:])) if points else component


def _driven(efforts: Sequence[str], slopes: Mapping[tuple[str, str], float]) -> list[tuple[str, str]]:
    """The efforts that drive a rate of their own, with that rate.

    slopes are the changes of the accelerations by each effort, by effort and rate. With the right pairs they are a part
    of the inverse of a mass matrix B, in which |B_ij|^2 <= B_ii B_jj: of all assignments of rates to efforts, the right
    one has the largest product of slopes.
    """
    from scipy.optimize import linear_sum_assignment  # noqa: PLC0415 - imported on use: it takes 0.5 s

    rates = list(dict.fromkeys(rate for _, rate in slopes))
    # A slope that is not positive gets the least weight, and its pair is removed below.
    given = np.array([[max(slopes.get((effort, rate), 0.0), LEAST_SLOPE) for rate in rates] for effort in efforts])
    rows, columns = linear_sum_assignment(-np.log(given)) if rates else ((), ())
    assigned = [(efforts[i], rates[j]) for i, j in zip(rows, columns, strict=True)]
    return [pair for pair in assigned if slopes.get(pair, 0.0) > 0]
