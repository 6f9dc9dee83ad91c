"""Systems of components, connected by equal port names. A system is itself a component.

It can be linearised, exported as one FMU without coupling error, and be a part of a larger system. Its variables are
`part.variable`; an input without a source is an input of the system.

    System("coupled", {"vehicle": motorcycle, "device": rider})
"""

from collections.abc import Mapping, Sequence
from functools import cached_property, partial
from typing import Any

from fmus.composition.wiring import join as by_names
from fmus.declaration.component import Component, Scope, prefixed
from fmus.declaration.elements import Element
from fmus.declaration.units import unit
from fmus.equations.numpy_program import depends_on, recorded_equations
from fmus.support.errors import InputError, unknown

Wiring = Mapping[str, Sequence[str]]


def join(parts: Mapping[str, Component]) -> dict[str, list[str]]:
    """The wiring {input: sources} by equal names; flows (torques, forces) of several sources are summed.

    Raises InputError when a signal other than a flow has two sources.
    """
    return by_names(parts, lambda part, name: parts[part].table[name].flow)


class System(Component):
    """Components connected by `wiring`, a mapping of `part.input` to sources `part.output`; by equal names by default.

    `bindings` sets a parameter of one part to a calculated parameter of another:
    {"vehicle.added_steer_inertia": "device.port_inertia"}. All quantities are in SI units. Raises InputError for
    unknown names, units that differ, and an algebraic loop, which the message spells out.

        >>> held = mf.System("held", {"vehicle": mf.vehicle("sharp_1971"), "device": mf.damper(7.5)})
        >>> held.wiring["vehicle.handlebar_torque"]
        ('device.handlebar_torque',)
        >>> mf.linearise(held, **{"vehicle.speed": 30.0}).A.shape
        (8, 8)
    """

    def __init__(self, name: str, parts: Mapping[str, Component], wiring: Wiring | None = None,
                 bindings: Mapping[str, str] | None = None, source: str = ""):  # fmt: skip
        self.parts = dict(parts)
        self.wiring = {k: tuple(s) for k, s in (join(parts) if wiring is None else wiring).items()}
        self.bindings = dict(bindings or {})
        self.elements: dict[str, Element] = {}  # type: ignore[misc]
        super().__init__(name, source)
        for part, component in self.parts.items():
            self.delays |= {
                f"{part}.{n}": (f"{part}.{source}", f"{part}.{delay}")
                for n, (source, delay) in component.delays.items()
            }
            rename, elements = partial(self._whole, part), component.elements.items()
            self.elements |= {f"{part}.{n}": e.renamed(rename) for n, e in elements}  # type: ignore[misc]
            for key, row in prefixed(component.table, part).items():
                if key not in self.wiring and key not in self.bindings:
                    self.table[key] = row
        self._check_wiring()
        self._set_values({f"{p}.{k}": x for p, c in self.parts.items() for k, x in c.values.items()
                          if f"{p}.{k}" not in self.bindings})  # fmt: skip
        self.order = self._order()

    def __repr__(self) -> str:
        parts = ", ".join(f"{name}={type(c).__name__}({c.name!r})" for name, c in self.parts.items())
        return f"System({self.name!r}, {parts})"

    @property
    def structure(self) -> tuple:
        """What the equations depend on besides values (see `Component.structure`)."""
        parts = tuple((name, c.structure) for name, c in self.parts.items())
        return (System, parts, tuple(sorted(self.wiring.items())), tuple(sorted(self.bindings.items())))

    def _remade(self, effects: tuple, values: Mapping[str, float]) -> Component:
        if effects:
            raise InputError(f"{self.name}: add effects to a part of the system, not to the system")
        twin = System(self.name, self.parts, self.wiring, self.bindings, self.source)
        twin._set_values(values)
        return twin

    def _whole(self, part: str, name: str) -> str:
        """The name of a part's variable in the system; of an input with one source the name of the source."""
        key = f"{part}.{name}"
        sources = self.wiring.get(key, ())
        return sources[0] if len(sources) == 1 else key

    def _check_wiring(self) -> None:
        for target, sources in self.wiring.items():
            row = self._row(target, "input")
            for source in sources:
                other = self._row(source, "output", "state")
                if unit(other.unit).exponents != unit(row.unit).exponents:
                    raise InputError(f"{source} [{other.unit}] cannot drive {target} [{row.unit}]: the units differ")

    def _row(self, key: str, *roles: str):
        part, _, name = key.partition(".")
        if part not in self.parts:
            raise unknown("part of the system", part, self.parts)
        rows = self.parts[part].rows(*roles)
        if name not in rows:
            raise unknown(f"{roles[0]} of {part}", name, rows)
        return rows[name]

    def _order(self) -> list[tuple[str, tuple[str, ...]]]:
        """The order of evaluation: (part, outputs that depend on known inputs only), until every wired source is
        known.
        """
        needed = {source for sources in self.wiring.values() for source in sources}
        known: set[str] = set()
        order = []
        while needed - known:
            before = len(known)
            for part, component in self.parts.items():
                waiting = {n for n in component.inputs if not set(self.wiring.get(f"{part}.{n}", ())) <= known}
                nodes = zip(component.outputs, recorded_equations(component).outputs, strict=True)
                wanted = needed - known
                computable = tuple(n for n, node in nodes if f"{part}.{n}" in wanted and not depends_on(node) & waiting)
                if computable:
                    order.append((part, computable))
                    known |= {f"{part}.{name}" for name in computable}
            if len(known) == before:
                raise InputError(f"algebraic loop: {self._loop(needed - known)}; break it with a state or a delay")
        return order

    def _loop(self, unresolved: set[str]) -> str:
        """The algebraic loop as a chain of ports."""
        path = [min(unresolved)]
        while path.count(path[-1]) == 1:
            part, _, name = path[-1].partition(".")
            component = self.parts[part]
            used = depends_on(recorded_equations(component).outputs[component.outputs.index(name)])
            path.append(next(source for n in component.inputs if n in used
                             for source in self.wiring.get(f"{part}.{n}", ()) if source in unresolved))  # fmt: skip
        return " <- ".join(path[path.index(path[-1]) :])

    def _values_of(self, part: str, v: Scope, known: Mapping[str, Any]) -> dict[str, Any]:
        values = {"time": v["time"]}
        for name in self.parts[part].rows("parameter", "state", "input"):
            key = f"{part}.{name}"
            if key in self.wiring:
                sources = self.wiring[key]
                values[name] = sum(known[s] for s in sources) if all(s in known for s in sources) else 0.0
            elif key in self.bindings:
                values[name] = known[self.bindings[key]]
            else:
                values[name] = v[key]
        return values

    def _calculated(self, v: Scope, m: Any) -> dict[str, Any]:
        """The bound calculated parameters; they follow from the parameters of their own part alone."""
        known: dict[str, Any] = {}
        for source in self.bindings.values():
            part, _, name = source.partition(".")
            results = self.parts[part].run(self._values_of(part, v, known), m)
            known[source] = results[name]
        return known

    def _signals(self, v: Scope, m: Any) -> dict[str, Any]:
        """The connected signals and the bound calculated parameters."""
        known = self._calculated(v, m)
        for part, names in self.order:
            results = self.parts[part].run(self._values_of(part, v, known), m)
            known.update({f"{part}.{name}": results[name] for name in names})
        return known

    def equations(self, v: Scope, m: Any) -> dict[str, Any]:
        known = self._signals(v, m)
        everything = {}
        for part, component in self.parts.items():
            results = component.run(self._values_of(part, v, known), m)
            for key, value in results.items():
                role = component.table[key].role if key in component.table else "rate"
                if role == "rate":
                    everything[f"der({part}.{key[4:-1]})"] = value
                else:
                    everything[f"{part}.{key}"] = value
        return everything

    @cached_property
    def _mass_depends_on_signals(self) -> bool:
        """Whether the mass matrix of a part depends on a connected signal."""
        return any(
            f"{part}.{name}" in self.wiring
            for part, component in self.parts.items()
            for entry in recorded_equations(component).mass.values()
            for name in depends_on(entry) & set(component.inputs)
        )

    def mass(self, v: Scope, m: Any) -> dict[tuple[str, str], Any]:
        known = self._signals(v, m) if self._mass_depends_on_signals else self._calculated(v, m)
        entries = {}
        for part, component in self.parts.items():
            values = {**self._values_of(part, v, known)}
            for (row, column), entry in component.mass_entries(values, m).items():
                entries[f"{part}.{row}", f"{part}.{column}"] = entry
        return entries
