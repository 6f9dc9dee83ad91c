"""C99 of a component's equations, and the tables that the shared runtime (fmus/runtime) reads.

    M(z) x' = f(z),   y = g(z),   d(f - M x', g) / d(x, u, t)

`z` is the vector of all values in the order of the references (see `fmus.interface`); behind them come numbers
that depend on the parameters alone, so that no step computes the cosine of a caster angle, and behind those the
terms (see `fmus.terms`) that the rates share with the outputs or the Jacobian. Common subexpressions are computed
once for each function. The mass matrix is solved in the runtime.
"""

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from importlib.resources import files
from math import inf

import jinja2
import sympy
from sympy.printing.c import C99CodePrinter

from fmus.interface import TOLERANCE, Interface
from fmus.terms import Term, common_subexpressions, opened, plain_symbol, term

ROLES = {"time": "TIME", "calculated": "CALCULATED", "input": "INPUT", "state": "STATE", "output": "OUTPUT", "derivative": "DERIVATIVE"}


CONSTANT = "constant "  # a name that no variable has
UNNAMED = (CONSTANT, "term_")  # read where they are; variables of the table get a name


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


def model_code(interface: Interface, identifier: str, guid: str) -> str:
    """The generated file `model.c` of an FMU."""
    template = jinja2.Environment(keep_trailing_newline=True, undefined=jinja2.StrictUndefined)
    source = files("fmus").joinpath("runtime/model.c.in").read_text("utf-8")
    return template.from_string(source).render(_context(interface, identifier, guid))


def _context(interface: Interface, identifier: str, guid: str) -> dict:
    form, component = interface.form, interface.component
    nx, nu = len(component.states), len(component.inputs)
    constants = Constants(interface)
    wide = form.slopes((*component.states, *component.inputs, "time"))
    functions = {
        "rates": [(f"f[{i}]", constants.hoist(e)) for i, e in enumerate(form.rates)],
        "mass": [(f"m[{i * nx + j}]", constants.hoist(form.mass[i, j])) for i in range(nx) for j in range(nx) if form.mass[i, j] != 0],
        "outputs": [(f"z[{v.reference}]", constants.hoist(form.outputs[component.outputs.index(v.name)])) for v in interface.of("output")],
        "jacobian": [(f"j[{i * wide.cols + k}]", constants.hoist(wide[i, k]))
                     for i in range(wide.rows) for k in range(wide.cols) if wide[i, k] != 0],
    }  # fmt: skip
    calculated = [(f"z[{v.reference}]", e) for v, e in zip(interface.of("calculated"), form.calculated, strict=True)]
    hoisted = [(f"z[{reference}]", e) for reference, e in constants.found()]
    places = constants.places()
    shared = shared_terms(functions)
    given = sorted(met(functions.values(), shared), key=shared.index)
    first_term = len(interface.variables) + len(hoisted)
    places.update({plain_symbol(t): f"z[{first_term + i}]" for i, t in enumerate(given)})
    return {
        "title": component.title,
        "identifier": identifier,
        "guid": guid,
        "variables": [_row(v) for v in interface.variables],
        "output_references": [interface.reference(n) for n in component.outputs],
        "held": [int(n in interface.held) for n in component.inputs],
        "has_held": int(bool(interface.held)),
        "first": {role: interface.first(role) for role in ("input", "state", "output", "derivative")},
        "n": {"values": first_term, "terms": len(given), "inputs": nu, "states": nx},
        "output_order": interface.output_order,
        "exact": int(interface.exact),
        "has_mass": int(form.has_mass),
        "tolerance": interface.references[TOLERANCE.name] if interface.has_tolerance else 0,
        "parameters": statements(calculated + hoisted, places),
        "terms": statements([(places[plain_symbol(t)], t) for t in given], places),
        **{name: statements(assigned, places, set(shared)) for name, assigned in functions.items()},
    }


Assignments = Sequence[tuple[str, sympy.Expr]]


def shared_terms(functions: Mapping[str, Assignments]) -> list[Term]:
    """The terms that rates or mass matrix share with outputs or Jacobian, each after those in its definition."""
    needed = {name: opened([e for _, e in assigned]) for name, assigned in functions.items()}
    elsewhere = {*needed["outputs"], *needed["jacobian"]}
    return [t for t in opened([e for name in ("rates", "mass") for _, e in functions[name]]) if t in elsewhere]


def met(functions: Iterable[Assignments], shared: Sequence[Term]) -> set[Term]:
    """Those shared terms that the functions mention themselves."""
    given = set(shared)
    found: set[Term] = set()
    for assigned in functions:
        expressions = [e for _, e in assigned]
        found.update(*(e.atoms(Term) for e in (*expressions, *(t.definition for t in opened(expressions, given)))))
    return found & given


