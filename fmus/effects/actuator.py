"""Actuators that saturate: the input that acts on the component is less than the recorded command.

    clip   T = u - s (u - clip(u, -L, L))
    soft   T = u - s (u - L tanh(u / L))

u is the recorded command, L the limit, s the share of the command beyond the limit that is lost (1: a hard limit).
"""

from typing import ClassVar

from fmus.declaration.variables import parameter
from fmus.effects.effect import Effect, adds_to
from fmus.effects.stiffness import beyond

# Share of the largest command; with a lower limit nearly all of the command is beyond it, and the law is a factor on
# the command, which the parameters of the component compensate for.
LOWEST = 0.1


class ClippedActuator(Effect):
    """The actuator saturates: beyond a limit part of its command is lost."""

    family, form, element = "saturation", "clip", "input"
    share = parameter("1", "Share of the command beyond the limit that is lost", symbol="s_u", min=0, max=1, start=0.5)
    limit = parameter("N.m", "Command at which the actuator stops", symbol="L", min=1e-9, start=1.0)
    starts: ClassVar = {"limit": (0.3, 0.5, 0.7, 0.85)}
    relative_to_level: ClassVar = ("limit",)
    in_its_unit: ClassVar = ("limit",)
    at_least_of_level: ClassVar = {"limit": LOWEST}

    @adds_to("force")
    def reduction(self, v, m):
        return -v.share * beyond(v.force, v.limit, m)


class SoftActuator(ClippedActuator):
    """The actuator saturates smoothly towards a limit."""

    form = "soft"
    starts: ClassVar = {"limit": (0.5, 1.0, 2.0)}

    @adds_to("force")
    def reduction(self, v, m):
        return -v.share * (v.force - v.limit * m.tanh(v.force / v.limit))
