"""Sensors of any component whose gain depends on what they measure; the reference is the largest reading.

A sensor that shows more where there is more of what it measures loses no more than a third of its gain at the largest
reading: y (1 + g y^2 / r^2) turns back at g = -1/3, y (1 + g y / r) at g = -1/2.
"""

from fmus.effects.channel import SensorNonlinearity, UnevenSensor
from fmus.variables import parameter


class CubicSensor(SensorNonlinearity):
    """The sensor's gain changes with the square of its reading."""

    cubic_gain = parameter("1", "Relative change of the gain at the largest reading", symbol="g_3", min=-0.33, max=1, start=0.05)


class QuadraticSensor(UnevenSensor):
    """The sensor's gain differs with the direction of its reading."""

    quadratic_gain = parameter("1", "Relative change of the gain at the largest reading, odd in it", symbol="g_2", min=-0.5, max=0.5, start=0.05)
