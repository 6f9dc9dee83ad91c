"""A component with one of its states imposed and the force that this takes as output: a forward model seen backwards.

    forward   x' = s,   m s' = f(x, s, z, u)       u is told, x is measured
    imposed   u such that m s' = f(x, s, z, u)     x, s, s' are told, u is measured;  f is affine in u

A servo-driven rig imposes the angle and measures the torque. Between servo and component there may be a spring
(`compliance`): then the component's own state stays free, and u = (x_servo - x) / compliance.
"""

from typing import Any

import sympy

from fmus.component import Component, Scope
from fmus.elements import Element
from fmus.errors import InputError, unknown
from fmus.mathematics import SYMBOLIC
from fmus.traced import traced
from fmus.variables import Variable


class _Wrapped(Component):
    """What both share: the inner component's table, and its values."""

    def __init__(self, inner: Component, imposed: str, effort: str, effects: tuple = ()):
        for kind, name, valid in (("state", imposed, inner.states), ("input", effort, inner.inputs)):
            if name not in valid:
                raise unknown(f"{kind} of {inner.name}", name, valid)
        self.inner, self.imposed, self.effort = inner, imposed, effort
        Component.__init__(self, f"{inner.name}_imposed", inner.source)
        self.delays = dict(inner.delays)
        self.table = self._table(inner)
        self.elements = {"channel": Element(effort, imposed, "")}  # type: ignore[misc]
        self.effects = tuple(effects)
        for effect in self.effects:
            effect.join(self)
        self.values = {**inner.values, **{n: r.start for n, r in self.rows("parameter").items() if n not in inner.values}}

    @property
    def structure(self) -> tuple:
        return (type(self), self.inner.structure, self.imposed, self.effort, *(e.structure for e in self.effects))

    def _remade(self, effects: tuple, values: Any) -> Component:
        own = {n: v for n, v in values.items() if n in self.inner.values}
        twin = type(self)(self.inner.with_values(**own), self.imposed, self.effort, effects)
        twin._set_values({n: v for n, v in values.items() if n in twin.values})
        return twin

    def _table(self, inner: Component) -> dict[str, Variable]:
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
        rate = form.rates[inner.states.index(self.imposed)]
        self.rate = next((n for n in inner.states if form.symbols[n] is rate), "")
        if not self.rate:
            raise InputError(f"der({self.imposed}) is not itself a state of {inner.name}: only an angle or a displacement can be imposed")
        if any(self.rate in (r, c) and r != c and entry != 0.0 for (r, c), entry in form.mass.items()):
            raise InputError(f"the mass matrix of {inner.name} couples {self.rate} with other states: it cannot be imposed")
        self.acceleration = f"der({self.rate})"
        table = {n: r for n, r in inner.table.items() if r.role == "parameter" or (r.role == "state" and n not in (self.imposed, self.rate))
                 or (r.role == "input" and n != self.effort)}  # fmt: skip
        rate_row = inner.table[self.rate]
        table |= {n: _row("input", inner.table[n], n) for n in (self.imposed, self.rate)}
        table[self.acceleration] = Variable("input", f"{rate_row.unit}2", f"{rate_row.description}, its rate", name=self.acceleration)
        table[self.effort] = _row("output", inner.table[self.effort], self.effort)
        return table

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
        return {**{f"der({n})": driven[f"der({n})"] for n in states}, self.effort: effort}

    def mass(self, v: Scope, m: Any) -> dict[tuple[str, str], Any]:
        return {k: e for k, e in self.inner.mass_entries(self._known(v), m).items() if self.rate not in k}


class ThroughSpring(_Wrapped):
    """The component behind a spring whose far end is imposed; the effort is the spring's."""

    def _table(self, inner: Component) -> dict[str, Variable]:
        state, effort = inner.table[self.imposed], inner.table[self.effort]
        table = {n: r for n, r in inner.table.items() if r.role in ("parameter", "state") or (r.role == "input" and n != self.effort)}
        self.drive = f"{self.imposed}_imposed"
        table[self.drive] = _row("input", state, self.drive)
        table["shaft_compliance.compliance"] = Variable("parameter", "rad/N.m" if effort.unit == "N.m" else "m/N", "Compliance between servo and bar", start=1e-4,
                                                        min=2e-6, max=1.0, name="shaft_compliance.compliance")  # fmt: skip
        table[self.effort] = _row("output", effort, self.effort)
        return table

    def equations(self, v: Scope, m: Any) -> dict[str, Any]:
        effort = (v[self.drive] - v[self.imposed]) / v["shaft_compliance.compliance"]
        results = self.inner.run({**self._known(v), self.effort: effort}, m)
        return {**{f"der({n})": results[f"der({n})"] for n in self.inner.states}, self.effort: effort}

    def mass(self, v: Scope, m: Any) -> dict[tuple[str, str], Any]:
        return self.inner.mass_entries(self._known(v), m)
