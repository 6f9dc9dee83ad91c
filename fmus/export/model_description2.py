"""modelDescription.xml of FMI 2.0, rendered from a component.

Units with their base units and display units, bounds, starts, exact dependencies: everything comes from the
component's table and equations. The identifier and the date do not depend on when and where it is rendered.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from math import isfinite
from xml.etree import ElementTree as Xml

from fmus.declaration.units import BASE, DISPLAY, unit
from fmus.export import dependencies
from fmus.export.interface import TOLERANCE, FmuVariable, Interface

DATE = "1980-01-01T00:00:00Z"  # the earliest date of a zip archive; the date of the build would make builds differ
TOOL = "motofmi"
LOG_CATEGORIES = {
    "logStatusError": "What could not be done, with the variable, its value and its bound",
    "logStatusDiscard": "Steps that could not be done, with the reason",
    "logStatusWarning": "What was done, but not as asked",
    "logAll": "All messages",
}


@dataclass(frozen=True)
class Capabilities:
    """Capabilities of a back end as attributes of FMI 2.0; `exchange`: whether it offers model exchange as well."""

    exchange: bool = True
    cosimulation: tuple[tuple[str, str], ...] = ()
    sources: tuple[str, ...] = ()


def compiled(interface: Interface, sources: Iterable[str]) -> Capabilities:
    """The capabilities of the compiled back end."""
    return Capabilities(True, (
        ("canHandleVariableCommunicationStepSize", "true"),
        ("canInterpolateInputs", "true"),
        ("maxOutputDerivativeOrder", str(interface.output_order)),
        ("canNotUseMemoryManagementFunctions", "true"),
        ("canGetAndSetFMUstate", "true"),
        ("canSerializeFMUstate", "true"),
        ("providesDirectionalDerivative", "true"),
        ("canBeInstantiatedOnlyOncePerProcess", "false"),
    ), tuple(sources))  # fmt: skip


def model_description(interface: Interface, identifier: str, guid: str, can: Capabilities) -> bytes:
    """The file's bytes, UTF-8, the same for the same component."""
    component = interface.component
    root = Xml.Element("fmiModelDescription", {
        "fmiVersion": "2.0", "modelName": component.name, "guid": guid, **described(component),
        "generationTool": TOOL, "generationDateAndTime": DATE, "variableNamingConvention": "structured",
        "numberOfEventIndicators": "0",
    })  # fmt: skip
    if can.exchange:
        shared = {
            k: v for k, v in can.cosimulation if k.startswith(("canNot", "canGet", "canSerialize", "provides", "canBe"))
        }
        _interface_type(root, "ModelExchange", identifier, shared, can.sources)
    _interface_type(root, "CoSimulation", identifier, dict(can.cosimulation), can.sources)
    complete(root, interface, (_scalar_variable(interface, v) for v in interface.variables), _structure(interface))
    return to_bytes(root)


def complete(root: Xml.Element, interface: Interface, variables: Iterable[Xml.Element], structure: Xml.Element) -> None:
    """Add the elements that follow the kinds of FMU; variables and structure differ between FMI 2 and 3."""
    root.append(unit_definitions(interface))
    categories = Xml.SubElement(root, "LogCategories")
    for name, meaning in LOG_CATEGORIES.items():
        Xml.SubElement(categories, "Category", name=name, description=meaning)
    Xml.SubElement(
        root, "DefaultExperiment", startTime="0", stopTime="1", tolerance=repr(TOLERANCE.start), stepSize="0.001"
    )
    Xml.SubElement(root, "ModelVariables").extend(variables)
    root.append(structure)


def described(component) -> dict[str, str]:
    """Attributes of the model: name, description, source of the values."""
    description = (component.__doc__ or component.title).strip().splitlines()[0]
    if component.source:
        description += f" Values: {component.source}"
    return {"description": description, "copyright": "BSD-3-Clause"}


def to_bytes(root: Xml.Element) -> bytes:
    """The document, indented, with its declaration."""
    Xml.indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + Xml.tostring(root, "utf-8") + b"\n"


