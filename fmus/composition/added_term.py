"""The base of components with terms that are zero unless an effect adds to them."""

from collections.abc import Mapping
from typing import Any

from fmus.composition.wrapped import WrappedComponent
from fmus.declaration.component import Scope
from fmus.declaration.elements import Element
from fmus.declaration.units import unit
from fmus.declaration.variables import Variable

FORCE = "resisting_force"


def point_elements(deflection: str, rate: str, table: Mapping[str, Variable]) -> dict[str, Element]:
    """The force element `spring` of a point, and `rotation` where the point turns by an angle."""
    element = Element(FORCE, deflection, rate)
    turns = deflection and unit(table[deflection].unit).exponents == unit("rad").exponents
    return {"spring": element} | ({"rotation": element} if turns else {})


class WithAddedTerm(WrappedComponent):
    """A component around another one with its states and outputs, and `terms` that its equations read."""

    terms: tuple[str, ...]

    def _own_rates_of_effects(self) -> list[str]:
        return [f"der({name})" for name in self.states if name not in self.inner.table]

    def _inner_values(self, v: Scope) -> dict[str, Any]:
        """The values in a scope of what the inner component declares, and time."""
        return {n: v[n] for n in ("time", *self.inner.table) if n in v.__dict__}

    def equations(self, v: Scope, m: Any) -> dict[str, Any]:
        for term in self.terms:
            setattr(v, term, 0.0)
        results = self._with_terms(v, m)
        kept = {*(f"der({n})" for n in self.inner.states), *self.inner.rows("output", "calculated")}
        return {n: value for n, value in results.items() if n in kept}

    def _with_terms(self, v: Scope, m: Any) -> dict[str, Any]:
        """The results of the inner component with the terms in a scope."""
        raise NotImplementedError

    def mass(self, v: Scope, m: Any) -> dict[tuple[str, str], Any]:
        return self.inner.mass_entries(self._inner_values(v), m)
