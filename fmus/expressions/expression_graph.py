"""Expression graphs in SymPy: terms are symbols that stand for a shared subexpression.

    E = m.term(expression)      # on numbers the expression itself

SymPy represents an expression as a tree: the closed arm loops of a rider have 1600 operations as a graph and 30 million
as a tree. A term is evaluated once. Its derivatives are terms again; known derivatives, such as those of positions (see
`fmus.expressions.taylor2`), can be passed to it. A term must not contain a switch (`m.where`), because the analysis of
switching functions does not look into terms.

    {key: T} = m.total(values, function)      # T = sum of function(value)[key]

A total is a term defined by its summand for one value. Generated C code has a loop for it; elsewhere it is expanded.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from hashlib import sha256
from typing import Any

import sympy

_TERMS: dict[str, "Term"] = {}


class Term(sympy.Symbol):
    """A symbol with a definition. The name is a digest of the definition, so that generated code is reproducible."""

    definition: sympy.Expr
    each: "Each | None"
    _free: set[sympy.Symbol]
    _slopes: dict[sympy.Symbol, sympy.Expr]

    def __new__(
        cls, definition: sympy.Expr, slopes: Mapping[sympy.Symbol, sympy.Expr] | None = None, each: "Each | None" = None
    ) -> "Term":
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
        """The symbols that the definition depends on, terms expanded."""
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
        """A term with another definition; of a total, a total over the same values."""
        return term(definition) if self.each is None else total(definition, self.each)


class Each(sympy.Symbol):
    """The symbol that takes each of the values of a total."""

    values: tuple[float, ...]

    def __new__(cls, values: tuple[float, ...]) -> "Each":
        each = sympy.Symbol.__xnew__(cls, f"each of {', '.join(map(str, values))}", real=True)
        each.values = values
        return each


def term(expression, variables: Sequence = (), slopes: Sequence = ()) -> sympy.Expr:
    """The expression as a term; symbols and numbers are returned unchanged.

    `slopes` are known derivatives with respect to `variables`; variables that are not plain symbols are ignored.
    """
    expression = sympy.sympify(expression)
    known_already = expression.is_Atom and not (isinstance(expression, Term) and variables)
    if known_already or (-expression).is_Atom:
        return expression
    pairs = zip(variables, map(sympy.sympify, slopes), strict=True)
    return Term(expression, {x: slope for x, slope in pairs if isinstance(x, sympy.Symbol) and not isinstance(x, Term)})


def total(summand: sympy.Expr, each: Each) -> sympy.Expr:
    """The sum of the summand over the values of `each`."""
    return Term(summand, each=each) if each in summand.free_symbols else len(each.values) * summand


def totals(values: Sequence[float], function: Callable[[Any], Mapping[Any, Any]]) -> dict[Any, sympy.Expr]:
    """The totals of all entries that the function returns."""
    each = Each(tuple(values))
    return {key: total(sympy.sympify(summand), each) for key, summand in function(each).items()}


def common_subexpressions(
    expressions: Sequence[sympy.Expr], given: Collection[Term] = ()
) -> tuple[list[tuple[sympy.Symbol, sympy.Expr]], list[sympy.Expr]]:
    """The result of `sympy.cse`, with terms as plain symbols assigned in order of dependence, except those in
    `given`.
    """
    expressions = expand_totals(expressions, {}, given)
    terms = terms_in(expressions, given)
    plain = {t: plain_symbol(t) for t in (*terms, *given)}
    expanded = (
        [e.xreplace(plain) for e in [*(t.definition for t in terms), *expressions]] if plain else list(expressions)
    )
    found, reduced = sympy.cse(expanded, symbols=sympy.numbered_symbols("common_"))
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
    """A plain symbol with the name of a term."""
    return sympy.Symbol(term.name, real=True)


def expand_totals(
    expressions: Sequence[sympy.Expr], rule: dict[sympy.Expr, sympy.Expr], given: Collection[Term] = ()
) -> list[sympy.Expr]:
    """The expressions with the totals that are not in `given` expanded, and the replacements of `rule` applied."""
    terms = terms_in(expressions, given)
    if not rule and all(t.each is None for t in terms):
        return list(expressions)
    new = dict(rule)
    for t in terms:
        if t.each is None:
            new[t] = term(t.definition.xreplace(new))
        else:
            new[t] = sympy.Add(
                *(expand_totals([t.definition], {**rule, t.each: sympy.sympify(x)}, given)[0] for x in t.each.values)
            )
    return [e.xreplace(new) for e in expressions]


def terms_in(expressions: Sequence[sympy.Expr], given: Collection[Term] = ()) -> list[Term]:
    """The terms of the expressions except those in `given`, each after the terms of its definition."""
    found: dict[Term, None] = {}

    def visit(expression: sympy.Expr) -> None:
        for inner in sorted(expression.atoms(Term), key=lambda t: t.name):
            if inner not in found and inner not in given:
                visit(inner.definition)
                found[inner] = None

    for expression in expressions:
        visit(expression)
    return list(found)
