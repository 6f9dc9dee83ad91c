"""The interface of fmi-ls-wasm, the draft of a layered standard for FMI 3.0 in WebAssembly.

Each line is a function of the WIT package `fmi:fmi3@3.0.0` with the types of the WebAssembly Component Model. The
resource of each kind of FMU has the functions of every kind and its own. Source: github.com/modelica/fmi-ls-wasm,
wit/*.wit and docs/index.adoc, version 0.1.0 of July 2026.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass

PLATFORM = "wasm32-wasip2"  # the folder in an archive that the draft asks for
MANIFEST = "extra/org.modelica.fmi-ls-wasm/manifest.xml"
MANIFEST_ATTRIBUTES = {
    "xmlns:fmi-ls": "http://fmi-standard.org/fmi-ls-manifest",
    "fmi-ls:fmi-ls-name": "org.modelica.fmi-ls-wasm",
    "fmi-ls:fmi-ls-version": "0.1.0",
    "fmi-ls:fmi-ls-description": "FMI Layered Standard for WebAssembly",
}
COMMON = "fmi:fmi3/common@3.0.0"
VERSION = "get-version() -> string"

# Named types in the order of their definitions: an enum lists its cases, a record its fields, an alias is one type.
TYPES = {
    "value-reference": "u32",
    "status": "enum ok, warning, discard, error, fatal",
    "fmu-state": "list<u8>",
    "interval-qualifier": "enum interval-not-yet-known, interval-unchanged, interval-changed",
    "dependency-kind": "enum dependent, constant, fixed, tunable, discrete",
    "interval-fraction": "record counter: u64, resolution: u64",
    "variable-dependency":
        "record dependent-value-reference: value-reference, element-index-of-dependent: u32, "
        "independent-value-reference: value-reference, element-index-of-independent: u32, kind: dependency-kind",
    "discrete-states-info":
        "record new-discrete-states-needed: bool, terminate-simulation: bool, "
        "nominals-of-continuous-states-changed: bool, values-of-continuous-states-changed: bool, "
        "next-event-time-defined: bool, next-event-time: f64",
}  # fmt: skip

SCALARS = {
    "float32": "f32", "float64": "f64", "int8": "s8", "int16": "s16", "int32": "s32", "int64": "s64", "uint8": "u8",
    "uint16": "u16", "uint32": "u32", "uint64": "u64", "boolean": "bool", "string": "string", "binary": "list<u8>",
    "clock": "bool",
}  # fmt: skip

EVERY_KIND = """
set-debug-logging(logging-on: bool, categories: list<string>) -> status
enter-initialization-mode(tolerance: option<f64>, start-time: f64, stop-time: option<f64>) -> status
exit-initialization-mode() -> status
enter-event-mode() -> status
update-discrete-states() -> result<discrete-states-info, status>
terminate() -> status
reset() -> status
enter-configuration-mode() -> status
exit-configuration-mode() -> status
get-number-of-variable-dependencies(vr: value-reference) -> result<u64, status>
get-variable-dependencies(dependent: value-reference) -> result<list<variable-dependency>, status>
get-fmu-state() -> result<fmu-state, status>
set-fmu-state(state: fmu-state) -> status
get-directional-derivative(unknowns: list<value-reference>, knowns: list<value-reference>, seed: list<f64>) -> result<list<f64>, status>
get-adjoint-derivative(unknowns: list<value-reference>, knowns: list<value-reference>, seed: list<f64>) -> result<list<f64>, status>
get-interval-decimal(value-references: list<value-reference>) -> result<list<tuple<f64, interval-qualifier>>, status>
get-interval-fraction(value-references: list<value-reference>) -> result<list<tuple<interval-fraction, interval-qualifier>>, status>
get-shift-decimal(value-references: list<value-reference>) -> result<list<f64>, status>
get-shift-fraction(value-references: list<value-reference>) -> result<list<interval-fraction>, status>
set-interval-decimal(value-references: list<value-reference>, intervals: list<f64>) -> status
set-interval-fraction(value-references: list<value-reference>, intervals: list<interval-fraction>) -> status
set-shift-decimal(value-references: list<value-reference>, shifts: list<f64>) -> status
set-shift-fraction(value-references: list<value-reference>, shifts: list<interval-fraction>) -> status
evaluate-discrete-states() -> status
enter-step-mode() -> status
""" + "".join(
    f"get-{name}(value-references: list<value-reference>) -> result<list<{kind}>, status>\n"
    f"set-{name}(value-references: list<value-reference>, values: list<{kind}>) -> status\n"
    for name, kind in SCALARS.items()
)


@dataclass(frozen=True)
class Function:
    """A function of the interface: its name, parameters with types, and the type of its result."""

    name: str
    parameters: tuple[tuple[str, str], ...]
    result: str

    @property
    def symbol(self) -> str:
        """The function in `runtime/fmi3_component.c`."""
        return "component_" + self.name.replace("-", "_")


@dataclass(frozen=True)
class Kind:
    """A kind of FMU: the name of its interface, a named type of its own, and the functions that it alone has."""

    name: str
    own_type: tuple[str, str]
    create: str
    functions: str

    @property
    def interface(self) -> str:
        return f"fmi:fmi3/{self.name}@3.0.0"

    @property
    def resource(self) -> str:
        return f"{self.name}-instance"


KINDS = (
    Kind(
        "model-exchange",
        ("completed-step-result", "record enter-event-mode: bool, terminate-simulation: bool"),
        "instantiate-model-exchange(instance-name: string, instantiation-token: string, resource-path: string, "
        "visible: bool, logging-on: bool) -> option<model-exchange-instance>",
        """
