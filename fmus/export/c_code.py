"""C99 of a component's equations, and the table of its variables, which the shared runtime (fmus/export/runtime) reads.

    M(z) x' = f(z),   y = g(z),   d(f - M x', g) / d(x, u, t)

`z` is the vector of all values in the order of the references (see `fmus.export.interface`); behind them come numbers
that depend on the parameters alone, so that no step computes the cosine of a caster angle, and behind those the terms
(see `fmus.expressions.expression_graph`) that the rates share with the outputs or the Jacobian. Common subexpressions
are computed once for each function. The mass matrix is solved in the runtime.
"""

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from importlib.resources import files
from itertools import count
from math import inf
from typing import Any

import jinja2
import sympy
from sympy.printing.c import C99CodePrinter

from fmus.export.interface import TOLERANCE, Interface
from fmus.expressions.expression_graph import Each, Term, common_subexpressions, plain_symbol, terms_in

ROLES = {
    "time": "TIME",
    "calculated": "CALCULATED",
    "input": "INPUT",
    "state": "STATE",
    "output": "OUTPUT",
    "derivative": "DERIVATIVE",
}


CONSTANT = "constant "  # a name that no variable has
UNNAMED = (CONSTANT, "term_")  # read in place; variables of the table get a C name
OF_EACH = " + k]"  # at the end of a place that depends on the value in a loop


class Printer(C99CodePrinter):
    """SymPy to C. Small powers are products, of roots too; the slopes of switches have a value everywhere."""

    def _print_Pow(self, expr):
        half = expr.exp.is_Rational and expr.exp.q == 2
        if (expr.exp.is_Integer and 2 <= abs(expr.exp) <= 4) or (half and abs(expr.exp) in (1.5, 2.5)):
            base = self.parenthesize(expr.base, 100)
            factors = [base] * int(abs(expr.exp)) + [f"sqrt({self._print(expr.base)})"] * half
            product = "*".join(factors)
            return f"({product})" if expr.exp > 0 else f"(1.0/({product}))"
        return super()._print_Pow(expr)

    def _print_NumberSymbol(self, expr):
        return literal(float(expr))

    _print_Pi = _print_Exp1 = _print_NumberSymbol  # strict C99 has no M_PI

    def _print_sign(self, expr):
        return f"sign({self._print(expr.args[0])})"

    def _print_Heaviside(self, expr):
        return f"heaviside({self._print(expr.args[0])})"


def model_code(interface: Interface) -> str:
    """The generated file `model.c` of an FMU: the equations, the same for all values of the parameters."""
    return _rendered("model.c", _equations(interface))


def variables_code(interface: Interface, guid: str) -> str:
    """The generated file `variables.c` of an FMU: names, units, start values and bounds."""
    rows = [_row(v) for v in interface.variables]
    return _rendered("variables.c", {"title": interface.component.title, "guid": guid, "variables": rows})


def _rendered(file: str, context: Mapping[str, Any]) -> str:
    template = jinja2.Environment(keep_trailing_newline=True, undefined=jinja2.StrictUndefined)
    source = files("fmus.export").joinpath("runtime", f"{file}.in").read_text("utf-8")
    return template.from_string(source).render(context)


def _equations(interface: Interface) -> dict[str, Any]:
    form, component = interface.form, interface.component
    nx, nu = len(component.states), len(component.inputs)
    constants = Constants(interface)
    wide = form.slopes((*component.states, *component.inputs, "time"))
    functions = {
        "rates": [(f"f[{i}]", constants.hoist(e)) for i, e in enumerate(form.rates)],
        "mass": [(f"m[{i * nx + j}]", constants.hoist(form.mass[i, j])) for i in range(nx)
                 for j in range(nx) if form.mass[i, j] != 0],
        "outputs": [(f"z[{v.reference}]", constants.hoist(form.outputs[component.outputs.index(v.name)]))
                    for v in interface.of("output")],
        "jacobian": [(f"j[{i * wide.cols + k}]", constants.hoist(wide[i, k]))
                     for i in range(wide.rows) for k in range(wide.cols) if wide[i, k] != 0],
    }  # fmt: skip
    calculated = [(f"z[{v.reference}]", e) for v, e in zip(interface.of("calculated"), form.calculated, strict=True)]
    shared = shared_terms(functions)
    given = {plain_symbol(t): t for t in sorted(met(functions.values(), shared), key=shared.index)}
    hoisted = {symbol: e for e, symbol in constants.symbols.items()}
    of_constants, first_term = laid_out(hoisted, len(interface.variables))
    of_terms, end = laid_out(given, first_term)
    places = {**variable_places(interface), **of_constants, **of_terms}
    return {
        "output_references": [interface.reference(n) for n in component.outputs],
        "held": [int(n in interface.held) for n in component.inputs],
        "has_held": int(bool(interface.held)),
        "first": {role: interface.first(role) for role in ("input", "state", "output", "derivative")},
        "n": {
            "variables": len(interface.variables),
            "values": first_term,
            "terms": end - first_term,
            "inputs": nu,
            "states": nx,
        },
        "output_order": interface.output_order,
        "exact": int(interface.exact),
        "has_mass": int(form.has_mass),
        "tolerance": interface.references[TOLERANCE.name] if interface.has_tolerance else 0,
        "parameters": statements([*calculated, *((places[symbol], e) for symbol, e in hoisted.items())], places),
        "terms": statements([(places[symbol], t) for symbol, t in given.items()], places),
        **{name: statements(assigned, places, set(shared)) for name, assigned in functions.items()},
    }


