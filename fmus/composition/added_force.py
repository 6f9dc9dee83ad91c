"""A component with an added force at its driven point, for effects on a component that declares no force elements.

    x' = f(x, u - F),   F = 0 unless an effect adds to it
"""

from typing import Any

from fmus.declaration.component import Component, Scope
from fmus.declaration.elements import Element
from fmus.declaration.variables import Variable
from fmus.equations.sympy_form import symbolic
from fmus.support.errors import unknown

FORCE = "resisting_force"


class WithAddedForce(Component):
    """A component with a force element `spring` between its driven point and the ground.

    effort is the driving input, deflection and rate the states of the driven point. Raises InputError for another name.
    """

    def __init__(self, inner: Component, effort: str, deflection: str, rate: str, effects: tuple = ()):
        for kind, name, valid in (
            ("input", effort, inner.inputs),
            ("state", deflection, inner.states),
            ("state", rate, inner.states),
        ):
            if name not in valid:
                raise unknown(f"{kind} of {inner.name}", name, valid)
        self.inner, self.effort, self.deflection, self.rate = inner, effort, deflection, rate
        Component.__init__(self, inner.name, inner.source)
        self.table = {
            **inner.table,
            FORCE: Variable("local", inner.table[effort].unit, "Force against the driving one", name=FORCE),
        }
        self.elements = {"spring": Element(FORCE, deflection, rate)}  # type: ignore[misc]
        self.effects = tuple(effects)
        for effect in self.effects:
            effect.join(self)
        self.values = {
            **inner.values,
            **{n: r.start for n, r in self.rows("parameter").items() if n not in inner.values},
        }

    @property
    def structure(self) -> tuple:
        """What the equations depend on besides values (see `Component.structure`)."""
        return (
            type(self),
            self.inner.structure,
            self.effort,
            self.deflection,
            self.rate,
            *(e.structure for e in self.effects),
        )

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


def with_force_element(component: Component) -> Component:
    """The component, with a force element at the point that its first input drives if it declares no elements itself.

    A component without inputs, or whose first input accelerates no state, is returned unchanged.
    """
    if component.elements or not component.inputs:
        return component
    form, effort = symbolic(component), component.inputs[0]
    deflection_of = {
        str(rate): n for n, rate in zip(component.states, form.rates, strict=True) if str(rate) in component.states
    }
    driven = [
        n
        for n, rate in zip(component.states, form.rates, strict=True)
        if n in deflection_of and rate.has(form.symbols[effort])
    ]
    return WithAddedForce(component, effort, deflection_of[driven[0]], driven[0]) if driven else component
