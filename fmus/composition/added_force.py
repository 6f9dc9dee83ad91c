"""A component with an added force at its driven point, for effects on a component that declares no force elements.

    x' = f(x, u - F),   F = 0 unless an effect adds a term
"""

from typing import Any

from fmus.composition.wrapped import WrappedComponent
from fmus.declaration.component import Component, Scope
from fmus.declaration.elements import Element
from fmus.declaration.units import unit
from fmus.declaration.variables import Variable
from fmus.equations.sympy_form import symbolic

FORCE = "resisting_force"


class WithAddedForce(WrappedComponent):
    """A component with a force element `spring` between its driven point and the ground.

    effort is the driving input, deflection and rate the states of the driven point. Raises InputError for another name.
    """

    effort: str

    def __init__(self, inner: Component, effort: str, deflection: str, rate: str, effects: tuple = ()):
        names = (("input", effort), ("state", deflection), ("state", rate))
        self._begin(inner, inner.name, names, effort=effort, deflection=deflection, rate=rate)
        force = Variable("local", inner.table[effort].unit, "Force against the driving one", name=FORCE)
        self._complete({**inner.table, FORCE: force}, {"spring": Element(FORCE, deflection, rate)}, effects)

    def _own_rates_of_effects(self) -> list[str]:
        return [f"der({name})" for name in self.states if name not in self.inner.table]

    def equations(self, v: Scope, m: Any) -> dict[str, Any]:
        v.resisting_force = 0.0
        known = {n: v[n] for n in ("time", *self.inner.table) if n in v.__dict__}
        results = self.inner.run({**known, self.effort: v[self.effort] - v.resisting_force}, m)
        kept = {*(f"der({n})" for n in self.inner.states), *self.inner.rows("output", "calculated")}
        return {n: value for n, value in results.items() if n in kept}

    def mass(self, v: Scope, m: Any) -> dict[tuple[str, str], Any]:
        return self.inner.mass_entries({n: v[n] for n in ("time", *self.inner.table) if n in v.__dict__}, m)


def with_force_element(component: Component) -> Component:
    """The component, with a force element at the point that its first input drives if it declares no elements itself.

    A component without inputs, or whose first input is no force or torque or accelerates no state, is returned
    unchanged.
    """
    if component.elements or not component.inputs:
        return component
    form, effort = symbolic(component), component.inputs[0]
    if unit(component.table[effort].unit).exponents not in (unit("N").exponents, unit("N.m").exponents):
        return component
    deflection_of = {
        str(rate): n for n, rate in zip(component.states, form.rates, strict=True) if str(rate) in component.states
    }
    driven = [
        n
        for n, rate in zip(component.states, form.rates, strict=True)
        if n in deflection_of and rate.has(form.symbols[effort])
    ]
    return WithAddedForce(component, effort, deflection_of[driven[0]], driven[0]) if driven else component
