"""What a model description says, FMI 2.0 and FMI 3.0 under one set of names. Nothing here is checked; defaults of the
standard are filled in (FMI 2.0.4, 2.2.7; FMI 3.0, 2.4.7.4)."""

import math
from dataclasses import dataclass, field
from functools import cached_property
from xml.etree import ElementTree as Xml

KINDS = ("ModelExchange", "CoSimulation", "ScheduledExecution")
FLOATS = ("Real", "Float64", "Float32")
INTEGERS = ("Integer", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64")
LARGEST_ARRAY = 10**7  # elements that are read


@dataclass(eq=False)
class Variable:
    """One variable. reference is None where the description has no number; dimensions are (size, reference) pairs."""

    name: str
    type: str
    reference: int | None
    causality: str
    variability: str
    initial: str | None
    start: str | None
    element: Xml.Element
    typed: Xml.Element
    unit: str | None
    low: float
    high: float
    nominal: float
    derivative: str | None
    clocks: str | None
    dimensions: list[tuple[str | None, str | None]]
    aliases: list[Xml.Element] = field(default_factory=list)

    @property
    def real(self) -> bool:
        return self.type in FLOATS


@dataclass
class Unknown:
    """An entry of the model structure; variable is None where the entry names none. dependencies are variables, None
    where the attribute is absent."""

    where: str
    number: str
    variable: Variable | None
    dependencies: list[str] | None
    kinds: list[str] | None


LISTS = {"2": {"Outputs": "Outputs/Unknown", "Derivatives": "Derivatives/Unknown",
               "InitialUnknowns": "InitialUnknowns/Unknown"},
         "3": {"Output": "Output", "ContinuousStateDerivative": "ContinuousStateDerivative",
               "ClockedState": "ClockedState", "InitialUnknown": "InitialUnknown",
               "EventIndicator": "EventIndicator"}}  # fmt: skip


class Model:
    """The model of a description's root element."""

    def __init__(self, root: Xml.Element):
        self.root = root
        self.version = (root.get("fmiVersion") or "")[:1]
        self.token = root.get("guid" if self.version == "2" else "instantiationToken")
        elements = root.findall("ModelVariables/ScalarVariable" if self.version == "2" else "ModelVariables/*")
        self.variables = [self._variable(element) for element in elements]

    # Variables ---------------------------------------------------------------------------------------------

    @cached_property
    def types(self) -> dict[str | None, Xml.Element]:
        """The declared types by name: the element with the attributes."""
        found = self.root.findall("TypeDefinitions/*")
        return {t.get("name"): (t if self.version == "3" else next(iter(t), t)) for t in found}

    def _variable(self, element: Xml.Element) -> Variable:
        typed = (
            element
            if self.version == "3"
            else next((child for child in element if child.tag != "Annotations"), element)
        )
        declared = self.types.get(typed.get("declaredType"))

        def get(name: str) -> str | None:
            own = typed.get(name)
            return own if own is not None or declared is None else declared.get(name)

        causality = element.get("causality") or "local"
        variability = element.get("variability") or _variability(causality, typed.tag)
        start = typed.get("start")
        if start is None and typed.find("Start") is not None:
            start = " ".join(str(child.get("value")) for child in typed.findall("Start"))
        return Variable(
            str(element.get("name")), typed.tag, whole(element.get("valueReference")), causality, variability,
            element.get("initial") or _initial(self.version, causality, variability, typed.tag), start, element, typed,
            get("unit"), number(get("min"), -math.inf), number(get("max"), math.inf), number(get("nominal"), 1.0),
            typed.get("derivative"), element.get("clocks"),
            [(d.get("start"), d.get("valueReference")) for d in element.findall("Dimension")], element.findall("Alias"),
        )  # fmt: skip

    @cached_property
    def by_reference(self) -> dict[int | None, Variable]:
        """In FMI 2, aliases share a reference: the first of them."""
        found: dict[int | None, Variable] = {}
        for variable in self.variables:
            found.setdefault(variable.reference, variable)
        return found

    def find(self, text: str | None) -> Variable | None:
        """The variable of an index (FMI 2, from 1) or a value reference (FMI 3) in the model structure."""
        given = whole(text)
        if self.version == "3":
            return self.by_reference.get(given) if given is not None else None
        return self.variables[given - 1] if given is not None and 1 <= given <= len(self.variables) else None

    def size(self, variable: Variable) -> int:
        """Elements of a variable with the start values of structural parameters; 1 for a scalar, 0 where unknown."""
        count = 1
        for start, reference in variable.dimensions:
            source = start if start is not None else getattr(self.find(reference), "start", None)
            count *= whole(source) or 0
        return count if count <= LARGEST_ARRAY else 0

    # Structure ---------------------------------------------------------------------------------------------

    @cached_property
    def unknowns(self) -> dict[str, list[Unknown]]:
        """The entries of the lists of the model structure, by the list's name."""
        attribute = "index" if self.version == "2" else "valueReference"
        return {
            name: [
                Unknown(name, str(e.get(attribute)), self.find(e.get(attribute)), _words(e, "dependencies"),
                        _words(e, "dependenciesKind"))
                for e in self.root.iterfind(f"ModelStructure/{path}")
            ]
            for name, path in LISTS.get(self.version, {}).items()
        }  # fmt: skip

    def entries(self, two: str, three: str) -> list[Unknown]:
        return self.unknowns.get(two if self.version == "2" else three, [])

    @property
    def outputs(self) -> list[Unknown]:
        return self.entries("Outputs", "Output")

    @property
    def derivatives(self) -> list[Unknown]:
        return self.entries("Derivatives", "ContinuousStateDerivative")

    @property
    def initial_unknowns(self) -> list[Unknown]:
        return self.entries("InitialUnknowns", "InitialUnknown")

    @cached_property
    def states(self) -> list[Variable]:
        """The state of each derivative, where the description names one."""
        found = [self.find(u.variable.derivative) for u in self.derivatives if u.variable is not None]
        return [state for state in found if state is not None]

    @property
    def event_indicators(self) -> int:
        """Their number, with the start values of structural parameters."""
        if self.version == "2":
            return whole(self.root.get("numberOfEventIndicators")) or 0
        return sum(self.size(u.variable) for u in self.unknowns["EventIndicator"] if u.variable is not None)

    # Interfaces and experiment -----------------------------------------------------------------------------

    @property
    def kinds(self) -> list[str]:
        return [kind for kind in KINDS if self.root.find(kind) is not None]

    def flag(self, kind: str, two: str, three: str) -> bool:
        """A capability flag of a kind, from its name in each version; False where a version has none."""
        element, name = self.root.find(kind), two if self.version == "2" else three
        return element is not None and bool(name) and element.get(name) in ("true", "1")

    def experiment(self, name: str) -> float:
        """startTime, stopTime, tolerance or stepSize of the default experiment; NaN where absent."""
        element = self.root.find("DefaultExperiment")
        return math.nan if element is None else number(element.get(name), math.nan)


def number(text: str | None, otherwise: float) -> float:
    """A number of a description; otherwise where absent, NaN where it is none."""
    try:
        return otherwise if text is None else float(text)
    except ValueError:
        return math.nan


def whole(text: str | None) -> int | None:
    """A whole number of a description; None where absent or none."""
    try:
        return None if text is None else int(text)
    except ValueError:
        return None


def _words(element: Xml.Element, attribute: str) -> list[str] | None:
    text = element.get(attribute)
    return None if text is None else text.split()


def _variability(causality: str, type_name: str) -> str:
    """The default variability. In FMI 2 a parameter's default is `continuous`, which the standard forbids."""
    if type_name == "Real":
        return "continuous"
    if causality in ("parameter", "calculatedParameter", "structuralParameter"):
        return "fixed"
    return "continuous" if type_name in FLOATS else "discrete"


def _initial(version: str, causality: str, variability: str, type_name: str) -> str | None:
    """The default of `initial`; None where a variable has none (FMI 2.0.4, 2.2.7; FMI 3.0, table 22)."""
    if causality == "independent" or type_name == "Clock":
        return None
    if causality == "input":
        return None if version == "2" else "exact"
    if causality in ("parameter", "structuralParameter") or variability == "constant":
        return "exact"
    return "calculated"
