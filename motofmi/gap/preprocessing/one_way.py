"""Recorded rates with one sign, as of a coast-down.

    x' = -(d x + f) / J,  y = x + o:    y' = -(d y + f - d o) / J

While a mass moves one way, dry friction f is a constant force, and so is the effect of an offset o of the rate's sensor
beside a linear damper: they are not distinguishable. The offset is taken as zero there, since that of tachometers and
encoders is small. A rate that oscillates about a mean without an input is that of a spring, and the mean is the offset
of its sensor, as of a gyroscope.
"""

from collections.abc import Iterable

import numpy as np

from fmus.declaration.elements import Element
from motofmi.recordings.recording import Recording

OTHER_WAY = 0.01  # share of the travel against the direction of the motion, below which a motion is one-way
OSCILLATES = 0.5  # share of its range by which a rate returns that oscillates
ONE_WAY = (
    "{}: {} has one sign: the offset of its sensor is taken as zero, since in a run of one direction it is not "
    "distinguishable from dry friction"
)


def one_way_rates(recording: Recording, elements: Iterable[Element], free: bool = False) -> frozenset[str]:
    """The recorded rates of elements that have one sign, except for noise about standstill. A rate that
    oscillates in a free motion is left out: its mean is the offset of its sensor."""
    rates = {element.rate for element in elements if element.rate in recording.columns}
    return frozenset(
        name
        for name in rates
        if is_one_way(recording[name]) and not (free and any(map(oscillates, recording.parts(name))))
    )


def is_one_way(rate: np.ndarray) -> bool:
    """Whether a rate (n,) has one sign, except for noise about standstill."""
    there, back = np.sum(np.maximum(rate, 0.0)), np.sum(np.maximum(-rate, 0.0))
    return bool(min(there, back) < OTHER_WAY * (there + back))


def keeps_direction(deflection: np.ndarray) -> bool:
    """Whether a deflection (n,) never returns by `OTHER_WAY` of its range or more."""
    return largest_return(deflection) < OTHER_WAY


def direction_of(deflection: np.ndarray) -> float:
    """The sign of the change of a deflection (n,) that keeps its direction; else 0."""
    return float(np.sign(deflection[-1] - deflection[0])) if keeps_direction(deflection) else 0.0


def oscillates(values: np.ndarray) -> bool:
    """Whether a signal (n,) returns by `OSCILLATES` of its range or more."""
    return largest_return(values) >= OSCILLATES


def largest_return(values: np.ndarray) -> float:
    """The largest way back of a signal (n,) in the direction opposite to its main one, over its range."""
    returns = min(float(np.max(np.maximum.accumulate(there) - there)) for there in (values, -values))
    return returns / max(float(np.ptp(values)), 1e-300)
