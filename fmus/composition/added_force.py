"""A component whose driving force first meets a force of its own: where laws act on a component that names no elements.

    x' = f(x, u - F),   F = 0 unless an effect adds to it
"""

from typing import Any

from fmus.component import Component, Scope
from fmus.elements import Element
from fmus.errors import unknown
from fmus.symbolic import symbolic
from fmus.variables import Variable

FORCE = "resisting_force"


class Resisted(Component):
    """Any component with an element `spring` between its driven point and the ground."""

    def __init__(self, inner: Component, effort: str, deflection: str, rate: str, effects: tuple = ()):
        for kind, name, valid in (("input", effort, inner.inputs), ("state", deflection, inner.states), ("state", rate, inner.states)):
            if name not in valid:
                raise unknown(f"{kind} of {inner.name}", name, valid)
        self.inner, self.effort, self.deflection, self.rate = inner, effort, deflection, rate
        Component.__init__(self, inner.name, inner.source)
        self.table = {**inner.table, FORCE: Variable("local", inner.table[effort].unit, "Force against the driving one", name=FORCE)}
        self.elements = {"spring": Element(FORCE, deflection, rate)}  # type: ignore[misc]
        self.effects = tuple(effects)
        for effect in self.effects:
            effect.join(self)
        self.values = {**inner.values, **{n: r.start for n, r in self.rows("parameter").items() if n not in inner.values}}

    @property
    def structure(self) -> tuple:
        return (type(self), self.inner.structure, self.effort, self.deflection, self.rate, *(e.structure for e in self.effects))

    def _remade(self, effects: tuple, values: Any) -> Component:
        own = {n: v for n, v in values.items() if n in self.inner.values}
        twin = type(self)(self.inner.with_values(**own), self.effort, self.deflection, self.rate, effects)
        twin._set_values({n: v for n, v in values.items() if n in twin.values})
        return twin

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


def with_a_place(component: Component) -> Component:
    """The component; one that names no elements gets a place for force laws where its first input drives it."""
    if component.elements or not component.inputs:
        return component
    form, effort = symbolic(component), component.inputs[0]
    deflection_of = {str(rate): n for n, rate in zip(component.states, form.rates, strict=True) if str(rate) in component.states}
    driven = [n for n, rate in zip(component.states, form.rates, strict=True) if n in deflection_of and rate.has(form.symbols[effort])]
    return Resisted(component, effort, deflection_of[driven[0]], driven[0]) if driven else component
