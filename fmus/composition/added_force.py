"""A component with added forces, for effects on a component that declares no force elements.

    x' = f(x, u - F)           at the point that the force u drives
    x' = f(x, u - F / b)       at that of another input, with b = dv'/du: F per unit of inertia
    v' = g(x, u) - F           without an input: F per unit of inertia, on the only acceleration

F = 0 unless an effect adds a term. At a driven point the reactions of all other states are those of the equations.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fmus.composition.added_term import FORCE, WithAddedTerm, point_elements
from fmus.declaration.component import Component, Scope
from fmus.declaration.elements import Element
from fmus.declaration.units import is_force, unit
from fmus.declaration.variables import Variable
from fmus.expressions.functions import NUMERIC

LEAST_SLOPE = 1e-100  # of an acceleration by an effort, in place of zero
# the unit of a force per unit of inertia, by that of the rate
PER_INERTIA = {unit("m/s").exponents: "N/kg", unit("rad/s").exponents: "N.m/kg.m2"}
# the units of inputs that move a point, and do not drive it
MOTIONS = tuple(unit(f"{length}{per}").exponents for length in ("m", "rad") for per in ("", "/s", "/s2"))
# the units of a force and a velocity along it, and of a torque and an angular velocity
ALONG = tuple((unit(f"N{arm}").exponents, unit(rate).exponents) for arm, rate in (("", "m/s"), (".m", "rad/s")))
Point = tuple[str, str, str]  # input, deflection and rate; the first two may be empty


class WithAddedForce(WithAddedTerm):
    """A component with a force element `spring` between a point and the ground.

    effort is the input that drives the point, empty where none does; deflection and rate are states, deflection is
    empty where only the rate is a state, as of a wheel. further are the same of other points, with the element
    `at_<deflection>` or `at_<rate>` each. Raises InputError for another name.
    """

    effort: str
    deflection: str
    rate: str
    further: tuple[Point, ...]

    def __init__(
        self, inner: Component, effort: str, deflection: str, rate: str, further: tuple[Point, ...] = (),
        effects: tuple = (),
    ):  # fmt: skip
        points = ((effort, deflection, rate), *further)
        names = [pair for point in points for pair in zip(("input", "state", "state"), point, strict=True) if pair[1]]
        self._begin(inner, inner.name, names, effort=effort, deflection=deflection, rate=rate, further=further)
        others = {f"at_{d or r}": Element(f"{FORCE}_at_{d or r}", d, r) for _, d, r in further}
        self.points = {FORCE: points[0]} | {e.force: p for e, p in zip(others.values(), further, strict=True)}
        self.terms = tuple(self.points)
        rows = {name: _row(name, point, inner) for name, point in self.points.items()}
        self._complete({**inner.table, **rows}, point_elements(deflection, rate, inner.table) | others, effects)

    def _with_terms(self, v: Scope, m: Any) -> dict[str, Any]:
        given = self._inner_values(v)
        driven = {force: point for force, point in self.points.items() if point[0]}
        results = self.inner.run(given | {e: v[e] - self._effort(v, m, f) for f, (e, _, _) in driven.items()}, m)
        alone = {f"der({r})": force for force, (e, _, r) in self.points.items() if not e}
        return results | {name: results[name] - v[force] for name, force in alone.items()}

    def _effort(self, v: Scope, m: Any, force: str) -> Any:
        """A force in the unit of its input."""
        effort, _, rate = self.points[force]
        if is_force(self.inner.table[effort].unit):
            return v[force]
        given = self._inner_values(v)
        less, more = (self.inner.run(given | {effort: v[effort] + x}, m)[f"der({rate})"] for x in (0.0, 1.0))
        return v[force] / (more - less)


def _row(name: str, point: Point, inner: Component) -> Variable:
    """The local variable of a force at a point."""
    effort, _, rate = point
    if effort and is_force(inner.table[effort].unit):
        return Variable("local", inner.table[effort].unit, f"Force against {effort}", name=name)
    per_inertia = PER_INERTIA[unit(inner.table[rate].unit).exponents]
    return Variable("local", per_inertia, "Force against the motion, per unit of inertia", name=name)


def with_force_element(component: Component) -> Component:
    """The component, with a force element at every point that one of its inputs drives if it declares no elements
    itself.

    Where no input is a force or a torque, the element is at the only acceleration, and its force is per unit of
    inertia. Of several accelerations it is at the first one that an input drives, such as the voltage of a motor: of
    the others, and of a mass matrix, the reaction to a force is not known. A linear or angular rate that is not the
    derivative of a state is a point without a deflection, as of a wheel. Without a point for an element the component
    is returned unchanged.
    """
    from fmus.equations.sympy_form import symbolic  # noqa: PLC0415 - imported on use: SymPy takes 0.4 s

    if component.elements:
        return component
    table = component.table
    form = symbolic(component)
    rates = dict(zip(component.states, form.rates, strict=True))
    moving = [n for n in component.states if unit(table[n].unit).exponents in PER_INERTIA]
    deflection_of = dict.fromkeys(moving, "") | {str(x): n for n, x in rates.items() if str(x) in component.states}
    efforts = [n for n in component.inputs if is_force(table[n].unit)]
    forced = bool(efforts)
    if not forced and form.coupled:
        return component
    if not forced and len(moving) == 1:
        return WithAddedForce(component, "", deflection_of[moving[0]], moving[0])
    efforts = efforts or [n for n in component.inputs if unit(table[n].unit).exponents not in MOTIONS]
    # NumPy numbers give inf or nan, and no exception, where the equations are not defined at the start values.
    start = {n: np.float64(x) for n, x in component.start_values().items()}
    with np.errstate(all="ignore"):
        rest = component.run(start, NUMERIC)
        pushed = {effort: component.run(start | {effort: start[effort] + 1.0}, NUMERIC) for effort in efforts}
    slopes: dict[tuple[str, str], float] = {}
    for effort, changed in pushed.items():
        driven = [n for n in moving if rates[n].has(form.symbols[effort])]
        # A force drives the motion along it, and a lever or a load that hangs at its point through this motion.
        driven = [n for n in driven if _along(table[effort].unit, table[n].unit)] or driven
        changes = {(effort, n): float(changed[f"der({n})"] - rest[f"der({n})"]) for n in driven}
        slopes |= {pair: change if np.isfinite(change) else 1.0 for pair, change in changes.items()}
    # The units of accelerations by an input that is no force may differ: the first one that it drives is taken.
    first = next((pair for pair, slope in slopes.items() if slope), None)
    pairs = [first] if first and not forced and len(efforts) == 1 else _driven(efforts, slopes)
    points = [(effort, deflection_of[rate], rate) for effort, rate in pairs]
    return WithAddedForce(component, *points[0], further=tuple(points[1:])) if points else component


def _along(effort: str, rate: str) -> bool:
    """Whether an effort and a rate, by their units, are a force and a velocity, or a torque and an angular velocity."""
    return (unit(effort).exponents, unit(rate).exponents) in ALONG


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
