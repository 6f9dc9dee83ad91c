"""A page about a component, rendered from its one declaration: equations in LaTeX, variables, values and their source.

The equations are read with every local variable as a symbol of its own, so that they come out in the steps in
which they are written, and not as one expanded expression.
"""

import inspect
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import isinf
from typing import Any

import sympy

from fmus.declaration.component import Component, Scope
from fmus.declaration.variables import Variable
from fmus.expressions.expression_graph import Term
from fmus.expressions.symbolic_functions import SYMBOLIC

ROLES = {"parameter": "Parameters", "calculated": "Calculated parameters", "input": "Inputs", "state": "States",
         "output": "Outputs", "local": "Named points of the equations, to which effects can add"}  # fmt: skip
LONG = 400  # operations in one equation; a longer one is left out


class _Reading(Scope):
    """Records the expressions of local variables and replaces them by symbols where they are read."""

    def __init__(self, values: Mapping[str, Any], component: Component, definitions: dict[str, sympy.Expr]):
        self.__dict__["_definitions"] = definitions
        super().__init__(values, component, SYMBOLIC)

    def __setattr__(self, name: str, value: Any) -> None:
        super().__setattr__(name, value)
        self._definitions[name] = sympy.sympify(self[name])
        self.__dict__[name] = sympy.Symbol(name, real=True)


@dataclass(frozen=True)
class Reading:
    """A component's equations in the steps in which they are written.

    definitions by local variable, in order; results by output, calculated parameter and `der(state)` (before
    the mass matrix); mass by (row, column) state. Symbols carry the names of the table.
    """

    definitions: dict[str, sympy.Expr]
    results: dict[str, sympy.Expr]
    mass: dict[tuple[str, str], sympy.Expr]


def read(component: Component) -> Reading:
    """The equations of a component as they are written."""
    names = ["time", *component.rows("parameter", "input", "state")]
    values = {n: sympy.Symbol(n, real=True) for n in names}
    definitions: dict[str, sympy.Expr] = {}
    results = component.equations(_Reading(values, component, definitions), SYMBOLIC)
    mass = component.mass(_Reading(values, component, definitions), SYMBOLIC)
    return Reading(
        definitions, {k: sympy.sympify(x) for k, x in results.items()}, {k: sympy.sympify(x) for k, x in mass.items()}
    )


def page(kind: type[Component], shipped: Sequence[Component] = ()) -> str:
    """The page of a component as Markdown, with the values that ship for it."""
    component = kind()
    module = inspect.cleandoc(inspect.getmodule(kind).__doc__ or "")  # type: ignore[union-attr]
    parts = [
        f"# {component.title}",
        inspect.getdoc(kind) or "",
        f"```text\n{module}\n```",
        "## Equations",
        *_equations(component),
        "## Variables",
    ]
    for role, heading in ROLES.items():
        rows = component.rows(role)
        if rows:
            parts += [
                f"### {heading}",
                _table(["name", "symbol", "unit", "start", "min", "max", "meaning"], map(_row, rows.values())),
            ]
    if shipped:
        parts += ["## Values that ship", *_values(component, shipped)]
    return "\n\n".join(parts) + "\n"


def _row(row: Variable) -> list[str]:
    numbers = ["" if isinf(x) else f"{x:g}" for x in (row.start, row.min, row.max)]
    if row.role in ("output", "calculated", "local"):
        numbers = ["", "", ""]
    return [
        f"`{row.name}`",
        f"${row.latex}$",
        row.unit,
        *numbers,
        row.description + (" (also an output)" if row.exposed else ""),
    ]


def _table(heading: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = ["| " + " | ".join(cells) + " |" for cells in [heading, ["---"] * len(heading), *rows]]
    return "\n".join(lines)


def _values(component: Component, shipped: Sequence[Component]) -> list[str]:
    """A table of values, parameters down or across, whichever is fewer columns, and the sources."""
    rows = component.rows("parameter")
    cells = [[f"{c.values[n]:.6g}" + ("*" if n in c.assumed else "") for n in rows] for c in shipped]
    labels = [f"${row.latex}$ [{row.unit}]" for row in rows.values()]
    if len(shipped) <= len(rows):
        table = _table(
            ["", *(c.name for c in shipped)],
            ([label, *column] for label, column in zip(labels, zip(*cells, strict=True), strict=True)),
        )
    else:
        table = _table(["", *labels], ([c.name, *line] for c, line in zip(shipped, cells, strict=True)))
    notes = [f"* {c.name}: {c.source}" for c in shipped]
    notes += [f"* {c.name}, `{n}` is assumed (*): {reason}" for c in shipped for n, reason in c.assumed.items()]
    return [table, "\n".join(notes)]


# Equations ----------------------------------------------------------------------------------------


def _equations(component: Component) -> list[str]:
    """The steps, the balances M x' = f with the entries of M, and the outputs; each a block of aligned equations."""
    reading = read(component)
    if any(
        e.atoms(Term) or e.count_ops() > LONG
        for e in [*reading.definitions.values(), *reading.results.values(), *reading.mass.values()]
    ):
        return ["They are too long to be read one by one; how they are derived is said above."]
    symbols = {sympy.Symbol(n, real=True): row.latex for n, row in component.table.items()} | {
        sympy.Symbol("time", real=True): "t"
    }

    def block(equations: Iterable[tuple[str, sympy.Expr]]) -> str:
        lines = (
            f"{left} &= {sympy.latex(right if right != 0 else 0, symbol_names=symbols)}" for left, right in equations
        )
        return "```math\n\\begin{aligned}\n" + " \\\\\n".join(lines) + "\n\\end{aligned}\n```"

    latex = {n: row.latex for n, row in component.table.items()}
    blocks = [block((latex[n], e) for n, e in reading.definitions.items())] if reading.definitions else []
    heavy = [n for n in component.states if any(n in entry for entry in reading.mass)]
    if component.states:
        blocks.append(
            block(
                (f"f_{{{latex[n]}}}" if n in heavy else rf"\dot{{{latex[n]}}}", reading.results[f"der({n})"])
                for n in component.states
            )
        )
    if heavy:
        vector = ", ".join(latex[n] for n in heavy)
        symmetric = all(reading.mass.get((k, i)) == e for (i, k), e in reading.mass.items())
        blocks.append(
            f"where $M \\dot x = f$ for $x = ({vector})$, with the entries of {'the symmetric ' * symmetric}$M$"
        )
        blocks.append(block((f"M_{{{latex[i]},{latex[k]}}}", e) for (i, k), e in reading.mass.items()
                            if not symmetric or component.states.index(i) <= component.states.index(k)))  # fmt: skip
    results = [*component.rows("output"), *component.rows("calculated")]
    if results:
        blocks.append(block((latex[n], reading.results[n]) for n in results))
    return blocks