enter-continuous-time-mode() -> status
set-time(time: f64) -> status
set-continuous-states(continuous-states: list<f64>) -> status
get-continuous-state-derivatives() -> result<list<f64>, status>
get-event-indicators() -> result<list<f64>, status>
get-continuous-states() -> result<list<f64>, status>
get-nominals-of-continuous-states() -> result<list<f64>, status>
get-number-of-event-indicators() -> result<u64, status>
get-number-of-continuous-states() -> result<u64, status>
completed-integrator-step(no-set-fmu-state-prior-to-current-point: bool) -> result<completed-step-result, status>
""",
    ),
    Kind(
        "co-simulation",
        ("do-step-result",
         "record last-successful-time: f64, event-handling-needed: bool, terminate-simulation: bool, "
         "early-return: bool"),
        "instantiate-co-simulation(instance-name: string, instantiation-token: string, resource-path: string, "
        "visible: bool, logging-on: bool, event-mode-used: bool, early-return-allowed: bool, "
        "required-intermediate-variables: list<value-reference>) -> option<co-simulation-instance>",
        """
set-input-derivatives(requests: list<tuple<value-reference, u32>>, values: list<f64>) -> status
get-output-derivatives(requests: list<tuple<value-reference, u32>>) -> result<list<f64>, status>
do-step(current-communication-point: f64, communication-step-size: f64, no-set-fmu-state-prior-to-current-point: bool) -> result<do-step-result, status>
""",
    ),
)  # fmt: skip


def functions(lines: str) -> Iterator[Function]:
    """The functions that the lines declare."""
    for line in filter(None, lines.splitlines()):
        name, parameters, result = re.fullmatch(r"([\w-]+)\((.*)\) -> (.+)", line).groups()  # type: ignore[union-attr]
        yield Function(name, tuple(fields(parameters)), result)


def fields(text: str) -> Iterator[tuple[str, str]]:
    """The names and types of `name: type, name: type`."""
    for part in split(text):
        name, _, kind = part.partition(": ")
        yield name, kind


def split(text: str) -> list[str]:
    """The parts between the commas that are in no bracket."""
    parts, depth = [""], 0
    for letter in text:
        depth += (letter == "<") - (letter == ">")
        if letter == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return [part.strip() for part in parts if part.strip()]
