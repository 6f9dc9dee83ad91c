"""The terms that an effect adds, as equations in words.

    added_terms(CoulombFriction)     # ["force += friction_torque tanh(rate/sliding_rate)"]
"""

import re
from typing import Any

import sympy
from sympy.core.relational import Relational

from fmus.effects.effect import Effect
from fmus.expressions.symbolic_functions import SYMBOLIC

LONGEST = 160  # characters of one equation
SIGNALS = ("input", "output", "state")  # the elements of laws that are not placed at a force element


class _Names:
    """Every quantity that a term reads, as a symbol of its name."""

    def __init__(self, words: dict[str, str]):
        self.words = words

    def __getattr__(self, name: str) -> sympy.Symbol:
        return sympy.Symbol(self.words.get(name, name), real=True)

    __getitem__ = __getattr__


def added_terms(effect: type[Effect]) -> list[str]:
    """An equation for each target of an effect, those of its states last; empty unless all have a short form in
    symbols."""
    equations: list[str] = []
    made: Any = effect()
    words = _words(effect)
    for target, term in made.additions():
        try:
            added = sympy.sympify(term(_Names(words), SYMBOLIC)).evalf(4)
        except (TypeError, ValueError, AttributeError, KeyError):  # a term that reads a table or calls other code
            return []
        text = re.sub(r"(?<!\*)\*(?!\*)", " ", str(added)).replace("**", "^").replace("Abs(", "abs(")
        if len(text) > LONGEST or added.atoms(Relational):
            return []
        state = re.fullmatch(r"der\((\w+)\)", target)
        own = state is not None and state[1] in effect.declared
        target = re.sub(r"\w+", lambda word: words.get(word[0], word[0]), target)
        place = f"element {target}" if target in effect.declared else target
        equations += [f"{place} {'=' if own else '+='} {text}"] if added != 0 else []
    defined = {equation.split(" ")[0] for equation in equations}
    if any(row.role == "state" and f"der({n})" not in defined for n, row in effect.declared.items()):
        return []
    return sorted(dict.fromkeys(equations), key=lambda equation: equation.startswith("der("))


def _words(effect: type[Effect]) -> dict[str, str]:
    """The names of the signals at which a law acts, for its words `force` and `deflection`; none at other elements."""
    if not any(vars(law).get("element") in SIGNALS for law in effect.__mro__):
        return {}
    deflection, _, force = effect.element.partition("_to_")
    return {"deflection": deflection, "force": force or deflection}
