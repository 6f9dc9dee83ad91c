"""Wiring by equal names: every input meets the outputs of its name at the other parts."""

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from fmus.errors import InputError


class Ends(Protocol):
    """What has inputs and outputs by name: a component, an FMU, a linear model."""

    @property
    def inputs(self) -> Sequence[str]: ...

    @property
    def outputs(self) -> Sequence[str]: ...


def join(parts: Mapping[str, Ends], adds_up: Callable[[str, str], bool]) -> dict[str, list[str]]:
    """The wiring `part.input` -> [`other.output`]; `adds_up(part, input)` says whether several sources sum.

    Raises InputError when two parts write an input that does not add up.
    """
    wiring: dict[str, list[str]] = {}
    for part, ends in parts.items():
        for name in ends.inputs:
            sources = [f"{other}.{name}" for other, others in parts.items() if other != part and name in others.outputs]
            if len(sources) > 1 and not adds_up(part, name):
                raise InputError(f"{part}.{name} has {len(sources)} writers: {', '.join(sources)}; only torques and forces add up")
            if sources:
                wiring[f"{part}.{name}"] = sources
    return wiring
