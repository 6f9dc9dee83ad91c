"""A constant offset of a recorded input: the bias of its sensor, or a constant load that is not recorded.

    u = u_recorded + u_0

In a linear component it only offsets the outputs, and offsets are not compared. With a hardening spring, backlash or a
limit it changes the response. If it were left out, an asymmetry would be fitted instead.
"""

from dataclasses import replace

from fmus.declaration.component import Component
from fmus.declaration.variables import parameter
from fmus.effects.effect import Effect, adds_to


class SensorOffset(Effect):
    """The input that acts differs from the recorded one by a constant."""

    part = "channel"
    offset = parameter("1", "Constant that acts in addition to the recorded input", symbol="u_0", start=0.0)

    @adds_to("force")
    def constant(self, v, m):
        return v.offset


def sensor_offset_parameter(name: str) -> str:
    """The name of the parameter of an input's sensor offset."""
    return f"{name}_sensor.offset"


def sensor_offset_effect(component: Component, name: str) -> type[SensorOffset]:
    """The sensor offset of an input or of an imposed state, as an effect."""
    offset = replace(SensorOffset.declared["offset"], unit=component.table[name].unit)
    return type(
        "SensorOffset",
        (SensorOffset,),
        {"__doc__": SensorOffset.__doc__, "family": f"{name}_sensor", "element": name, "offset": offset},
    )
