"""Sensors whose gain depends on the reading, for any component; the reference is the largest reading.

The reading must grow with the measured quantity up to the reference: y (1 + g y^2 / r^2) does so for g > -1/3 and
y (1 + g y / r) for g > -1/2, hence the lower bounds.
"""

from fmus.declaration.variables import parameter
from fmus.effects.measuring_channel import SensorNonlinearity, UnevenSensor


class CubicSensor(SensorNonlinearity):
    """The sensor's gain changes with the square of its reading."""

    element = "output"
    cubic_gain = parameter(
        "1", "Relative change of the gain at the largest reading", symbol="g_3", min=-0.33, max=1, start=0.05
    )


class QuadraticSensor(UnevenSensor):
    """The sensor's gain differs with the direction of its reading."""

    element = "output"
    quadratic_gain = parameter(
        "1",
        "Relative change of the gain at the largest reading, odd in it",
        symbol="g_2",
        min=-0.5,
        max=0.5,
        start=0.05,
    )
