"""The XML files of FMI 3.0, rendered from a component: model description, terminals, build description.

A port is a terminal, also in archives of FMI 2.0 (since 2.0.4, 2.3, "Terminals and Icons"). Its members have the same
names on both sides, so that terminals plug into each other. An angle or a rate is a `signal`. A torque sums up: as an
output it is an `outflow` and as an input an `inflow`, so that no sign changes in the connection (FMI 3.0, 2.4.9.2.7).
"""

from collections.abc import Iterable
from xml.etree import ElementTree as Xml

from fmus.declaration.units import DISPLAY
from fmus.export import dependencies
from fmus.export.interface import FmuVariable, Interface
from fmus.export.model_description2 import DATE, TOOL, bounds, causality, complete, described, has_start, to_bytes

COMMON = {"canGetAndSetFMUState": "true", "canSerializeFMUState": "true",
          "providesDirectionalDerivatives": "true", "providesAdjointDerivatives": "true"}  # fmt: skip

EXTENT = {"x1": "-100", "y1": "-100", "x2": "100", "y2": "100"}  # the default of the standard


def model_description(interface: Interface, identifier: str, token: str) -> bytes:
    """modelDescription.xml, UTF-8, the same for the same component."""
    root = Xml.Element("fmiModelDescription", {
        "fmiVersion": "3.0", "modelName": interface.component.name, "instantiationToken": token,
        **described(interface.component),
        "generationTool": TOOL, "generationDateAndTime": DATE, "variableNamingConvention": "structured",
    })  # fmt: skip
    Xml.SubElement(root, "ModelExchange", {"modelIdentifier": identifier, **COMMON})
    Xml.SubElement(root, "CoSimulation", {
        "modelIdentifier": identifier, **COMMON, "canHandleVariableCommunicationStepSize": "true",
        "maxOutputDerivativeOrder": str(interface.output_order), "providesIntermediateUpdate": "true",
        "canReturnEarlyAfterIntermediateUpdate": "true",
    })  # fmt: skip
    complete(root, interface, (_float64(interface, v) for v in interface.variables), _structure(interface))
    return to_bytes(root)


def terminals(interface: Interface) -> bytes:
    """terminalsAndIcons.xml: the place of the icon, and a terminal for each port."""
    members: dict[tuple[str, str], list[FmuVariable]] = {}
    for variable in interface.variables:
        if variable.row.port and variable.role != "derivative":
            part, _, _ = variable.name.rpartition(".")
            members.setdefault((part, variable.row.port), []).append(variable)
    root = Xml.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    graphic = Xml.SubElement(root, "GraphicalRepresentation")
    Xml.SubElement(graphic, "CoordinateSystem", {**EXTENT, "suggestedScalingFactorTo_mm": "0.1"})
    Xml.SubElement(graphic, "Icon", EXTENT)
    parent = Xml.SubElement(root, "Terminals") if members else root
    for (part, port), variables in members.items():
        terminal = Xml.SubElement(parent, "Terminal", name=f"{part}.{port}" if part else port, matchingRule="plug")
        for variable in variables:
            Xml.SubElement(terminal, "TerminalMemberVariable", variableName=variable.name,
                           memberName=variable.name.rpartition(".")[2],
                           variableKind=_kind(variable))  # fmt: skip
    return to_bytes(root)


def _kind(variable: FmuVariable) -> str:
    if not variable.row.flow:
        return "signal"
    return "inflow" if variable.role == "input" else "outflow"


def build_description(identifier: str, sources: Iterable[str]) -> bytes:
    """sources/buildDescription.xml."""
    root = Xml.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = Xml.SubElement(root, "BuildConfiguration", modelIdentifier=identifier)
    files = Xml.SubElement(configuration, "SourceFileSet", language="C99")
    for name in sources:
        Xml.SubElement(files, "SourceFile", name=name)
    return to_bytes(root)


def _float64(interface: Interface, variable: FmuVariable) -> Xml.Element:
    row = variable.row
    element = Xml.Element("Float64", {"name": variable.name, "valueReference": str(variable.reference),
                                      "description": row.description, **causality(interface, variable)})  # fmt: skip
    if variable.role == "input":
        element.set("intermediateUpdate", "true")
    element.set("unit", row.unit)
    if row.unit in DISPLAY:
        element.set("displayUnit", DISPLAY[row.unit])
    for key, value in bounds(variable).items():
        element.set(key, value)
    if variable.role == "derivative":
        element.set("derivative", str(interface.reference(variable.name[4:-1])))
    if has_start(variable):
        element.set("start", repr(float(variable.start)))
    return element


def _structure(interface: Interface) -> Xml.Element:
    """ModelStructure, with variables by their value references."""
    structure = Xml.Element("ModelStructure")

    def references(names: Iterable[str]) -> str:
        return " ".join(str(interface.reference(n)) for n in names)

    for tag, rows in (
        ("Output", dependencies.outputs(interface)),
        ("ContinuousStateDerivative", dependencies.derivatives(interface)),
    ):
        for row in rows:
            Xml.SubElement(structure, tag, valueReference=references([row.unknown]), dependencies=references(row.kinds),
                           dependenciesKind=" ".join(row.kinds.values()))  # fmt: skip
    for unknown, known in dependencies.initial_unknowns(interface):
        Xml.SubElement(
            structure, "InitialUnknown", valueReference=references([unknown]), dependencies=references(known)
        )
    return structure
