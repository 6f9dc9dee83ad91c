"""Imposed motion: a component with one of its states as input and the force that this requires as output.

    forward   x' = s,   m s' = f(x, s, z, u)       input u, output x
    imposed   u such that m s' = f(x, s, z, u)     inputs x, s, s', output u;  f is affine in u

A servo-driven rig imposes the angle and measures the torque. A compliant shaft between servo and component deflects by
C u. Then u is a state, because x = x_servo - C u is the difference of nearly equal angles.

    u' = w,   m (s_servo' - C w') = f(x_servo - C u, s_servo - C w, z, u)
"""

from dataclasses import replace
from typing import Any

from fmus.composition.wrapped import WrappedComponent
from fmus.declaration.component import Component, Scope
from fmus.declaration.elements import Element
from fmus.declaration.variables import Variable
from fmus.effects.measuring_channel import ShaftCompliance
from fmus.equations.numpy_program import depends_on, recorded_equations
from fmus.support.errors import InputError

COMPLIANCE = "shaft_compliance.compliance"


class _Imposed(WrappedComponent):
    """Base of both: the imposed state is an input, the effort an output. `also` are further outputs of inner to
    keep."""

    imposed: str
    effort: str
    also: tuple[str, ...]

    def __init__(self, inner: Component, imposed: str, effort: str, effects: tuple = (), also: tuple[str, ...] = ()):
        names = (("state", imposed), ("input", effort), *(("output", n) for n in also))
        self._begin(inner, f"{inner.name}_imposed", names, imposed=imposed, effort=effort, also=also)
        self.delays = dict(inner.delays)
        self.rate = rate_state(inner, imposed)
        self.acceleration = f"der({self.rate})"
        table = self._turned_table(inner) | self._table(inner) | {n: inner.table[n] for n in also}
        self._complete(table, {"channel": Element(effort, imposed, "")}, effects)

    def _turned_table(self, inner: Component) -> dict[str, Variable]:
        """The table of the inner component with the imposed state, its rate and acceleration as inputs, the effort as
        output.
        """
        rate = inner.table[self.rate]
        kept, replaced = inner.rows("parameter", "state", "input"), (self.imposed, self.rate, self.effort)
        table = {n: r for n, r in kept.items() if n not in replaced}
        table |= {n: _row("input", inner.table[n], n) for n in (self.imposed, self.rate)}
        table[self.acceleration] = Variable(
            "input", f"{rate.unit}2", f"{rate.description}, its rate", name=self.acceleration
        )
        return table | {self.effort: _row("output", inner.table[self.effort], self.effort)}

    def _table(self, inner: Component) -> dict[str, Variable]:
        """The further variables of the table. Raises InputError where the state cannot be imposed."""
        raise NotImplementedError

    def _known(self, v: Scope) -> dict[str, Any]:
        """The values for the inner component, its effort zero."""
        return {n: v[n] for n in ("time", *self.table) if n in v.__dict__} | {self.effort: 0.0}


def _row(role: str, like: Variable, name: str, unit: str = "") -> Variable:
    return Variable(role, unit or like.unit, like.description, name=name)


