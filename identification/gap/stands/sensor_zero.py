"""What was recorded as an input is off by a constant: the zero of its sensor, a weight that hangs on it.

    u = u_recorded + u_0

In a linear component it is an offset of the outputs, which are not compared. A spring that stiffens, play or a limit feel it, and
would be taken for lopsided ones.
"""

from dataclasses import replace

from fmus.component import Component
from fmus.effects.effect import Effect, adds_to
from fmus.variables import parameter


class SensorZero(Effect):
    """What acts is more, by a constant, than what was recorded as an input."""

    part = "channel"
    offset = parameter("1", "What acts beyond what was recorded", symbol="u_0", start=0.0)

    @adds_to("force")
    def beyond(self, v, m):
        return v.offset


def zero_parameter(name: str) -> str:
    """The name of the parameter that the zero of an input brings."""
    return f"{name}_zero.offset"


def zero_of(component: Component, name: str) -> type[SensorZero]:
    """The zero of an input, or of a state that is imposed."""
    offset = replace(SensorZero.declared["offset"], unit=component.table[name].unit)
    return type("SensorZero", (SensorZero,), {"__doc__": SensorZero.__doc__, "family": f"{name}_zero", "element": name, "offset": offset})