def unit_definitions(interface: Interface) -> Xml.Element:
    """Every unit in use, with its exponents of the base units and its display unit."""
    definitions = Xml.Element("UnitDefinitions")
    for name in sorted({v.row.unit for v in interface.variables}):
        element = Xml.SubElement(definitions, "Unit", name=name)
        exponents = {b: str(e) for b, e in zip(BASE, unit(name).exponents, strict=True) if e}
        Xml.SubElement(element, "BaseUnit", exponents)
        if name in DISPLAY:
            Xml.SubElement(element, "DisplayUnit", name=DISPLAY[name], factor=repr(unit(name).to(unit(DISPLAY[name]))))
    return definitions


def bounds(variable: FmuVariable) -> dict[str, str]:
    """The attributes min, max and nominal where the table has them."""
    row = variable.row
    limits = {"min": row.min, "max": row.max} if variable.role != "derivative" else {}
    found = {key: repr(float(value)) for key, value in limits.items() if isfinite(value)}
    return found if variable.nominal == 1.0 else {**found, "nominal": repr(float(variable.nominal))}


def causality(interface: Interface, variable: FmuVariable) -> dict[str, str]:
    """The attributes causality, variability and initial, which FMI 2 and 3 share."""
    row = variable.row
    if variable.role == "time":
        return {"causality": "independent", "variability": "continuous"}
    if variable.role == "parameter":
        return {"causality": "parameter", "variability": "tunable" if row.tunable else "fixed", "initial": "exact"}
    if variable.role == "calculated":
        tunable = any(r.tunable for r in interface.component.rows("parameter").values())
        return {
            "causality": "calculatedParameter",
            "variability": "tunable" if tunable else "fixed",
            "initial": "calculated",
        }
    if variable.role == "input":
        return {"causality": "input", "variability": "continuous"}
    if variable.role == "state":
        return {"causality": "output" if row.exposed else "local", "variability": "continuous", "initial": "exact"}
    shown = "output" if variable.role == "output" else "local"
    return {"causality": shown, "variability": "continuous", "initial": "calculated"}


def has_start(variable: FmuVariable) -> bool:
    return variable.role in ("parameter", "input", "state")


def _interface_type(
    root: Xml.Element, kind: str, identifier: str, attributes: dict[str, str], sources: Iterable[str]
) -> None:
    element = Xml.SubElement(root, kind, {"modelIdentifier": identifier, **attributes})
    if sources:
        files = Xml.SubElement(element, "SourceFiles")
        for name in sources:
            Xml.SubElement(files, "File", name=name)


def _scalar_variable(interface: Interface, variable: FmuVariable) -> Xml.Element:
    row = variable.row
    element = Xml.Element("ScalarVariable", {"name": variable.name, "valueReference": str(variable.reference),
                                             "description": row.description,
                                             **causality(interface, variable)})  # fmt: skip
    real = {"unit": row.unit, **bounds(variable)}
    if row.unit in DISPLAY:
        real["displayUnit"] = DISPLAY[row.unit]
    if has_start(variable):
        real["start"] = repr(float(variable.start))
    if variable.role == "derivative":
        real["derivative"] = str(interface.reference(variable.name[4:-1]) + 1)
    Xml.SubElement(element, "Real", real)
    return element


def _structure(interface: Interface) -> Xml.Element:
    """ModelStructure; an index counts the variables from 1."""
    structure = Xml.Element("ModelStructure")

    def index(name: str) -> str:
        return str(interface.reference(name) + 1)

    for tag, rows in (
        ("Outputs", dependencies.outputs(interface)),
        ("Derivatives", dependencies.derivatives(interface)),
    ):
        if rows:
            parent = Xml.SubElement(structure, tag)
        for row in rows:
            Xml.SubElement(parent, "Unknown", index=index(row.unknown), dependencies=" ".join(map(index, row.kinds)),
                           dependenciesKind=" ".join(row.kinds.values()))  # fmt: skip
    unknowns = dependencies.initial_unknowns(interface)
    if unknowns:
        parent = Xml.SubElement(structure, "InitialUnknowns")
    for unknown, known in unknowns:
        Xml.SubElement(parent, "Unknown", index=index(unknown), dependencies=" ".join(map(index, known)))
    return structure
