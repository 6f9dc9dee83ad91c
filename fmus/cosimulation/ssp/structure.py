"""The structure of a system as an SSP archive describes it: elements, connectors, connections, parameter bindings."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from xml.etree import ElementTree as Xml

from fmpy.model_description import ModelDescription, ModelVariable

from fmus.cosimulation.ssp.package import FMU, SSD, SSM, SSV, STRUCTURE, Package, local, truth
from fmus.cosimulation.ssp.parameters import Setting, linear, mapped, settings_of, transformations
from fmus.cosimulation.ssp.units import IDENTITY, Affine, UnitDefinition, defined_units, named_unit, units_of_fmu
from fmus.cosimulation.subsystems.fmu_subsystem import model_description
from fmus.support.errors import InputError

Path_ = tuple[str, ...]  # the names of the systems that contain an element, and its own
KINDS = ("input", "output", "inout", "parameter", "calculatedParameter", "structuralParameter", "constant", "local",
         "unspecified")  # fmt: skip


@dataclass(frozen=True)
class Connector:
    """A connector of a component or of a system; unit is None where none is stated."""

    kind: str
    unit: UnitDefinition | None


@dataclass(frozen=True)
class Connection:
    """A connection of two connectors, each (element, connector), element "" for the system itself."""

    ends: tuple[tuple[str, str], tuple[str, str]]
    converts: bool
    transformation: Affine


@dataclass
class Element:
    """A component or a system. settings are those of its bindings, in their order."""

    path: Path_
    connectors: dict[str, Connector]
    settings: list[Setting] = field(default_factory=list)

    @property
    def name(self) -> str:
        """Its name in messages."""
        return ".".join(self.path) or "the system"


@dataclass
class Component(Element):
    """An FMU."""

    file: Path = Path()

    @cached_property
    def description(self) -> ModelDescription:
        return model_description(self.file)

    @cached_property
    def variables(self) -> dict[str, ModelVariable]:
        """The variables by their names and aliases."""
        every = self.description.modelVariables
        return {**{alias.name: v for v in every for alias in v.aliases or ()}, **{v.name: v for v in every}}

    @cached_property
    def _units(self) -> dict[str, UnitDefinition]:
        return units_of_fmu(self.description)

    def unit(self, variable: str) -> UnitDefinition | None:
        """The unit of a variable as the FMU states it, else as its connector does."""
        stated = self.variables[variable]
        name = stated.unit or getattr(stated.declaredType, "unit", None)
        connector = self.connectors.get(variable)
        return named_unit(name, self._units) or (connector.unit if connector else None)


@dataclass
class System(Element):
    """A system with its elements by name."""

    elements: Mapping[str, "Component | System"] = field(default_factory=dict)
    connections: list[Connection] = field(default_factory=list)

    def components(self) -> Iterator[Component]:
        """All components, those of nested systems included."""
        for each in self.elements.values():
            yield from each.components() if isinstance(each, System) else [each]


@dataclass(frozen=True)
class Structure:
    """The root system of an archive, and the start and stop time [s] of its default experiment."""

    system: System
    start: float
    stop: float | None


def read_structure(package: Package) -> Structure:
    """The structure of an archive. Raises InputError with file, element and reason for what is not supported."""
    root = package.xml(STRUCTURE, f"{{{SSD}}}SystemStructureDescription", STRUCTURE)
    system = root.find(f"{{{SSD}}}System")
    if system is None:
        raise package.refused(STRUCTURE, "has no System")
    experiment = root.find(f"{{{SSD}}}DefaultExperiment")
    given = {} if experiment is None else experiment.attrib
    try:
        start, stop = float(given.get("startTime", 0.0)), given.get("stopTime")
        return Structure(_Reader(package, root).system(system, ()), start, None if stop is None else float(stop))
    except ValueError as error:
        raise error if isinstance(error, InputError) else package.refused(STRUCTURE, str(error)) from None


class _Reader:
    def __init__(self, package: Package, root: Xml.Element):
        self.package, self.units = package, defined_units(root.iterfind(f"{{{SSD}}}Units"))

    def system(self, given: Xml.Element, path: Path_) -> System:
        name = ".".join(path) or "the system"
        elements: dict[str, Component | System] = {}
        for each in given.iterfind(f"{{{SSD}}}Elements/*"):
            own = each.get("name", "")
            if not own or own in elements:
                reason = f"has two elements {own!r}" if own else "has an element without a name"
                raise self.package.refused(name, reason)
            elements[own] = self._element(each, (*path, own))
        if given.find(f"{{{SSD}}}SignalDictionaries") is not None:
            raise self.package.refused(name, "has SignalDictionaries, which are not supported")
        found = System(path, self._connectors(given), self._settings(given, name, None), elements)
        found.connections = [
            self._connection(each, name) for each in given.iterfind(f"{{{SSD}}}Connections/{{{SSD}}}Connection")
        ]
        return found

    def _element(self, given: Xml.Element, path: Path_) -> Component | System:
        name, kind = ".".join(path), local(given.tag)
        if kind == "System":
            return self.system(given, path)
        if kind != "Component":
            raise self.package.refused(name, f"is a {kind}, which is not supported (supported: FMUs and systems)")
        type_, implementation = given.get("type", FMU), given.get("implementation", "any")
        if type_ != FMU:
            raise self.package.refused(name, f"has the type {type_}, which is not supported (supported: {FMU})")
        if implementation not in ("any", "CoSimulation"):
            raise self.package.refused(
                name, f"asks for {implementation}, which is not supported (supported: CoSimulation)"
            )
        if given.get("source") is None:
            raise self.package.refused(name, "names no source: there is no FMU to run")
        file = self.package.fmu(given.get("source", ""), name)
        return Component(path, self._connectors(given), self._settings(given, name, file), file)

    def _connectors(self, given: Xml.Element) -> dict[str, Connector]:
        found = {}
        for each in given.iterfind(f"{{{SSD}}}Connectors/{{{SSD}}}Connector"):
            unit = next((child.get("unit") for child in each if child.get("unit")), None)
            found[each.get("name", "")] = Connector(each.get("kind", "unspecified"), named_unit(unit, self.units))
        return found

    def _connection(self, given: Xml.Element, system: str) -> Connection:
        start, end = (
            (given.get(f"{side}Element", ""), given.get(f"{side}Connector", "")) for side in ("start", "end")
        )
        name = f"connection of {'.'.join(filter(None, start))} with {'.'.join(filter(None, end))} in {system}"
        if given.get("startIndices") or given.get("endIndices"):
            raise self.package.refused(name, "connects elements of arrays, which are not supported")
        change = IDENTITY
        for child in transformations(given):
            if local(child.tag) != "LinearTransformation":
                kind = local(child.tag)
                raise self.package.refused(name, f"has a {kind}; only LinearTransformation is supported here")
            change = linear(child)
        return Connection((start, end), not truth(given.get("suppressUnitConversion")), change)

    def _settings(self, given: Xml.Element, element: str, fmu: Path | None) -> list[Setting]:
        found: list[Setting] = []
        for binding in given.iterfind(f"{{{SSD}}}ParameterBindings/{{{SSD}}}ParameterBinding"):
            try:
                found += self._bound(binding, element, fmu)
            except InputError as error:
                raise error if str(self.package.path) in str(error) else self.package.refused(
                    f"parameter binding of {element}", str(error)
                ) from None
        return found

    def _bound(self, binding: Xml.Element, element: str, fmu: Path | None) -> list[Setting]:
        name = f"parameter binding of {element}"
        values = self._content(binding, "ParameterValues", f"{{{SSV}}}ParameterSet", name, fmu)
        if values is None:
            return []
        inline = binding.get("source") is None
        settings = settings_of(values, self.units if inline else {}, binding.get("prefix", ""))
        mapping = binding.find(f"{{{SSD}}}ParameterMapping")
        if mapping is None:
            return settings
        entries = self._content(mapping, "", f"{{{SSM}}}ParameterMapping", f"parameter mapping of {element}", fmu)
        return settings if entries is None else mapped(settings, entries)

    def _content(self, given: Xml.Element, holder: str, root: str, name: str, fmu: Path | None) -> Xml.Element | None:
        """The parameter set or the mapping that an element has inline, or names as its source."""
        source, type_ = given.get("source"), given.get("type")
        if type_ not in (None, "application/x-ssp-parameter-set", "application/x-ssp-parameter-mapping"):
            raise self.package.refused(name, f"has the type {type_}, which is not supported")
        if source is None:
            inside = given if not holder else given.find(f"{{{SSD}}}{holder}")
            found = None if inside is None else inside.find(root)
            return None if found is None else self.package.checked(found, root, name)
        if given.get("sourceBase", "SSD") != "component":
            return self.package.xml(source, root, name)
        if fmu is None:
            raise self.package.refused(name, "names a file inside a component, but a system has none")
        return self.package.xml_in_fmu(fmu, source, root, name)
