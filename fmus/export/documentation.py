"""documentation/index.html of an FMU: what the component is, its equations, variables, values and their source.

One file without scripts or references to others; equations are MathML.
"""

import inspect
from collections.abc import Iterable, Sequence
from html import escape
from math import isinf

import sympy

from fmus.composition.system import System
from fmus.effects import Effect
from fmus.effects.added_terms import added_terms
from fmus.export import mathml
from fmus.export.component_page import LONG, ROLES, read
from fmus.export.interface import FmuVariable, Interface
from fmus.expressions.expression_graph import Term

STYLE = ("body{font:15px/1.5 sans-serif;max-width:60em;margin:2em auto;padding:0 1em;color-scheme:light dark}"
         "table{border-collapse:collapse;display:block;overflow-x:auto}td,th{padding:.15em .7em;text-align:left;"
         "border-bottom:1px solid #8886}td.n{text-align:right}math{display:block;margin:.5em 0}pre{white-space:pre-wrap}")  # fmt: skip


def index(interface: Interface) -> bytes:
    """The page, UTF-8, the same for the same component."""
    component = interface.component
    about = inspect.getdoc(type(component)) or component.title
    parts = [f"<h1>{escape(component.name)}</h1>", f"<p>{escape(component.title)}</p>", f"<pre>{escape(about)}</pre>"]
    if component.source:
        parts.append(f"<p>Values: {escape(component.source)}</p>")
    parts += [f"<p>Assumed: {escape(name)} ({escape(reason)})</p>" for name, reason in component.assumed.items()]
    parts += ["<h2>Step</h2>", f"<p>{_step(interface)}</p>", "<h2>Equations</h2>", *_equations(interface)]
    parts.append("<h2>Variables</h2><p>All values are in SI units; inputs, outputs and states by their names.</p>")
    for role, heading in ROLES.items():
        rows = interface.of(role)
        if rows:
            parts += [f"<h3>{escape(heading)}</h3>", _table(rows)]
    parts.append("<p>Licence: BSD-3-Clause, see sources/LICENSE.txt.</p>")
    title = escape(component.name)
    head = ('<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">'
            f"<title>{title}</title><style>{STYLE}</style></head>")  # fmt: skip
    return (head + "<body>" + "\n".join(parts) + "</body></html>\n").encode()


def _step(interface: Interface) -> str:
    if not interface.component.states:
        return "There are no states: outputs follow from the inputs."
    if interface.exact:
        held = f" while {escape(', '.join(interface.held))} is constant" if interface.held else ""
        return f"The equations are linear{held}: a step is exact, with inputs as polynomials in time up to order 3."
    return ("A step is made by a Rosenbrock method with error control; its relative tolerance is the parameter "
            "relative_tolerance.")  # fmt: skip


def _equations(interface: Interface) -> list[str]:
    """The steps, balances and outputs as they are written; of a system the names of its parts."""
    component = interface.component
    if isinstance(component, System):
        return [f"<p>A system of {escape(', '.join(f'{n} ({c.title})' for n, c in component.parts.items()))}.</p>"]
    reading = read(component)
    every = [*reading.definitions.values(), *reading.results.values(), *reading.mass.values()]
    if any(e.atoms(Term) or e.count_ops() > LONG for e in every):
        return ["<p>They are too long to be read one by one; how they are derived is said above.</p>"]
    latex = {n: row.latex for n, row in component.table.items()} | {"time": "t"}
    heavy = {n for entry in reading.mass for n in entry}
    lines = [_equation(mathml.symbol_markup(latex[n]), e, latex) for n, e in reading.definitions.items()]
    # the other states are those of effects
    for name in (n for n in component.states if f"der({n})" in reading.results):
        left = mathml.symbol_markup(latex[name])
        left = f"<msub><mi>f</mi>{left}</msub>" if name in heavy else f"<mover>{left}<mo>&#x2d9;</mo></mover>"
        lines.append(_equation(left, reading.results[f"der({name})"], latex))
    for (row, column), entry in reading.mass.items():
        at = mathml.symbol_markup(latex[row]) + mathml.symbol_markup(latex[column])
        lines.append(_equation(f"<msub><mi>M</mi><mrow>{at}</mrow></msub>", entry, latex))
    results = [n for n in (*component.rows("output"), *component.rows("calculated")) if n in reading.results]
    lines += [_equation(mathml.symbol_markup(latex[n]), reading.results[n], latex) for n in results]
    note = ["<p>M x&#x2d9; = f, with the entries of M that are listed.</p>"] if heavy else []
    return [*lines, *note, *(_effect(effect) for effect in component.effects)]


def _effect(effect: Effect) -> str:
    """What an effect is, and the terms that it adds where they are short."""
    added = "".join(f"<br><code>{escape(equation)}</code>" for equation in added_terms(type(effect)))
    return f"<p>Effect {escape(type(effect).__name__)}: {escape(effect.sentence())}{added}</p>"


def _equation(left: str, right: sympy.Expr, latex: dict[str, str]) -> str:
    return f"<math><mrow>{left}<mo>=</mo>{mathml.markup(right, latex)}</mrow></math>"


def _table(rows: Sequence[FmuVariable]) -> str:
    body = "".join(f"<tr>{''.join(_cells(v))}</tr>" for v in rows)
    headings = "".join(f"<th>{h}</th>" for h in ("name", "symbol", "unit", "start", "min", "max", "meaning"))
    return f"<table><tr>{headings}</tr>{body}</table>"


def _cells(variable: FmuVariable) -> Iterable[str]:
    row = variable.row
    given = variable.role in ("parameter", "input", "state")
    numbers = ["" if isinf(x) or not given else f"{x:.6g}" for x in (variable.start, row.min, row.max)]
    yield f"<td>{escape(variable.name)}</td><td><math>{mathml.symbol_markup(row.latex)}</math></td>"
    yield f"<td>{escape(row.unit)}</td>"
    yield from (f'<td class="n">{x}</td>' for x in numbers)
    yield f"<td>{escape(row.description)}</td>"
