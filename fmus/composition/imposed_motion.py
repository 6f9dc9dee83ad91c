"""A component with one of its states imposed and the force that this takes as output: a forward model seen backwards.

    forward   x' = s,   m s' = f(x, s, z, u)       u is told, x is measured
    imposed   u such that m s' = f(x, s, z, u)     x, s, s' are told, u is measured;  f is affine in u

A servo-driven rig imposes the angle and measures the torque. Between servo and component there may be a spring that gives
way by C u. Then u is a state: x = x_servo - C u is the difference of nearly equal angles, and u no small part of it.

    u' = w,   m (s_servo' - C w') = f(x_servo - C u, s_servo - C w, z, u)
"""

from dataclasses import replace
from typing import Any

import sympy

from fmus.component import Component, Scope
from fmus.effects.channel import ShaftCompliance
from fmus.elements import Element
from fmus.errors import InputError, unknown
from fmus.mathematics import SYMBOLIC
from fmus.traced import depends_on, traced
from fmus.variables import Variable

COMPLIANCE = "shaft_compliance.compliance"


class _Wrapped(Component):
    """What both share: the inner component's table, and its values. `also` are outputs of its own that it keeps."""

    def __init__(self, inner: Component, imposed: str, effort: str, effects: tuple = (), also: tuple[str, ...] = ()):
        for kind, name, valid in (("state", imposed, inner.states), ("input", effort, inner.inputs), *(("output", n, inner.outputs) for n in also)):
            if name not in valid:
                raise unknown(f"{kind} of {inner.name}", name, valid)
        self.inner, self.imposed, self.effort, self.also = inner, imposed, effort, also
        Component.__init__(self, f"{inner.name}_imposed", inner.source)
        self.delays = dict(inner.delays)
        self.rate = rate_among(inner, imposed)
        self.acceleration = f"der({self.rate})"
        self.table = self._told(inner) | self._table(inner) | {n: inner.table[n] for n in also}
        self.elements = {"channel": Element(effort, imposed, "")}  # type: ignore[misc]
        self.effects = tuple(effects)
        for effect in self.effects:
            effect.join(self)
        self.values = {**inner.values, **{n: r.start for n, r in self.rows("parameter").items() if n not in inner.values}}

    @property
    def structure(self) -> tuple:
        return (type(self), self.inner.structure, self.imposed, self.effort, self.also, *(e.structure for e in self.effects))

    def _remade(self, effects: tuple, values: Any) -> Component:
        own = {n: v for n, v in values.items() if n in self.inner.values}
        twin = type(self)(self.inner.with_values(**own), self.imposed, self.effort, effects, self.also)
        twin._set_values({n: v for n, v in values.items() if n in twin.values})
        return twin

    def _told(self, inner: Component) -> dict[str, Variable]:
        """What is kept of the inner component's table; the imposed state, its rate and its acceleration as inputs, the effort as output."""
        rate = inner.table[self.rate]
        table = {n: r for n, r in inner.table.items() if r.role == "parameter" or (r.role == "state" and n not in (self.imposed, self.rate))
                 or (r.role == "input" and n != self.effort)}  # fmt: skip
        table |= {n: _row("input", inner.table[n], n) for n in (self.imposed, self.rate)}
        table[self.acceleration] = Variable("input", f"{rate.unit}2", f"{rate.description}, its rate", name=self.acceleration)
        return table | {self.effort: _row("output", inner.table[self.effort], self.effort)}

    def _table(self, inner: Component) -> dict[str, Variable]:
        """What is in the table besides. Raises InputError where the state cannot be imposed."""
        raise NotImplementedError

    def _known(self, v: Scope) -> dict[str, Any]:
        """The values that the inner component may read, its effort zero."""
        return {n: v[n] for n in ("time", *self.table) if n in v.__dict__} | {self.effort: 0.0}


def _row(role: str, like: Variable, name: str, unit: str = "") -> Variable:
    return Variable(role, unit or like.unit, like.description, name=name)


