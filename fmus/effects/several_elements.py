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
    """Base class of laws at several elements, whose forces have one unit; `law` acts at each of `places`."""

    at_several: ClassVar = True
    law: ClassVar[type[Effect]]
    places: ClassVar[tuple[str, ...]]

    @classmethod
    def magnitudes_by_element(cls) -> list[tuple[str, ...]]:
        """The magnitudes at each of its elements: where those of one are zero, it is absent there."""
        names = [own_names(cls.law, place) for place in cls.places]
        return [tuple(of_place[n] for n in cls.law.magnitudes()) for of_place in names]

    def additions(self) -> Iterator[tuple[str, Callable]]:
        """Every target of the law at every element, with the method that computes its term."""
        for place in self.places:
            names = own_names(self.law, place)
            for target, method in self.law().additions():
                yield names[target], _renamed(method, names)

    def _words(self, component: Component) -> dict[str, str]:
        return {
            f"{word}_{place}": name
            for place in self.places
            for word, name in self.law.words_at(component, place).items()
        }


def at_several_elements(law: type[Effect], places: tuple[str, ...]) -> type[Effect]:
    """The law at several elements.

    >>> from fmus.effects.damping import CoulombFriction
    >>> list(at_several_elements(CoulombFriction, ("shoulder", "elbow")).parameters())
    ['friction_torque_shoulder', 'friction_torque_elbow', 'sliding_rate']
    """
    rows: dict[str, Variable] = {}
    for place in places:
        names = own_names(law, place)
        rows |= {names[n]: replace(row, name=names[n]) for n, row in law.declared.items()}
    magnitudes_first = sorted(rows, key=lambda n: n in law.declared)
    own = {
        "__doc__": law.__doc__,
        "law": law,
        "places": places,
        "family": law.family,
        "form": f"{law.form}_{'_and_'.join(places)}",
        "element": " and ".join(places),
        "starts": law.starts,
        "given": law.given,
        "at_least_sliding": law.at_least_sliding,
    }
    return type(law.__name__, (AtSeveralElements,), own | {n: rows[n] for n in magnitudes_first})


def own_names(law: type[Effect], place: str) -> dict[str, str]:
    """The names at an element: with its name for magnitudes, the same at all elements for the other parameters."""
    common = {*law.nonlinear_parameters(), *law.given}
    return {n: n if n in common else f"{n}_{place}" for n in (*law.declared, *WORDS)}


def _renamed(method: Callable, names: Mapping[str, str]) -> Callable:
    return lambda v, m: method(_Renamed(v, names), m)


class _Renamed:
    """The argument `v` of a law's methods at one of its elements."""

    def __init__(self, view: Any, names: Mapping[str, str]):
        self._view, self._names = view, names

    def __getattr__(self, word: str) -> Any:
        return getattr(self._view, self._names.get(word, word))
