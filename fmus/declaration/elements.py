"""Force elements: places in a component at which a force law can act, by the names of force, deflection and rate.

A force law (hardening, backlash, friction) is written once in terms of `force`, `deflection`, `rate`, `stiffness` and
`damping`. It then applies to the arms of a rider and to the spring of an oscillator alike.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields


@dataclass(frozen=True)
class Element:
    """The variables of a force element of a component, by name.

    force is a local variable [N or N.m], positive along the deflection [m or rad]. rate is the time derivative of the
    deflection, whose name is empty where the component has the rate alone. stiffness and damping are parameters; each
    is empty where the element has none. `renamed` maps every name, as from those of a part to those of its system.

        >>> arms = mf.Element("arm_torque", "arm_deflection", "arm_rate", stiffness="arm_stiffness")
        >>> arms.renamed(lambda name: f"device.{name}").force
        'device.arm_torque'
    """

    force: str
    deflection: str
    rate: str
    stiffness: str = ""
    damping: str = ""

    def renamed(self, rename: Callable[[str], str]) -> "Element":
        """The element with every name mapped, as from the names of a part to those of its system."""
        names = (getattr(self, f.name) for f in fields(self))
        return Element(*(name and rename(name) for name in names))