class Imposed(_Wrapped):
    """The component with a state, its rate and its acceleration as inputs, and the effort as output."""

    def _table(self, inner: Component) -> dict[str, Variable]:
        form = traced(inner)
        if any(self.rate in (r, c) and r != c and entry != 0.0 for (r, c), entry in form.mass.items()):
            raise InputError(f"the mass matrix of {inner.name} couples {self.rate} with other states: it cannot be imposed")
        if self.effort not in depends_on(form.rates[inner.states.index(self.rate)]):
            raise InputError(f"{self.effort} does not accelerate {self.imposed} of {inner.name}: it does not follow from that motion; impose a state on which it acts")
        return {}

    def equations(self, v: Scope, m: Any) -> dict[str, Any]:
        known = self._known(v)
        free, pushed = (self.inner.run({**known, self.effort: u}, m) for u in (0.0, 1.0))
        rest, slope = free[self.acceleration], pushed[self.acceleration] - free[self.acceleration]
        if m is SYMBOLIC:
            slope = sympy.cancel(sympy.expand(slope))
        inertia = self.inner.mass_entries(known, m).get((self.rate, self.rate), 1.0)
        effort = (inertia * v[self.acceleration] - rest) / slope
        states = [n for n in self.inner.states if n not in (self.imposed, self.rate)]
        driven = self.inner.run({**known, self.effort: effort}, m)
        return {**{f"der({n})": driven[f"der({n})"] for n in states}, self.effort: effort, **{n: driven[self.inner.shown(n)] for n in self.also}}

    def mass(self, v: Scope, m: Any) -> dict[tuple[str, str], Any]:
        return {k: e for k, e in self.inner.mass_entries(self._known(v), m).items() if self.rate not in k}


class ThroughSpring(_Wrapped):
    """The component behind a spring whose far end is imposed, with its rate and acceleration; the effort is the spring's."""

    def _table(self, inner: Component) -> dict[str, Variable]:
        state, effort = inner.table[self.imposed], inner.table[self.effort]
        self.held, self.held_rate = f"{self.effort}_of_spring", f"{self.effort}_rate_of_spring"
        compliance = replace(ShaftCompliance.declared["compliance"], name=COMPLIANCE, unit=f"{state.unit}/{effort.unit}")
        return {self.held: _row("state", effort, self.held), self.held_rate: _row("state", effort, self.held_rate, f"{effort.unit}/s"), COMPLIANCE: compliance}

    def _behind(self, v: Scope) -> dict[str, Any]:
        """What the component sees behind the spring."""
        compliance = v[COMPLIANCE]
        moved = {self.imposed: v[self.imposed] - compliance * v[self.held], self.rate: v[self.rate] - compliance * v[self.held_rate]}
        return self._known(v) | moved | {self.effort: v[self.held]}

    def equations(self, v: Scope, m: Any) -> dict[str, Any]:
        known = self._behind(v)
        rates, entries = self.inner.run(known, m), self._entries(known, m)
        left = {n: rates[f"der({n})"] - entries.get((n, self.rate), 0.0) * v[self.acceleration] for n in self.inner.states if n != self.imposed}
        turned = -left.pop(self.rate)
        spring = {f"der({self.held_rate})": turned, f"der({self.held})": v[self.held_rate], self.effort: v[self.held]}
        return {**{f"der({n})": x for n, x in left.items()}, **spring, **{n: rates[n] for n in self.also}}

    def mass(self, v: Scope, m: Any) -> dict[tuple[str, str], Any]:
        # The rate's own row is written the other way around, so that its diagonal stays positive.
        entries, renamed = {}, {self.rate: self.held_rate}
        for (row, column), entry in self._entries(self._behind(v), m).items():
            turned = -entry if (row == self.rate) != (column == self.rate) else entry
            entries[renamed.get(row, row), renamed.get(column, column)] = v[COMPLIANCE] * turned if column == self.rate else turned
        return entries

    def _entries(self, known: dict[str, Any], m: Any) -> dict[tuple[str, str], Any]:
        return {(self.rate, self.rate): 1.0} | self.inner.mass_entries(known, m)


def rate_among(component: Component, state: str) -> str:
    """The state that is the rate of a state. Raises InputError where none is."""
    form = traced(component)
    rate = form.rates[component.states.index(state)]
    found = next((n for n in component.states if form.symbols[n] is rate), "")
    if not found:
        raise InputError(f"der({state}) is not itself a state of {component.name}: only an angle or a displacement can be imposed")
    return found
