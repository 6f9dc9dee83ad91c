"""The intervals of a recording in which a vehicle neither starts, stops nor falls, and no channel has outliers."""

from collections.abc import Sequence

import numpy as np

from motofmi.recordings.recording import Recording

MARGIN = 1.0  # s left out at both sides of an excluded interval
MOVING = 0.8  # of the median speed: below it, the vehicle starts or stops
WILD = 3.0  # times the 99.5 % quantile of a channel: larger values are outliers


def undisturbed(recording: Recording, over: str, channels: Sequence[str]) -> tuple[list[tuple[int, int]], str]:
    """The intervals [first, last) of samples without gaps, and a phrase on what was excluded."""
    speed = recording[over]
    usual = np.median(speed[speed > 0.1 * speed.max()])
    good = speed > MOVING * usual
    stopped = np.count_nonzero(~good)
    for name in channels:
        values = recording[name]
        centred = np.abs(values - np.median(values[good]))
        good &= centred <= WILD * max(np.quantile(centred[good], 0.995), 1e-9)
    wild = np.count_nonzero(~good) - stopped
    said = (f"{stopped} samples below {MOVING:.0%} of the usual {over} and {wild} outliers (beyond {WILD:g} times the "
            "99.5 % quantile of a channel)")  # fmt: skip
    return uninterrupted(good & ~recording.broken, int(MARGIN * recording.rate)), said


def uninterrupted(good: np.ndarray, margin: int) -> list[tuple[int, int]]:
    """The intervals [first, last) of good samples (n,), without a margin at both sides."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], good.astype(int), [0]])))
    return [
        (int(a) + margin, int(b) - margin) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a > 2 * margin
    ]
