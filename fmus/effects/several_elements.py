"""A law at several elements of a component: dry friction in both joints of an arm.

    F_1 = f(d_1', T_1, s),   F_2 = f(d_2', T_2, s)

Every element has magnitudes T of its own. The other parameters s, such as the width of a transition, are common.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, replace
from typing import Any, ClassVar

from fmus.declaration.component import Component
from fmus.declaration.elements import Element
from fmus.declaration.variables import Variable
from fmus.effects.effect import Effect

WORDS = tuple(f.name for f in fields(Element))


class AtSeveralElements(Effect):
    """Base class of laws at several elements, whose forces have one unit."""

    law: ClassVar[type[Effect]]

    @classmethod
    def magnitudes_by_element(cls) -> list[tuple[str, ...]]:
        """The magnitudes at each of its elements: where those of one are zero, it is absent there."""
        names = [own_names(cls.law, alone.element) for alone in cls.at_one]
        return [tuple(of_element[n] for n in cls.law.magnitudes()) for of_element in names]

    def additions(self) -> Iterator[tuple[str, Callable]]:
        """Every target of the law at every element, with the method that computes its term."""
        for alone in self.at_one:
            names = own_names(self.law, alone.element)
            for target, method in self.law().additions():
                yield names[target], _renamed(method, names)

    def _words(self, component: Component) -> dict[str, str]:
        return {
            f"{word}_{alone.element}": name
            for alone in self.at_one
            for word, name in self.law.words_at(component, alone.element).items()
        }


def at_several_elements(law: type[Effect], at_one: tuple[type[Effect], ...]) -> type[Effect]:
    """The law at several elements, from the law at each of them alone.

    >>> from fmus.effects.damping import CoulombFriction
    >>> joints = [type("Friction", (CoulombFriction,), {"element": name}) for name in ("shoulder", "elbow")]
    >>> list(at_several_elements(CoulombFriction, tuple(joints)).parameters())
    ['friction_torque_shoulder', 'friction_torque_elbow', 'sliding_rate']
    """
    elements, rows = [alone.element for alone in at_one], dict[str, Variable]()
    for element in elements:
        names = own_names(law, element)
        rows |= {names[n]: replace(row, name=names[n]) for n, row in law.declared.items()}
    magnitudes_first = sorted(rows, key=lambda n: n in law.declared)
    own = {
        "__doc__": law.__doc__,
        "law": law,
        "at_one": at_one,
        "family": law.family,
        "form": f"{law.form}_{'_and_'.join(elements)}",
        "element": " and ".join(elements),
        "starts": at_one[0].starts,
        "given": law.given,
        "at_least_sliding": law.at_least_sliding,
        "at_most_of_rate": law.at_most_of_rate,
    }
    return type(law.__name__, (AtSeveralElements,), own | {n: rows[n] for n in magnitudes_first})


def own_names(law: type[Effect], element: str) -> dict[str, str]:
    """The names at an element: with its name for magnitudes, the same at all elements for the other parameters."""
    common = {*law.nonlinear_parameters(), *law.given}
    return {n: n if n in common else f"{n}_{element}" for n in (*law.declared, *WORDS)}


def _renamed(method: Callable, names: Mapping[str, str]) -> Callable:
    return lambda v, m: method(_Renamed(v, names), m)


class _Renamed:
    """The argument `v` of a law's methods at one of its elements."""

    def __init__(self, view: Any, names: Mapping[str, str]):
        self._view, self._names = view, names

    def __getattr__(self, word: str) -> Any:
        return getattr(self._view, self._names.get(word, word))
