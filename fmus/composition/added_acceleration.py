"""A component with an added force per unit of its inertia, where no input is a force: a mass whose foot is moved.

    v' = g(x, u) - F,   F = 0 unless an effect adds a term
"""

from typing import Any

from fmus.composition.added_term import FORCE, WithAddedTerm, point_elements
from fmus.declaration.component import Component, Scope
from fmus.declaration.units import unit
from fmus.declaration.variables import Variable

# the unit of a force per unit of inertia, by that of the rate
PER_INERTIA = {unit("m/s").exponents: "N/kg", unit("rad/s").exponents: "N.m/kg.m2"}


class WithAddedAcceleration(WithAddedTerm):
    """A component with a force element `spring` between a point and the ground, whose force is per unit of inertia.

    deflection and rate are the states of the point; deflection is empty where only the rate is a state. Raises
    InputError for another name.
    """

    deflection: str
    rate: str
    terms = (FORCE,)

    def __init__(self, inner: Component, deflection: str, rate: str, effects: tuple = ()):
        names = [("state", n) for n in (deflection, rate) if n]
        self._begin(inner, inner.name, names, deflection=deflection, rate=rate)
        per_inertia = PER_INERTIA[unit(inner.table[rate].unit).exponents]
        row = Variable("local", per_inertia, "Force against the motion, per unit of inertia", name=FORCE)
        self._complete({**inner.table, FORCE: row}, point_elements(deflection, rate, inner.table), effects)

    def _with_terms(self, v: Scope, m: Any) -> dict[str, Any]:
        results, acceleration = self.inner.run(self._inner_values(v), m), f"der({self.rate})"
        return results | {acceleration: results[acceleration] - v[FORCE]}
