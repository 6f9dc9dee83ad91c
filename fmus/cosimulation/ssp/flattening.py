"""A nested system as a flat one: which output drives each input of a component, and which values are bound to it.

A connector of a system passes a value on. The connections between an output and an input are followed one by one; at
each the value is converted to the unit of the next connector, then transformed. Values that are bound to a connector
of a system go the same way. Of several values for one variable that of the outermost system counts, and of one
element the last (SSP, "ParameterBindings").
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from fmus.cosimulation.ssp.package import Package
from fmus.cosimulation.ssp.parameters import Setting
from fmus.cosimulation.ssp.structure import Component, Connection, Element, Path_, System
from fmus.cosimulation.ssp.units import IDENTITY, Affine, UnitDefinition, conversion
from fmus.cosimulation.subsystems.typed_values import REAL, Value
from fmus.support.errors import InputError, unknown

Node = tuple[Path_, str]  # a connector: the path of its element, and its name
SOURCES, SINKS = ("output", "calculatedParameter", "local", "constant"), ("input", "parameter", "structuralParameter")


@dataclass
class Flat:
    """Components by name; wires (component, input) -> ((component, output), change); values by component and name."""

    components: dict[str, Component]
    wires: dict[tuple[str, str], tuple[tuple[str, str], Affine]] = field(default_factory=dict)
    values: dict[str, dict[str, Value]] = field(default_factory=dict)
    ignored: list[str] = field(default_factory=list)  # bound values without a variable


@dataclass(frozen=True)
class _Signal:
    """What arrives at a connector: from where, changed how, in which unit; passed lists the connectors of systems on
    the way, the outermost first, each with the change from there."""

    source: Node
    change: Affine
    unit: UnitDefinition | None
    passed: tuple[tuple[Node, Affine], ...] = ()


def flatten(system: System, package: Package) -> Flat:
    """The flat system. Raises InputError with file, element and reason for what cannot be connected or set."""
    return _Flattening(system, package).flat()


class _Flattening:
    def __init__(self, system: System, package: Package):
        self.system, self.package = system, package
        self.elements: dict[Path_, Element] = {system.path: system}
        self.incoming: dict[Node, tuple[Node, Connection]] = {}
        self.unused: list[str] = []
        self._visit(system)

    def flat(self) -> Flat:
        names = self._names()
        found = Flat({names[c.path]: c for c in self.system.components()})
        settings = self._settings(self.system)
        for component in self.system.components():
            name, values = names[component.path], found.values.setdefault(names[component.path], {})
            for variable, row in component.variables.items():
                node = (component.path, variable)
                signal = self._arriving(node) if node in self.incoming else None
                source = self.elements[signal.source[0]] if signal else None
                if signal and isinstance(source, Component):
                    start = (names[source.path], self._output(source, signal.source[1], node))
                    found.wires[name, self._input(component, variable)] = (start, signal.change)
                elif given := self._given(component, variable, signal, settings):
                    values[row.name] = self._value(*given[0], component, variable)
        found.ignored = self.unused
        return found

    def _names(self) -> dict[Path_, str]:
        """The name of each component: those of its systems and its own, joined by slashes."""
        names = {c.path: "/".join(c.path).replace(".", "/") for c in self.system.components()}
        for path, name in names.items():
            if list(names.values()).count(name) > 1:
                raise self.package.refused(".".join(path), f"there are two components {name} in the flat system")
        return names

    # Connections -----------------------------------------------------------------------------------------------

    def _visit(self, system: System) -> None:
        for element in system.elements.values():
            self.elements[element.path] = element
            if isinstance(element, System):
                self._visit(element)
        for connection in system.connections:
            source, target = self._directed(system, connection)
            if target in self.incoming:
                raise self.package.refused(self._shown(target), "has two connections into it; SSP has no sums")
            self.incoming[target] = source, connection

    def _directed(self, system: System, connection: Connection) -> tuple[Node, Node]:
        """Source and target of a connection, from the kinds of its connectors."""
        nodes, gives = [], []
        for element, connector in connection.ends:
            if element and element not in system.elements:
                raise self.package.refused(
                    system.name, f"connects {element}.{connector}: {unknown('element', element, system.elements)}"
                )
            owner = system.elements[element] if element else system
            nodes.append((owner.path, connector))
            gives.append(self._gives(owner, connector, inside=not element))
        if gives[0] is None and gives[1] is not None:
            gives[0] = not gives[1]
        if gives[1] is None and gives[0] is not None:
            gives[1] = not gives[0]
        if sorted(map(str, gives)) != ["False", "True"]:
            raise self.package.refused(
                system.name,
                f"connects {self._shown(nodes[0])} with {self._shown(nodes[1])}, which are not an output and an input",
            )
        return (nodes[0], nodes[1]) if gives[0] else (nodes[1], nodes[0])

    def _gives(self, owner: Element, connector: str, inside: bool) -> bool | None:
        """Whether a value goes out of a connector into the connection; None where its kind does not say."""
        if isinstance(owner, Component):
            if connector not in owner.variables:
                raise self.package.refused(owner.name, str(unknown("connector", connector, owner.variables)))
            return owner.variables[connector].causality in SOURCES
        if connector not in owner.connectors:
            raise self.package.refused(owner.name, str(unknown("connector", connector, owner.connectors)))
        kind = owner.connectors[connector].kind
        return (kind in SINKS) == inside if kind in SOURCES + SINKS else None

    def _arriving(self, node: Node, following: tuple[Node, ...] = ()) -> _Signal:
        """What arrives at a connector through connections."""
        if node in following:
            raise self.package.refused(self._shown(node), "is connected with itself through systems")
        if node not in self.incoming:
            return _Signal(node, IDENTITY, self._unit(node), ((node, IDENTITY),) if self._is_system(node) else ())
        source, connection = self.incoming[node]
        before, unit = self._arriving(source, (*following, node)), self._unit(node)
        try:
            converted = conversion(before.unit, unit) if connection.converts else IDENTITY
        except InputError as error:
            ends = f"connection of {self._shown(source)} with {self._shown(node)}"
            raise self.package.refused(ends, str(error)) from None
        change = converted.then(connection.transformation)
        passed = tuple((at, so_far.then(change)) for at, so_far in before.passed)
        own = ((node, IDENTITY),) if self._is_system(node) else ()
        return _Signal(before.source, before.change.then(change), unit or before.unit, (*passed, *own))

    def _is_system(self, node: Node) -> bool:
        return isinstance(self.elements[node[0]], System)

    def _unit(self, node: Node) -> UnitDefinition | None:
        owner = self.elements[node[0]]
        return owner.unit(node[1]) if isinstance(owner, Component) else owner.connectors[node[1]].unit

    def _output(self, component: Component, name: str, target: Node) -> str:
        variable = component.variables[name]
        if variable.causality != "output":
            raise self.package.refused(
                f"connection of {component.name}.{name} with {self._shown(target)}",
                f"starts at a {variable.causality}; only outputs can drive an input",
            )
        return self._connected(component, name)

    def _input(self, component: Component, name: str) -> str:
        if component.variables[name].causality != "input":
            raise self.package.refused(
                f"{component.name}.{name}",
                f"is a {component.variables[name].causality} driven by an output; only inputs can be",
            )
        return self._connected(component, name)

    def _connected(self, component: Component, name: str) -> str:
        variable = component.variables[name]
        if variable.type not in REAL or variable.dimensions:
            kind = "an array" if variable.dimensions else f"of type {variable.type}"
            raise self.package.refused(f"{component.name}.{name}", f"is {kind}; only Real and Float64 can be connected")
        return variable.name

    def _shown(self, node: Node) -> str:
        return ".".join((*node[0], node[1]))

    # Values ----------------------------------------------------------------------------------------------------

    def _settings(self, element: Component | System) -> dict[Node, Setting]:
        """The values that are bound to connectors and variables in an element, its own over those of its parts."""
        found: dict[Node, Setting] = {}
        for part in element.elements.values() if isinstance(element, System) else ():
            found |= self._settings(part)
        for setting in element.settings:
            nodes = list(_named(element, setting.name))
            found |= dict.fromkeys(nodes, setting)
            if not nodes:
                self.unused.append(".".join((*element.path, setting.name)))
        return found

    def _given(
        self, component: Component, variable: str, signal: _Signal | None, settings: Mapping[Node, Setting]
    ) -> list[tuple[Setting, Affine, UnitDefinition | None]]:
        """The values for a variable, the one that counts first: each with its way from there, and its unit there."""
        own = component.unit(variable) if component.variables[variable].type in REAL else None
        places = [*(signal.passed if signal else ()), ((component.path, variable), IDENTITY)]
        return [
            (settings[at], change, (self._unit(at) if self._is_system(at) else None) or own)
            for at, change in places
            if at in settings
        ]

    def _value(
        self, setting: Setting, change: Affine, unit: UnitDefinition | None, component: Component, variable: str
    ) -> Value:
        """A value that is given in a unit at a connector, as it arrives at a variable."""
        row = component.variables[variable]
        where = f"{component.name}.{variable}"
        if row.causality == "structuralParameter":
            raise self.package.refused(where, "is a structural parameter; setting it is not supported")
        try:
            value = setting.value(row, unit)
        except InputError as error:
            raise self.package.refused(f"value {setting.name} for {where}", str(error)) from None
        return change(float(value)) if row.type in REAL else value


def _named(element: Component | System, name: str) -> Iterator[Node]:
    """Every connector and variable with that hierarchical name in an element."""
    if isinstance(element, Component):
        if name in element.variables:
            yield element.path, name
        return
    if name in element.connectors:
        yield element.path, name
    for own, part in element.elements.items():
        if name.startswith(f"{own}."):
            yield from _named(part, name[len(own) + 1 :])
