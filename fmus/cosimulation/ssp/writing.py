"""Writes a system of FMUs as an SSP archive, which other tools open as it is.

Values of parameters and starts are bound inline. SSP has no sums: an input takes one connection. An input without a
connection is not listed as a connector: it keeps its value, while fmpy's runner would give it the value of another. The
annotation `org.openmodelica` names the master and its step, without which OMSimulator refuses a system. The archive is
the same to the byte for the same FMUs and values.
"""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.etree import ElementTree as Xml

from fmpy.model_description import ModelDescription, ModelVariable

from fmus.cosimulation.network import agree
from fmus.cosimulation.ssp.package import FMU, SPACES, SSC, SSD, SSV, STRUCTURE
from fmus.cosimulation.ssp.units import EXPONENTS, named_unit, units_of_fmu
from fmus.cosimulation.subsystems.fmu_subsystem import model_description
from fmus.cosimulation.subsystems.typed_values import Value
from fmus.export.build import archive
from fmus.support.errors import InputError, unknown
from fmus.support.files import write_atomically

VERSIONS = {"1": "1.0", "2": "2.0"}
OMS = "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd"
MASTER = {"description": "oms-ma", "absoluteTolerance": "1e-4", "relativeTolerance": "1e-4"}  # of OMSimulator's default
CONNECTED = ("Real", "Float64", "Integer", "Boolean")  # types of connectors that are written
NO_FILE_NAME = r"[^\w-]"
STEP, STOP = 0.001, 1.0  # s
for prefix, space in {**SPACES, "oms": OMS}.items():
    Xml.register_namespace(prefix, space)


def write_ssp(path: str | Path, fmus: Mapping[str, str | Path], wiring: Mapping[str, Sequence[str]],
              values: Mapping[str, Mapping[str, Value]] | None = None, version: int | str = 1, *,
              step: float = STEP, stop: float = STOP) -> Path:  # fmt: skip
    """An archive of FMUs by name, wired input -> [output], with values of parameters and starts by FMU and name.

    version is 1 or 2 (of the standard); step and stop [s] are defaults for the tool that runs it. Raises InputError for
    a signal that no FMU has, units that differ, an input with several sources, and an FMI 3 FMU in version 1.
    """
    if str(version) not in VERSIONS:
        raise unknown("SSP version", version, VERSIONS)
    number = VERSIONS[str(version)]
    descriptions = {name: model_description(fmu) for name, fmu in fmus.items()}
    for name, description in descriptions.items():
        if number == "1.0" and description.fmiVersion.startswith("3"):
            raise InputError(
                f"{name} is an FMU of FMI 3.0, which SSP 1.0 does not have: write SSP 2.0, or build FMI 2.0"
            )
    check_wiring(descriptions, wiring)
    files = _files(fmus)
    title = re.sub(r"\W", "_", Path(path).stem, flags=re.ASCII)
    root = Xml.Element(f"{{{SSD}}}SystemStructureDescription", version=number, name=title)
    system = Xml.SubElement(root, f"{{{SSD}}}System", name=title)
    elements = Xml.SubElement(system, f"{{{SSD}}}Elements")
    for name, description in descriptions.items():
        component = Xml.SubElement(elements, f"{{{SSD}}}Component", name=name, type=FMU, source=files[name])
        _connectors(component, name, description, wiring)
        _bind(component, name, description, (values or {}).get(name, {}), number)
    _connections(system, wiring)
    _annotate(system, step)
    _units(root, descriptions)
    Xml.SubElement(root, f"{{{SSD}}}DefaultExperiment", startTime="0.0", stopTime=repr(float(stop)))
    Xml.indent(root)
    contents = {files[name]: Path(fmus[name]).read_bytes() for name in fmus}
    contents[STRUCTURE] = b'<?xml version="1.0" encoding="UTF-8"?>\n' + Xml.tostring(root, "utf-8") + b"\n"
    return write_atomically(path, lambda beside: beside.write_bytes(archive(contents)))


def _files(fmus: Mapping[str, str | Path]) -> dict[str, str]:
    """The place of each FMU in the archive; one that is used twice is stored once."""
    first: dict[Path, str] = {}
    for name, fmu in fmus.items():
        first.setdefault(Path(fmu).resolve(), f"resources/{re.sub(NO_FILE_NAME, '_', name)}.fmu")
    return {name: first[Path(fmu).resolve()] for name, fmu in fmus.items()}


