"""Wiring by equal names: the sources of an input are the outputs of that name at the other parts."""

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from fmus.support.errors import InputError


class HasPorts(Protocol):
    """Anything with named inputs and outputs: a component, an FMU, a linear model."""

    @property
    def inputs(self) -> Sequence[str]:
        """The names of the inputs."""

    @property
    def outputs(self) -> Sequence[str]:
        """The names of the outputs."""


def join(parts: Mapping[str, HasPorts], adds_up: Callable[[str, str], bool]) -> dict[str, list[str]]:
    """The wiring {`part.input`: [`other.output`, ...]}; `adds_up(part, input)` tells whether several sources are
    summed.

    Raises InputError when an input that is not summed has several sources.
    """
    wiring: dict[str, list[str]] = {}
    for part, ends in parts.items():
        for name in ends.inputs:
            sources = [f"{other}.{name}" for other, others in parts.items() if other != part and name in others.outputs]
            if len(sources) > 1 and not adds_up(part, name):
                raise InputError(
                    f"{part}.{name} has {len(sources)} writers: {', '.join(sources)}; only torques and forces add up"
                )
            if sources:
                wiring[f"{part}.{name}"] = sources
    return wiring
