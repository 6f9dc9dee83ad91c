"""A component with an added force at its driven point, for effects on a component that declares no force elements.

    x' = f(x, u - F),   F = 0 unless an effect adds a term
"""

from typing import Any

from fmus.composition.wrapped import WrappedComponent
from fmus.declaration.component import Component, Scope
from fmus.declaration.elements import Element
from fmus.declaration.units import unit
from fmus.declaration.variables import Variable

FORCE = "resisting_force"
EFFORTS = (unit("N").exponents, unit("N.m").exponents)


class WithAddedForce(WrappedComponent):
    """A component with a force element `spring` between its driven point and the ground.

    effort is the driving input, deflection and rate the states of the driven point. further are efforts, deflections
    and rates of other driven points, with the element `at_<deflection>` each. Raises InputError for another name.
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
        names = [pair for point in points for pair in zip(("input", "state", "state"), point, strict=True)]
        self._begin(inner, inner.name, names, effort=effort, deflection=deflection, rate=rate, further=further)
        self.forces = {FORCE: effort} | {f"{FORCE}_at_{d}": e for e, d, _ in further}
        rows = {
            n: Variable("local", inner.table[e].unit, f"Force against {e}", name=n) for n, e in self.forces.items()
        }
        elements = {"spring": Element(FORCE, deflection, rate)}
        elements |= {f"at_{d}": Element(f"{FORCE}_at_{d}", d, r) for _, d, r in further}
        self._complete({**inner.table, **rows}, elements, effects)

    def _own_rates_of_effects(self) -> list[str]:
        return [f"der({name})" for name in self.states if name not in self.inner.table]

    def equations(self, v: Scope, m: Any) -> dict[str, Any]:
        for force in self.forces:
            setattr(v, force, 0.0)
        known = {n: v[n] for n in ("time", *self.inner.table) if n in v.__dict__}
        results = self.inner.run(known | {effort: v[effort] - v[force] for force, effort in self.forces.items()}, m)
        kept = {*(f"der({n})" for n in self.inner.states), *self.inner.rows("output", "calculated")}
        return {n: value for n, value in results.items() if n in kept}

    def mass(self, v: Scope, m: Any) -> dict[tuple[str, str], Any]:
        return self.inner.mass_entries({n: v[n] for n in ("time", *self.inner.table) if n in v.__dict__}, m)


def with_force_element(component: Component) -> Component:
    """The component, with a force element at every point that one of its inputs drives if it declares no elements
    itself.

    A component without an input that is a force or a torque and accelerates a state is returned unchanged.
    """
    from fmus.equations.sympy_form import symbolic  # noqa: PLC0415 - imported on use: SymPy takes 0.4 s

    if component.elements:
        return component
    efforts = [n for n in component.inputs if unit(component.table[n].unit).exponents in EFFORTS]
    if not efforts:
        return component
    form, points = symbolic(component), dict[str, tuple[str, str, str]]()
    rates = dict(zip(component.states, form.rates, strict=True))
    deflection_of = {str(rate): n for n, rate in rates.items() if str(rate) in component.states}
    for effort in efforts:
        driven = [n for n, rate in rates.items() if n in deflection_of and rate.has(form.symbols[effort])]
        if driven:
            points.setdefault(driven[0], (effort, deflection_of[driven[0]], driven[0]))
    if not points:
        return component
    first, *further = points.values()
    return WithAddedForce(component, *first, further=tuple(further))