def _connectors(component: Xml.Element, name: str, description: ModelDescription,
                wiring: Mapping[str, Sequence[str]]) -> None:  # fmt: skip
    connectors = Xml.SubElement(component, f"{{{SSD}}}Connectors")
    for variable in description.modelVariables:
        driven = f"{name}.{variable.name}" in wiring
        if (variable.causality == "output" and variable.type in CONNECTED and not variable.dimensions) or driven:
            connector = Xml.SubElement(connectors, f"{{{SSD}}}Connector", name=variable.name, kind=variable.causality)
            Xml.SubElement(connector, f"{{{SSC}}}{variable.type}", {"unit": variable.unit} if variable.unit else {})


def _bind(component: Xml.Element, name: str, description: ModelDescription, values: Mapping[str, Value],
          version: str) -> None:  # fmt: skip
    """The values of a component as a parameter set."""
    if not values:
        return
    bindings = Xml.SubElement(component, f"{{{SSD}}}ParameterBindings")
    holder = Xml.SubElement(Xml.SubElement(bindings, f"{{{SSD}}}ParameterBinding"), f"{{{SSD}}}ParameterValues")
    parameter_set = Xml.SubElement(holder, f"{{{SSV}}}ParameterSet", version=version, name=f"{name}_values")
    parameters = Xml.SubElement(parameter_set, f"{{{SSV}}}Parameters")
    known = {v.name: v for v in description.modelVariables}
    for key, value in values.items():
        if key not in known:
            raise unknown(f"variable of {name}", key, known)
        parameter = Xml.SubElement(parameters, f"{{{SSV}}}Parameter", name=key)
        unit = {"unit": known[key].unit} if known[key].unit else {}
        Xml.SubElement(parameter, f"{{{SSV}}}{known[key].type}", {"value": _text(value, known[key]), **unit})


def _text(value: Value, variable: ModelVariable) -> str:
    if variable.type == "Boolean":
        return str(bool(value)).lower()
    return repr(float(value)) if variable.type in ("Real", "Float64", "Float32") else str(value)


def _connections(system: Xml.Element, wiring: Mapping[str, Sequence[str]]) -> None:
    connections = Xml.SubElement(system, f"{{{SSD}}}Connections")
    for target, sources in wiring.items():
        (start, output), (end, given) = (s.split(".", 1) for s in (sources[0], target))
        Xml.SubElement(connections, f"{{{SSD}}}Connection", startElement=start, startConnector=output,
                       endElement=end, endConnector=given)  # fmt: skip


def _annotate(system: Xml.Element, step: float) -> None:
    """The master of OMSimulator (schema of OMSimulator, oms.xsd)."""
    annotation = Xml.SubElement(
        Xml.SubElement(system, f"{{{SSD}}}Annotations"), f"{{{SSC}}}Annotation", type="org.openmodelica"
    )
    information = Xml.SubElement(Xml.SubElement(annotation, f"{{{OMS}}}Annotations"), f"{{{OMS}}}SimulationInformation")
    Xml.SubElement(information, f"{{{OMS}}}FixedStepMaster", {**MASTER, "stepSize": repr(float(step))})


def _units(root: Xml.Element, descriptions: Mapping[str, ModelDescription]) -> None:
    """The units in use, as the FMUs define them."""
    defined = {name: u for d in descriptions.values() for name, u in units_of_fmu(d).items()}
    units = Xml.SubElement(root, f"{{{SSD}}}Units")
    for name in sorted({v.unit for d in descriptions.values() for v in d.modelVariables if v.unit}):
        found = named_unit(name, defined)
        if found is None or found.exponents is None:
            continue
        base = {n: str(e) for n, e in zip(EXPONENTS, found.exponents, strict=True) if e}
        numbers = {n: repr(x) for n, x, default in (("factor", found.factor, 1.0), ("offset", found.offset, 0.0))
                   if x != default}  # fmt: skip
        Xml.SubElement(Xml.SubElement(units, f"{{{SSC}}}Unit", name=name), f"{{{SSC}}}BaseUnit", {**base, **numbers})


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
