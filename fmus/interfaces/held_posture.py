"""A device at the handlebar whose rest is a held posture: in a corner, the bar at its steady steer angle.

With the steer angle delta_0 and the frame rate w_0 of the held posture, the device has

    steer_angle - delta_0,    frame_rate - w_0

in place of the motion at its port. Its springs are then free of load in the held posture, and its torques are those
that are added to the constant ones with which the posture is held.
"""

from typing import Any

from fmus.declaration.variables import parameter
from fmus.effects import Effect, adds_to


class HeldPosture(Effect):
    """The motion at the port of a device is relative to a held posture."""

    held_steer_angle = parameter("rad", "Steer angle of the held posture", symbol=r"\delta_0", min=-3.2, max=3.2)
    held_frame_rate = parameter("rad/s", "Frame rate of the held posture", symbol="w_0", min=-100, max=100)

    @adds_to("steer_angle")
    def angle(self, v: Any, m: Any) -> Any:
        return -v.held_steer_angle

    @adds_to("frame_rate")
    def rate(self, v: Any, m: Any) -> Any:
        return -v.held_frame_rate