class Constants:
    """Subexpressions that depend on the parameters alone, each given a place behind the values."""

    def __init__(self, interface: Interface):
        self.interface = interface
        self.parameters = {interface.form.symbols[v.name] for v in interface.of("parameter") if v.name in interface.form.symbols}
        self.symbols: dict[sympy.Expr, sympy.Symbol] = {}
        self.terms: dict[Term, sympy.Expr] = {}

    def hoist(self, expression: sympy.Expr) -> sympy.Expr:
        """The expression with every part that depends on the parameters alone replaced by its symbol."""
        if expression.is_Atom and not isinstance(expression, Term):
            return expression
        if isinstance(expression, sympy.Expr) and expression.free_symbols and expression.free_symbols <= self.parameters:
            return self.symbols.setdefault(expression, sympy.Symbol(f"{CONSTANT}{len(self.symbols)}", real=True))
        if isinstance(expression, Term):
            if expression not in self.terms:
                self.terms[expression] = term(self.hoist(expression.definition))
            return self.terms[expression]
        if expression.is_Add or expression.is_Mul:
            alone = [a for a in expression.args if not a.free_symbols - self.parameters]
            if len(alone) > 1 and any(a.free_symbols for a in alone):
                rest = [a for a in expression.args if a.free_symbols - self.parameters]
                return expression.func(self.hoist(expression.func(*alone)), *map(self.hoist, rest))
        return expression.func(*map(self.hoist, expression.args))

    def found(self) -> list[tuple[int, sympy.Expr]]:
        first = len(self.interface.variables)
        return [(first + i, expression) for i, expression in enumerate(self.symbols)]

    def places(self) -> dict[sympy.Symbol, str]:
        """The place of every symbol in the vector of values; x' of a state is in the array `rates`."""
        form, interface = self.interface.form, self.interface
        places = {symbol: f"z[{interface.reference(name)}]" for name, symbol in form.symbols.items()}
        places.update({symbol: f"z[{len(interface.variables) + i}]" for i, symbol in enumerate(self.symbols.values())})
        places.update({symbol: f"rates[{i}]" for i, symbol in enumerate(form.derivative_symbols)})
        return places


def statements(assigned: Assignments, places: Mapping[sympy.Symbol, str], given: Collection[Term] = ()) -> list[str]:
    """The C statements of `target = expression`: the variables that they read, common subexpressions, the targets.

    The given terms are read from their places.
    """
    if not assigned:
        return []
    common, reduced = common_subexpressions([e for _, e in assigned], given)
    used = set().union(*(e.atoms(sympy.Symbol) for e in (*reduced, *(e for _, e in common)))) & set(places)
    variables = sorted((s for s in used if not s.name.startswith(UNNAMED)), key=lambda s: _order(places[s]))
    names = {**places, **{s: c_name(s.name) for s in variables}, **{s: f"t{i}" for i, (s, _) in enumerate(common)}}
    printer = Printer({"contract": False, "math_macros": {}})
    printer._print_Symbol = names.__getitem__
    lines = [f"const double {names[symbol]} = {places[symbol]};" for symbol in variables]
    lines += [f"const double {names[symbol]} = {printer.doprint(expression)};" for symbol, expression in common]
    return lines + [f"{target} = {printer.doprint(e)};" for (target, _), e in zip(assigned, reduced, strict=True)]


def c_name(name: str) -> str:
    """A C name for a variable; the letter in front keeps it away from the keywords of C."""
    return "v_" + re.sub(r"\W", "_", name.replace(".", "__"))


def literal(value: float) -> str:
    """A number in C with all its digits; where there is no bound it is the largest number, so that infinity is outside."""
    if abs(value) == inf:
        return "DBL_MAX" if value > 0 else "-DBL_MAX"
    return repr(float(value))


def _order(place: str) -> tuple[str, int]:
    array, _, index = place.partition("[")
    return array, int(index[:-1])


def _row(variable) -> dict:
    role = ROLES.get(variable.role) or ("TUNABLE" if variable.row.tunable else "FIXED")
    bounded = variable.role in ("parameter", "input")
    low, high = (variable.row.min, variable.row.max) if bounded else (-inf, inf)
    numbers: Iterable[float] = (variable.start, low, high, variable.row.nominal)
    return {"name": variable.name, "unit": variable.row.unit, "role": role, "numbers": ", ".join(map(literal, numbers))}
