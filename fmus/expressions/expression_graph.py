"""Terms: symbols that stand for an expression, so that a large model stays a graph instead of growing into a tree.

    E = m.term(expression)      # the expression itself on numbers

A term knows what it depends on and is differentiated through, its slopes being terms again; each is computed once.
Where a slope is known already, as those of a mechanism's positions are (see `fmus.jets`), the term is told.
SymPy visits an expression as a tree: the closed arm loops of a rider are 1600 operations as a graph and 30 million
as a tree. A term must not hold a switch (`m.where`), which would be hidden from those who look for switches.

    {key: T} = m.total(values, function)      # T = sum of function(value)[key]

A total is a term whose definition is the summand for one value, so that C code can be a loop; elsewhere it is
written out.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from hashlib import sha256
from typing import Any

import sympy

_TERMS: dict[str, "Term"] = {}


class Term(sympy.Symbol):
    """A symbol with a definition. Its name is a digest of that, so that generated code is always the same."""

    definition: sympy.Expr
    each: "Each | None"
    _free: set[sympy.Symbol]
    _slopes: dict[sympy.Symbol, sympy.Expr]

    def __new__(cls, definition: sympy.Expr, slopes: Mapping[sympy.Symbol, sympy.Expr] | None = None, each: "Each | None" = None) -> "Term":
        known = (definition, *(part for pair in (slopes or {}).items() for part in pair), *([each] if each else []))
        name = "term_" + sha256("; ".join(sympy.srepr(e, order="none") for e in known).encode()).hexdigest()[:16]
        if name not in _TERMS:
            term = sympy.Symbol.__xnew__(cls, name, real=True)
            term.definition, term._slopes, term.each = definition, dict(slopes or {}), each
            term._free = definition.free_symbols - {each}
            _TERMS[name] = term
        return _TERMS[name]

    @property
    def free_symbols(self) -> set[sympy.Symbol]:
        """The symbols that the definition depends on in the end; no terms."""
        return self._free

    def _eval_derivative(self, symbol: sympy.Symbol) -> sympy.Expr:
        if symbol not in self._slopes:
            self._slopes[symbol] = self.like(self.definition.diff(symbol))
        return self._slopes[symbol]

    def _eval_derivative_n_times(self, symbol: sympy.Symbol, n: int) -> sympy.Expr:
        slope: sympy.Expr = self
        for _ in range(int(n)):
            slope = slope._eval_derivative(symbol)
        return slope

    def _xreplace(self, rule) -> tuple[sympy.Expr, bool]:
        if self in rule:
            return rule[self], True
        if self._free.isdisjoint(rule):
            return self, False
        return self.like(self.definition.xreplace(rule)), True

    def _eval_subs(self, old: sympy.Expr, new: sympy.Expr) -> sympy.Expr:
        return self if self._free.isdisjoint(old.free_symbols) else self.like(self.definition._subs(old, new))

    def like(self, definition: sympy.Expr) -> sympy.Expr:
        """A term, or a total over the same values, with another definition."""
        return term(definition) if self.each is None else total(definition, self.each)


class Each(sympy.Symbol):
    """What takes each of some values in a total."""

    values: tuple[float, ...]

    def __new__(cls, values: tuple[float, ...]) -> "Each":
        each = sympy.Symbol.__xnew__(cls, f"each of {', '.join(map(str, values))}", real=True)
        each.values = values
        return each


def term(expression, variables: Sequence = (), slopes: Sequence = ()) -> sympy.Expr:
    """The expression as a term; symbols and numbers stay what they are.

    `slopes` are the known ones with respect to `variables`; a variable that is no plain symbol is passed over.
    """
    expression = sympy.sympify(expression)
    known_already = expression.is_Atom and not (isinstance(expression, Term) and variables)
    if known_already or (-expression).is_Atom:
        return expression
    pairs = zip(variables, map(sympy.sympify, slopes), strict=True)
    return Term(expression, {x: slope for x, slope in pairs if isinstance(x, sympy.Symbol) and not isinstance(x, Term)})


def total(summand: sympy.Expr, each: Each) -> sympy.Expr:
    """The sum over the values of `each`."""
    return Term(summand, each=each) if each in summand.free_symbols else len(each.values) * summand


def totals(values: Sequence[float], function: Callable[[Any], Mapping[Any, Any]]) -> dict[Any, sympy.Expr]:
    """The totals of all that the function gives."""
    each = Each(tuple(values))
    return {key: total(sympy.sympify(summand), each) for key, summand in function(each).items()}


def common_subexpressions(expressions: Sequence[sympy.Expr], given: Collection[Term] = ()) -> tuple[list[tuple[sympy.Symbol, sympy.Expr]], list[sympy.Expr]]:
    """What `sympy.cse` returns; terms are plain symbols by then, each assigned after what it needs, but for those given."""
    expressions = written_out(expressions, {}, given)
    terms = opened(expressions, given)
    plain = {t: plain_symbol(t) for t in (*terms, *given)}
    opened_too = [e.xreplace(plain) for e in [*(t.definition for t in terms), *expressions]] if plain else list(expressions)
    found, reduced = sympy.cse(opened_too, symbols=sympy.numbered_symbols("common_"))
    pool = {**dict(found), **dict(zip(map(plain_symbol, terms), reduced[: len(terms)], strict=True))}
    ordered: dict[sympy.Symbol, sympy.Expr] = {}

    def assign(expression: sympy.Expr) -> None:
        for symbol in sorted(expression.atoms(sympy.Symbol), key=lambda s: s.name):
            if symbol in pool and symbol not in ordered:
                assign(pool[symbol])
                ordered[symbol] = pool[symbol]

    for expression in reduced[len(terms) :]:
        assign(expression)
    return list(ordered.items()), reduced[len(terms) :]


def plain_symbol(term: Term) -> sympy.Symbol:
    """The symbol of a term's name, which stands for nothing."""
    return sympy.Symbol(term.name, real=True)


def written_out(expressions: Sequence[sympy.Expr], rule: dict[sympy.Expr, sympy.Expr], given: Collection[Term] = ()) -> list[sympy.Expr]:
    """The expressions with the totals that are not given as sums, and with what the rule replaces in them."""
    terms = opened(expressions, given)
    if not rule and all(t.each is None for t in terms):
        return list(expressions)
    new = dict(rule)
    for t in terms:
        if t.each is None:
            new[t] = term(t.definition.xreplace(new))
        else:
            new[t] = sympy.Add(*(written_out([t.definition], {**rule, t.each: sympy.sympify(x)}, given)[0] for x in t.each.values))
    return [e.xreplace(new) for e in expressions]


def opened(expressions: Sequence[sympy.Expr], given: Collection[Term] = ()) -> list[Term]:
    """The terms that the expressions need besides those given, each after those in its definition."""
    found: dict[Term, None] = {}

    def visit(expression: sympy.Expr) -> None:
        for inner in sorted(expression.atoms(Term), key=lambda t: t.name):
            if inner not in found and inner not in given:
                visit(inner.definition)
                found[inner] = None

    for expression in expressions:
        visit(expression)
    return list(found)
