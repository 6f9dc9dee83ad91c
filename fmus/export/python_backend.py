"""The python back end: a component as a slave of pythonfmu, generated from its equations, for users who edit the slave.

The archive contains one readable Python file. The importer needs Python with numpy and scipy. The archive offers no
model exchange, no input or output derivatives and no directional derivatives, as its model description states. Names,
values and trajectories are those of the compiled back end.
"""

import hashlib
import keyword
import subprocess
import sys
import tempfile
import uuid
import zipfile
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path

import jinja2
import sympy
from sympy.printing.pycode import PythonCodePrinter

from fmus.export import accompanying
from fmus.export.interface import TOLERANCE, Interface
from fmus.export.model_description2 import Capabilities, causality, model_description
from fmus.expressions.expression_graph import common_subexpressions

PLATFORMS = ("linux-x86_64", "windows-x86_64")  # for which pythonfmu has a library
CAPABILITIES = Capabilities(exchange=False, cosimulation=(
    ("needsExecutionTool", "true"),
    ("canHandleVariableCommunicationStepSize", "true"),
    ("canNotUseMemoryManagementFunctions", "true"),
    ("canGetAndSetFMUstate", "true"),
    ("canSerializeFMUstate", "true"),
))  # fmt: skip


class Printer(PythonCodePrinter):
    """SymPy to Python on plain numbers."""

    def _print_sign(self, expr):
        return f"sign({self._print(expr.args[0])})"

    def _print_Heaviside(self, expr):
        return f"heaviside({self._print(expr.args[0])})"

    def _print_Quantised(self, expr):
        x, step = map(self._print, expr.args)
        return f"quantised({x}, {step})"


def slave_code(interface: Interface) -> str:
    """The source of the slave."""
    form, component = interface.form, interface.component
    wide = form.jacobian
    n, m = len(component.states), len(component.inputs)
    environment = jinja2.Environment(
        keep_trailing_newline=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    template = environment.from_string(files("fmus.export").joinpath("python_slave.py.in").read_text("utf-8"))
    names = {symbol: python_name(name) for name, symbol in form.symbols.items()}
    names.update({symbol: f"rates[{i}]" for i, symbol in enumerate(form.derivative_symbols)})
    entries = [(i, j) for i in range(n) for j in range(n + m) if wide[i, j] != 0]
    mass_entries = [(i, j) for i in range(n) for j in range(n) if form.mass[i, j] != 0]
    return template.render(
        title=component.title,
        source=component.source,
        identifier=f"{interface.identifier}_python",
        variables=[(v, causality(interface, v)) for v in interface.variables],
        unpacked=", ".join(
            python_name(v.name)
            for v in interface.variables
            if v.role in ("time", "parameter", "calculated", "input", "state")
        ),
        n_unpacked=sum(v.role not in ("output", "derivative") for v in interface.variables),
        first={role: interface.first(role) for role in ("calculated", "input", "state", "output", "derivative")},
        n={"calculated": len(form.calculated), "inputs": m, "states": n, "outputs": len(interface.of("output"))},
        held=[int(name in interface.held) for name in component.inputs],
        exact=interface.exact,
        has_mass=form.has_mass,
        tolerance=interface.references.get(TOLERANCE.name),
        calculated=body(names, form.calculated),
        rates=body(names, form.rates),
        mass=body(names, [form.mass[i, j] for i, j in mass_entries], mass_entries),
        outputs=body(names, [form.outputs[component.outputs.index(v.name)] for v in interface.of("output")]),
        jacobian=body(names, [wide[i, j] for i, j in entries], entries),
    )


def body(
    names: dict[sympy.Symbol, str], expressions: Sequence[sympy.Expr], places: Sequence[tuple[int, int]] = ()
) -> list[str]:
    """The lines of a function: common subexpressions, then a list of results, or the entries of
    `matrix` at the places."""
    printer = Printer({"fully_qualified_modules": True})
    printer._print_Symbol = lambda symbol: names.get(symbol, symbol.name)
    common, reduced = common_subexpressions(expressions)
    lines = [f"{symbol} = {printer.doprint(expression)}" for symbol, expression in common]
    if places:
        return lines + [f"matrix[{i}, {j}] = {printer.doprint(e)}" for (i, j), e in zip(places, reduced, strict=True)]
    return [*lines, "return [", *(f"    {printer.doprint(e)}," for e in reduced), "]"]


def python_name(name: str) -> str:
    """A Python name for a variable."""
    plain = name.replace(".", "_")
    return f"{plain}_" if keyword.iskeyword(plain) or plain in ("matrix", "rates", "math", "z") else plain


def sources(interface: Interface) -> dict[str, bytes]:
    """The slave and the model description. The module's name and the GUID follow from the content."""
    code = slave_code(interface).encode()
    identifier = f"{interface.identifier}_python"
    digest = hashlib.sha256(code + model_description(interface, identifier, "", CAPABILITIES)).hexdigest()
    guid = f"{{{uuid.UUID(digest[:32])}}}"
    return {
        f"resources/{interface.identifier}_{digest[:12]}.py": code,
        "modelDescription.xml": model_description(interface, identifier, guid, CAPABILITIES),
        **accompanying.files(interface, fmi=2, interpolates=False),
    }


def packed(made: Mapping[str, bytes]) -> dict[str, bytes]:
    """All files of the archive: pythonfmu adds its library and itself. Raises RuntimeError when it cannot."""
    path, code = next((Path(name), data) for name, data in made.items() if name.endswith(".py"))
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, path.name).write_bytes(code)
        # In a process of its own, because pythonfmu imports the slave and leaves it and its folder on the path.
        command = [sys.executable, "-m", "pythonfmu", "build", "-f", str(Path(folder, path.name)), "-d", folder]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        built = next(Path(folder).glob("*.fmu"), None)
        if done.returncode or built is None:
            raise RuntimeError(f"pythonfmu cannot build {path.name}: {(done.stderr or done.stdout).strip()[-300:]}")
        with zipfile.ZipFile(built) as archive:
            files_of_tool = {name: archive.read(name) for name in archive.namelist() if not name.endswith("/")}
    return {**files_of_tool, **made}
