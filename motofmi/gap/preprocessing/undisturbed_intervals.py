"""Where in a recording a vehicle rides undisturbed: neither starts, stops nor falls, and no channel is wild."""

from collections.abc import Sequence

import numpy as np

from identification.recordings import Recording

MARGIN = 1.0  # s left out at both sides of what is cut
MOVING = 0.8  # of the usual input over which the component is seen: below, it starts or stops
WILD = 3.0  # times the 99.5 % quantile of a channel: no motion of the vehicle


def undisturbed(recording: Recording, over: str, channels: Sequence[str]) -> tuple[list[tuple[int, int]], str]:
    """The stretches [first, last) of samples without gaps, and a sentence's part on what was cut."""
    speed = recording[over]
    usual = np.median(speed[speed > 0.1 * speed.max()])
    good = speed > MOVING * usual
    stopped = np.count_nonzero(~good)
    for name in channels:
        values = recording[name]
        centred = np.abs(values - np.median(values[good]))
        good &= centred <= WILD * max(np.quantile(centred[good], 0.995), 1e-9)
    wild = np.count_nonzero(~good) - stopped
    said = (f"{stopped} samples below {MOVING:.0%} of the usual {over} and {wild} wild ones (beyond {WILD:g} times the 99.5 % quantile of a channel)")  # fmt: skip
    return unbroken(good & ~recording.broken, int(MARGIN * recording.rate)), said


def unbroken(good: np.ndarray, margin: int) -> list[tuple[int, int]]:
    """The stretches [first, last) of good samples (n,), without a margin at both sides."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], good.astype(int), [0]])))
    return [(int(a) + margin, int(b) - margin) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a > 2 * margin]
