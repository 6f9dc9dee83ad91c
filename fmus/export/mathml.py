"""Equations as presentation MathML, which browsers show without a script: the symbols of the component's table."""

import html
import re
from collections.abc import Mapping
from typing import Any
from xml.dom.minidom import parseString

import sympy
from sympy.printing.mathml import MathMLPresentationPrinter

ACCENTS = {"dot": "&#x2d9;", "ddot": "&#xa8;", "bar": "&#xaf;", "hat": "^", "tilde": "~"}
GROUP = r"\{((?:[^{}]|\{[^{}]*\})*)\}"


class _Printer(MathMLPresentationPrinter):
    def __init__(self, latex: Mapping[str, str]):
        super().__init__()
        self._latex = latex

    def _print_Symbol(self, symbol: sympy.Symbol, style: str = "plain") -> Any:
        return parseString(symbol_markup(self._latex.get(symbol.name, symbol.name))).documentElement


def markup(expression: sympy.Expr, latex: Mapping[str, str]) -> str:
    """An expression as MathML without the element `math`; latex gives the LaTeX symbol of a name."""
    return _Printer(latex)._print(sympy.sympify(expression)).toxml()


def symbol_markup(latex: str) -> str:
    r"""A LaTeX symbol as MathML: `\delta`, `I_t`, `\dot{\delta}`, `k_{a,1}'`; any other text as it is."""
    text = latex.strip()
    if whole := re.fullmatch(rf"\\(mathrm|text|mathit){GROUP}", text):
        return f"<mi>{html.escape(whole[2].replace(chr(92) + '_', '_'), quote=False)}</mi>"
    if accented := re.fullmatch(rf"\\({'|'.join(ACCENTS)}){GROUP}(.*)", text):
        base = f"<mover>{symbol_markup(accented[2])}<mo>{ACCENTS[accented[1]]}</mo></mover>"
        return _with_scripts(base, accented[3])
    plain = re.match(r"\\([A-Za-z]+)|[A-Za-z0-9]+", text)
    if plain is None:
        return f"<mi>{html.escape(text, quote=False)}</mi>"
    name = html.unescape(f"&{plain[1]};") if plain[1] else plain[0]
    return _with_scripts(f"<mi>{html.escape(name.strip('&;'), quote=False)}</mi>", text[plain.end() :])


def _with_scripts(base: str, rest: str) -> str:
    """A base with what follows it: `_x`, `_{...}`, `^x`, primes."""
    below = re.search(rf"_(?:{GROUP}|(\\?\w))", rest)
    above = re.search(rf"\^(?:{GROUP}|(\\?\w))|('+)", rest)
    parts = [script and next(part for part in script.groups() if part is not None) for script in (below, above)]
    under, over = (part and symbol_markup(part) for part in parts)
    if under and over:
        return f"<msubsup>{base}{under}{over}</msubsup>"
    if under or over:
        return f"<msub>{base}{under}</msub>" if under else f"<msup>{base}{over}</msup>"
    return base
