"""An element of a component where a force law acts: the names of its force, deflection and rate.

A law (hardening, backlash, friction) is written once in the words `force`, `deflection`, `rate`, `stiffness` and
`damping`, and holds for the arms of a rider as for the spring of an oscillator.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields


@dataclass(frozen=True)
class Element:
    """Local variable of the force (positive along the deflection), names of deflection and rate, parameters if any."""

    force: str
    deflection: str
    rate: str
    stiffness: str = ""
    damping: str = ""

    def renamed(self, rename: Callable[[str], str]) -> "Element":
        """The element in other names, as a part's is in those of the whole."""
        names = (getattr(self, f.name) for f in fields(self))
        return Element(*(name and rename(name) for name in names))
