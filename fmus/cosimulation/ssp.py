"""Systems of FMUs in one file: SSP 1.0 archives, written for any wiring and read back.

    SystemStructure.ssd    components, their connectors with units, connections, parameter bindings
    resources/NAME.fmu     the FMUs

Values of parameters and starts of states are bound inline. SSP has no sums: an input takes one connection. An input
without a connection is not listed as a connector: it keeps its bound value, while fmpy's runner would give it the value
of another. Flat systems of FMUs can be read, as SSP 1.0 requires of every tool. Standard: System Structure and
Parameterization 1.0, Modelica Association, 2019.
"""

import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from xml.etree import ElementTree as Xml

from fmpy.model_description import ModelDescription

from fmus.cosimulation.network import agree
from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem, model_description
from fmus.declaration.units import BASE, unit
from fmus.support.errors import InputError, unknown
from fmus.support.files import write_atomically

SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
FMU = "application/x-fmu-sharedlibrary"
STRUCTURE = "SystemStructure.ssd"
for prefix, space in (("ssd", SSD), ("ssc", SSC), ("ssv", SSV)):
    Xml.register_namespace(prefix, space)


def write_ssp(path: str | Path, fmus: Mapping[str, str | Path], wiring: Mapping[str, Sequence[str]],
              values: Mapping[str, Mapping[str, float]] | None = None) -> Path:  # fmt: skip
    """An archive of FMUs by name, wired input -> [output], with values of parameters and starts by unit and name.

    Raises InputError for a signal that no FMU has, units that differ, or an input with several sources.
    """
    descriptions = {name: model_description(fmu) for name, fmu in fmus.items()}
    check_wiring(descriptions, wiring)
    root = Xml.Element(f"{{{SSD}}}SystemStructureDescription", version="1.0", name=Path(path).stem)
    system = Xml.SubElement(root, f"{{{SSD}}}System", name=Path(path).stem)
    elements = Xml.SubElement(system, f"{{{SSD}}}Elements")
    for name, description in descriptions.items():
        _component(elements, name, Path(fmus[name]).name, description, wiring, (values or {}).get(name, {}))
    connections = Xml.SubElement(system, f"{{{SSD}}}Connections")
    for target, sources in wiring.items():
        for source in sources:
            (start, output), (end, given) = (s.split(".", 1) for s in (source, target))
            Xml.SubElement(
                connections,
                f"{{{SSD}}}Connection",
                startElement=start,
                startConnector=output,
                endElement=end,
                endConnector=given,
            )
    _units(root, descriptions)
    Xml.indent(root)

    def write(beside: Path) -> None:
        with zipfile.ZipFile(beside, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr(STRUCTURE, b'<?xml version="1.0" encoding="UTF-8"?>\n' + Xml.tostring(root, "utf-8"))
            for fmu in {Path(f).name: Path(f) for f in fmus.values()}.values():
                archive.write(fmu, f"resources/{fmu.name}")

    return write_atomically(path, write)


def _component(parent: Xml.Element, name: str, file: str, description: ModelDescription,
               wiring: Mapping[str, Sequence[str]], values: Mapping[str, float]) -> None:  # fmt: skip
    component = Xml.SubElement(parent, f"{{{SSD}}}Component", name=name, type=FMU, source=f"resources/{file}")
    connectors = Xml.SubElement(component, f"{{{SSD}}}Connectors")
    for variable in description.modelVariables:
        if variable.causality == "output" or f"{name}.{variable.name}" in wiring:
            connector = Xml.SubElement(connectors, f"{{{SSD}}}Connector", name=variable.name, kind=variable.causality)
            Xml.SubElement(connector, f"{{{SSC}}}Real", {"unit": variable.unit} if variable.unit else {})
    if values:
        bindings = Xml.SubElement(component, f"{{{SSD}}}ParameterBindings")
        holder = Xml.SubElement(Xml.SubElement(bindings, f"{{{SSD}}}ParameterBinding"), f"{{{SSD}}}ParameterValues")
        parameters = Xml.SubElement(
            Xml.SubElement(holder, f"{{{SSV}}}ParameterSet", version="1.0", name=f"{name}_values"),
            f"{{{SSV}}}Parameters",
        )
        known = {v.name: v for v in description.modelVariables}
        for key, value in values.items():
            if key not in known:
                raise unknown(f"variable of {name}", key, known)
            parameter = Xml.SubElement(parameters, f"{{{SSV}}}Parameter", name=key)
            Xml.SubElement(
                parameter,
                f"{{{SSV}}}Real",
                {"value": repr(float(value)), **({"unit": known[key].unit} if known[key].unit else {})},
            )


def _units(root: Xml.Element, descriptions: Mapping[str, ModelDescription]) -> None:
    """The units in use with their exponents of the base units."""
    used = {v.unit for d in descriptions.values() for v in d.modelVariables if v.unit}
    units = Xml.SubElement(root, f"{{{SSD}}}Units")
    for name in sorted(used):
        try:
            found = unit(name)
        except InputError:
            continue
        exponents = {base: str(e) for base, e in zip(BASE, found.exponents, strict=True) if e}
        factor = {"factor": repr(found.factor)} if found.factor != 1.0 else {}
        Xml.SubElement(
            Xml.SubElement(units, f"{{{SSC}}}Unit", name=name), f"{{{SSC}}}BaseUnit", {**exponents, **factor}
        )


def check_wiring(descriptions: Mapping[str, ModelDescription], wiring: Mapping[str, Sequence[str]]) -> None:
    """Raises InputError for a signal that does not exist, an input with two writers, or units that differ."""
    signals = {
        f"{name}.{v.name}": v
        for name, d in descriptions.items()
        for v in d.modelVariables
        if v.causality in ("input", "output")
    }
    for target, sources in wiring.items():
        if len(sources) != 1:
            raise InputError(
                f"{target} has {len(sources)} writers: {', '.join(sources)}; an SSP has no sums, join the parts into "
                "one FMU"
            )
        for role, name in (("input", target), ("output", sources[0])):
            if name not in signals or signals[name].causality != role:
                raise unknown(role, name, [n for n, v in signals.items() if v.causality == role])
        given, wanted = signals[sources[0]].unit, signals[target].unit
        if not agree(given or "", wanted or ""):
            raise InputError(f"{sources[0]} [{given}] cannot drive {target} [{wanted}]: the units differ")


def read_ssp(path: str | Path) -> tuple[dict[str, FmuSubsystem], dict[str, list[str]]]:
    """The FMUs of an archive, initialised with the values bound to them, and their wiring.

    Raises InputError for a file that is not an SSP, for elements other than FMUs in a flat system, and
    for invalid connections.
    """
    with TemporaryDirectory() as folder:
        try:
            with zipfile.ZipFile(path) as archive:
                archive.extractall(folder)
            system = Xml.parse(Path(folder, STRUCTURE)).getroot().find(f"{{{SSD}}}System")
        except (OSError, KeyError, zipfile.BadZipFile, Xml.ParseError) as error:
            raise InputError(f"{path} is not an SSP archive that can be read: {error}") from None
        components = list(system.iterfind(f"{{{SSD}}}Elements/*")) if system is not None else []
        for component in components:
            if component.tag != f"{{{SSD}}}Component" or component.get("type", FMU) != FMU:
                raise InputError(
                    f"{path}: {component.get('name')} is not an FMU; only flat systems of FMUs can be read"
                )
        assert system is not None or not components
        files = {c.get("name", ""): Path(folder, PurePosixPath(c.get("source", ""))) for c in components}
        wiring: dict[str, list[str]] = {}
        for c in system.iterfind(f"{{{SSD}}}Connections/{{{SSD}}}Connection") if system is not None else ():
            if c.get("startElement") and c.get("endElement"):
                wiring.setdefault(f"{c.get('endElement')}.{c.get('endConnector')}", []).append(
                    f"{c.get('startElement')}.{c.get('startConnector')}"
                )
        check_wiring({name: model_description(file) for name, file in files.items()}, wiring)
        values = {c.get("name", ""): _values(c) for c in components}
        return {name: FmuSubsystem(file, name, values[name]) for name, file in files.items()}, wiring


def _values(component: Xml.Element) -> dict[str, float]:
    """The values that are bound to a component."""
    return {p.get("name", ""): float(p[0].get("value", "nan")) for p in component.iter(f"{{{SSV}}}Parameter") if len(p)}