class ImposedMotion(_Imposed):
    """The component with a state, its rate and its acceleration as inputs, and the effort as output.

    Raises InputError if the state is not an angle or displacement with its rate as another state, if the mass
    matrix couples that rate with others, or if the effort does not accelerate it.

        ImposedMotion(DrivenJoint(), "angle", "torque")      # inputs angle, rate, der(rate); output torque
    """

    def _table(self, inner: Component) -> dict[str, Variable]:
        form = recorded_equations(inner)
        if any(self.rate in (r, c) and r != c and entry != 0.0 for (r, c), entry in form.mass.items()):
            raise InputError(
                f"the mass matrix of {inner.name} couples {self.rate} with other states: it cannot be imposed; "
                "impose a state whose rate is uncoupled"
            )
        if self.effort not in depends_on(form.rates[inner.states.index(self.rate)]):
            raise InputError(
                f"{self.effort} does not accelerate {self.imposed} of {inner.name}, so that its motion does not "
                "determine it; impose a state on which it acts"
            )
        return {}

    def equations(self, v: Scope, m: Any) -> dict[str, Any]:
        known = self._known(v)
        free, pushed = (self.inner.run({**known, self.effort: u}, m) for u in (0.0, 1.0))
        rest, slope = free[self.acceleration], pushed[self.acceleration] - free[self.acceleration]
        if hasattr(slope, "cancel"):  # an expression of SymPy
            slope = slope.expand().cancel()
        inertia = self.inner.mass_entries(known, m).get((self.rate, self.rate), 1.0)
        effort = (inertia * v[self.acceleration] - rest) / slope
        states = [n for n in self.inner.states if n not in (self.imposed, self.rate)]
        driven = self.inner.run({**known, self.effort: effort}, m)
        return {
            **{f"der({n})": driven[f"der({n})"] for n in states},
            self.effort: effort,
            **{n: driven[self.inner.sensor_output(n)] for n in self.also},
        }

    def mass(self, v: Scope, m: Any) -> dict[tuple[str, str], Any]:
        return {k: e for k, e in self.inner.mass_entries(self._known(v), m).items() if self.rate not in k}


class ImposedThroughSpring(_Imposed):
    """The component behind a compliant shaft whose far end has imposed motion; the effort is the torque of the shaft.
    """

    def _table(self, inner: Component) -> dict[str, Variable]:
        state, effort = inner.table[self.imposed], inner.table[self.effort]
        self.held, self.held_rate = f"{self.effort}_of_spring", f"{self.effort}_rate_of_spring"
        compliance = replace(
            ShaftCompliance.declared["compliance"], name=COMPLIANCE, unit=f"{state.unit}/{effort.unit}"
        )
        return {
            self.held: _row("state", effort, self.held),
            self.held_rate: _row("state", effort, self.held_rate, f"{effort.unit}/s"),
            COMPLIANCE: compliance,
        }

    def _behind(self, v: Scope) -> dict[str, Any]:
        """The values for the component behind the spring."""
        compliance = v[COMPLIANCE]
        motion = {
            self.imposed: v[self.imposed] - compliance * v[self.held],
            self.rate: v[self.rate] - compliance * v[self.held_rate],
        }
        return self._known(v) | motion | {self.effort: v[self.held]}

    def equations(self, v: Scope, m: Any) -> dict[str, Any]:
        known = self._behind(v)
        rates, entries = self.inner.run(known, m), self._entries(known, m)
        left = {
            n: rates[f"der({n})"] - entries.get((n, self.rate), 0.0) * v[self.acceleration]
            for n in self.inner.states
            if n != self.imposed
        }
        turned = -left.pop(self.rate)
        spring = {f"der({self.held_rate})": turned, f"der({self.held})": v[self.held_rate], self.effort: v[self.held]}
        return {**{f"der({n})": x for n, x in left.items()}, **spring, **{n: rates[n] for n in self.also}}

    def mass(self, v: Scope, m: Any) -> dict[tuple[str, str], Any]:
        # The row of the rate changes its sign, so that the diagonal stays positive.
        entries, renamed = {}, {self.rate: self.held_rate}
        for (row, column), entry in self._entries(self._behind(v), m).items():
            turned = -entry if (row == self.rate) != (column == self.rate) else entry
            entries[renamed.get(row, row), renamed.get(column, column)] = (
                v[COMPLIANCE] * turned if column == self.rate else turned
            )
        return entries

    def _entries(self, known: dict[str, Any], m: Any) -> dict[tuple[str, str], Any]:
        return {(self.rate, self.rate): 1.0} | self.inner.mass_entries(known, m)


def rate_state(component: Component, state: str) -> str:
    """The name of the state that is the time derivative of a state. Raises InputError where there is none."""
    form = recorded_equations(component)
    rate = form.rates[component.states.index(state)]
    found = next((n for n in component.states if form.symbols[n] is rate), "")
    if not found:
        raise InputError(
            f"der({state}) is not itself a state of {component.name}: only an angle or a displacement can be imposed"
        )
    return found