Assignments = Sequence[tuple[str, sympy.Expr]]


def shared_terms(functions: Mapping[str, Assignments]) -> list[Term]:
    """The terms that rates or mass matrix share with outputs or Jacobian, each after those in its definition."""
    needed = {name: terms_in([e for _, e in assigned]) for name, assigned in functions.items()}
    elsewhere = {*needed["outputs"], *needed["jacobian"]}
    return [t for t in terms_in([e for name in ("rates", "mass") for _, e in functions[name]]) if t in elsewhere]


def met(functions: Iterable[Assignments], shared: Sequence[Term]) -> set[Term]:
    """Those shared terms that the functions mention themselves."""
    given = set(shared)
    found: set[Term] = set()
    for assigned in functions:
        expressions = [e for _, e in assigned]
        found.update(*(e.atoms(Term) for e in (*expressions, *(t.definition for t in terms_in(expressions, given)))))
    return found & given


class Constant(sympy.Symbol):
    """The symbol of what depends on the parameters alone, and inside a total on its value."""

    each: Each | None

    def __new__(cls, name: str, each: Each | None) -> "Constant":
        constant = sympy.Symbol.__xnew__(cls, name, real=True)
        constant.each = each
        return constant

    @property
    def free_symbols(self) -> set[sympy.Symbol]:
        return {self} if self.each is None else {self, self.each}


class Constants:
    """Subexpressions that depend on the parameters alone, each given a symbol."""

    def __init__(self, interface: Interface):
        self.parameters = {
            interface.form.symbols[v.name] for v in interface.of("parameter") if v.name in interface.form.symbols
        }
        self.symbols: dict[sympy.Expr, Constant] = {}
        self.terms: dict[Term, sympy.Expr] = {}

    def hoist(self, expression: sympy.Expr) -> sympy.Expr:
        """The expression with every part that depends on the parameters alone replaced by its symbol."""
        if expression.is_Atom and not isinstance(expression, Term):
            return expression
        if isinstance(expression, sympy.Expr) and self._alone(expression):
            return self.symbols.setdefault(expression, Constant(f"{CONSTANT}{len(self.symbols)}", each_of(expression)))
        if isinstance(expression, Term):
            if expression not in self.terms:
                self.terms[expression] = expression.like(self.hoist(expression.definition))
            return self.terms[expression]
        if expression.is_Add or expression.is_Mul:
            alone = [a for a in expression.args if not a.free_symbols or self._alone(a) or isinstance(a, Each)]
            if len(alone) > 1 and any(map(self._alone, alone)):
                rest = [a for a in expression.args if a not in alone]
                return expression.func(self.hoist(expression.func(*alone)), *map(self.hoist, rest))
        return expression.func(*map(self.hoist, expression.args))

    def _alone(self, expression: sympy.Expr) -> bool:
        free = {s for s in expression.free_symbols if not isinstance(s, Each)}
        return bool(free) and free <= self.parameters


def each_of(expression: sympy.Expr) -> Each | None:
    """The symbols that take the values of a total in this part of its summand."""
    return next((s for s in expression.free_symbols if isinstance(s, Each)), None)


def variable_places(interface: Interface) -> dict[sympy.Symbol, str]:
    """The place of every variable in the vector of values; x' of a state is in the array `rates`."""
    places = {symbol: f"z[{interface.reference(name)}]" for name, symbol in interface.form.symbols.items()}
    return {**places, **{symbol: f"rates[{i}]" for i, symbol in enumerate(interface.form.derivative_symbols)}}


def laid_out(definitions: Mapping[sympy.Symbol, sympy.Expr], place: int) -> tuple[dict[sympy.Symbol, str], int]:
    """Places in the vector of values from one on, in a loop over k as many as it has values; and
    the place behind them."""
    places = {}
    for symbol, definition in definitions.items():
        each = each_of(definition)
        places[symbol] = f"z[{place}]" if each is None else f"z[{place}{OF_EACH}"
        place += 1 if each is None else len(each.values)
    return places, place


