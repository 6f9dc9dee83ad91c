"""An element of a component where a force law acts: the names of its force, deflection and rate.

A law (hardening, backlash, friction) is written once in the words `force`, `deflection`, `rate`, `stiffness` and
`damping`, and holds for the arms of a rider as for the spring of an oscillator.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Element:
    """Local variable of the force (positive along the deflection), names of deflection and rate, parameters if any."""

    force: str
    deflection: str
    rate: str
    stiffness: str = ""
    damping: str = ""