def statements(assigned: Assignments, places: Mapping[sympy.Symbol, str], given: Collection[Term] = ()) -> list[str]:
    """The C statements of `target = expression`: the variables that they read, loops, common
    subexpressions, the targets.

    The given terms are read from their places.
    """
    if not assigned:
        return []
    text = Text(places)
    outside = [(target, e) for target, e in assigned if each_of(e) is None]
    totals = [t for t in terms_in([e for _, e in outside], given) if t.each is not None]
    loops = {each for each in (*(t.each for t in totals), *(each_of(e) for _, e in assigned)) if each is not None}
    for each in sorted(loops, key=str):
        text.loop(
            each,
            [t for t in totals if t.each == each],
            [(target, e) for target, e in assigned if each_of(e) == each],
            given,
        )
    common, reduced = common_subexpressions([e for _, e in outside], {*given, *totals})
    text.define(common)
    text.lines += [f"{target} = {text(e)};" for (target, _), e in zip(outside, reduced, strict=True)]
    return text.variables() + text.lines


class Text:
    """Lines of C, with names for what they have defined."""

    def __init__(self, places: Mapping[sympy.Symbol, str]):
        self.places = places
        self.names: dict[sympy.Symbol, str] = {}
        self.lines: list[str] = []
        self.read: set[sympy.Symbol] = set()
        self.numbers = count()
        self.printer = Printer({"contract": False, "math_macros": {}})
        self.printer._print_Symbol = self.name

    def __call__(self, expression: sympy.Expr) -> str:
        return self.printer.doprint(expression)

    def name(self, symbol: sympy.Symbol) -> str:
        if symbol in self.names:
            return self.names[symbol]
        if symbol.name.startswith(UNNAMED):
            return self.places[symbol]
        self.read.add(symbol)
        return c_name(symbol.name)

    def variables(self) -> list[str]:
        """The variables of the table that have been read."""
        return [
            f"const double {c_name(s.name)} = {self.places[s]};"
            for s in sorted(self.read, key=lambda s: _order(self.places[s]))
        ]

    def define(self, common: Sequence[tuple[sympy.Symbol, sympy.Expr]], indent: str = "") -> None:
        for symbol, expression in common:
            line, name = self(expression), f"t{next(self.numbers)}"
            self.names[symbol] = name
            self.lines.append(f"{indent}const double {name} = {line};")

    def loop(self, each: Each, totals: Sequence[Term], assigned: Assignments, given: Collection[Term]) -> None:
        """The sums of the totals, and what is assigned for each value; expressions that are the same for all
        values come before."""
        common, reduced = common_subexpressions([*(t.definition for t in totals), *(e for _, e in assigned)], given)
        varying: set[sympy.Symbol] = set()
        for symbol, expression in common:
            met = expression.atoms(sympy.Symbol)
            if each in met or met & varying or any(self.places.get(s, "").endswith(OF_EACH) for s in met):
                varying.add(symbol)
        self.define([pair for pair in common if pair[0] not in varying])
        sums = [f"sum{next(self.numbers)}" for _ in totals]
        self.lines += [f"double {name} = 0;" for name in sums]
        self.lines.append(f"for (unsigned k = 0; k < {len(each.values)}; k++) {{")
        self.names[each] = "each"
        self.lines.append(
            f"    const double each = (const double[]){{{', '.join(map(repr, map(float, each.values)))}}}[k];"
        )
        self.define([pair for pair in common if pair[0] in varying], "    ")
        self.lines += [f"    {name} += {self(e)};" for name, e in zip(sums, reduced, strict=False)]
        self.lines += [
            f"    {target} = {self(e)};" for (target, _), e in zip(assigned, reduced[len(totals) :], strict=True)
        ]
        self.lines += ["    (void)each;", "}"]
        self.names.update({plain_symbol(t): name for t, name in zip(totals, sums, strict=True)})


def c_name(name: str) -> str:
    """A C name for a variable; the letter in front keeps it away from the keywords of C."""
    return "v_" + re.sub(r"\W", "_", name.replace(".", "__"))


def literal(value: float) -> str:
    """A number in C with all its digits; an absent bound is the largest finite number, so that
    infinity is out of bounds."""
    if abs(value) == inf:
        return "DBL_MAX" if value > 0 else "-DBL_MAX"
    return repr(float(value))


def _order(place: str) -> tuple[str, int]:
    array, _, index = place.partition("[")
    return array, int(index[:-1])


def _row(variable) -> dict:
    role = ROLES.get(variable.role) or ("TUNABLE" if variable.row.tunable else "FIXED")
    bounded = variable.role in ("parameter", "input", "state")
    low, high = (variable.row.min, variable.row.max) if bounded else (-inf, inf)
    numbers: Iterable[float] = (variable.start, low, high, variable.nominal)
    return {"name": variable.name, "unit": variable.row.unit, "role": role, "numbers": ", ".join(map(literal, numbers))}
