"""The intervals of a recording in which a vehicle neither starts, stops nor falls, and no channel has outliers."""

from collections.abc import Sequence

import numpy as np

from fmus.support.errors import InputError
from motofmi.recordings.recording import Recording

BLOCK, FEWEST_BLOCKS = 10.0, 2  # s, and the number of blocks that a run needs
MARGIN = 1.0  # s left out at both sides of an excluded interval
MOVING_SHARE = 0.8  # speed over the median speed below which the vehicle starts or stops
OUTLIER_FACTOR = 3.0  # an outlier's deviation from the median, over the 99.5 % quantile of the deviations in a channel


def undisturbed(recording: Recording, over: str, channels: Sequence[str]) -> tuple[list[tuple[int, int]], str]:
    """The intervals [first, last) of samples without gaps, and a phrase on the excluded samples for a note.

    over is the channel of the speed; channels are those that are searched for outliers.
    """
    speed = recording[over]
    usual = np.median(speed[speed > 0.1 * speed.max()])
    good = speed > MOVING_SHARE * usual
    stopped = np.count_nonzero(~good)
    for name in channels:
        values = recording[name]
        centred = np.abs(values - np.median(values[good]))
        good &= centred <= OUTLIER_FACTOR * max(np.quantile(centred[good], 0.995), 1e-9)
    outliers = np.count_nonzero(~good) - stopped
    excluded = (
        f"{stopped} samples below {MOVING_SHARE:.0%} of the usual {over} and {outliers} outliers "
        f"(beyond {OUTLIER_FACTOR:g} times the 99.5 % quantile of a channel)"
    )
    return uninterrupted(good & ~recording.broken, int(MARGIN * recording.rate)), excluded


def too_few_blocks(recording: Recording, blocks: int, excluded: str) -> InputError:
    """The error of a run with fewer than FEWEST_BLOCKS undisturbed blocks; excluded is the phrase of `undisturbed`."""
    return InputError(
        f"{recording.name}: {recording.time[-1] - recording.time[0]:.3g} s long, with {blocks} undisturbed blocks of "
        f"{BLOCK:g} s; expected at least {FEWEST_BLOCKS}. {excluded} are left out, with {MARGIN:g} s at both sides. Give "
        "longer runs; for a decay of a few seconds give its eigenvalues, in the columns speed, real and imag"
    )


def note_on_blocks(recording: Recording, blocks: int, excluded: str) -> str:
    """The note on how much of a run is compared; arguments as those of `too_few_blocks`."""
    return (
        f"{recording.name}: {blocks * BLOCK:g} of {len(recording.time) / recording.rate:.0f} s are compared: {excluded} are "
        f"left out, with {MARGIN:g} s at both sides, and so are incomplete blocks"
    )


def uninterrupted(good: np.ndarray, margin: int) -> list[tuple[int, int]]:
    """The intervals [first, last) of good samples (n,), without a margin of samples at both sides."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], good.astype(int), [0]])))
    return [
        (int(a) + margin, int(b) - margin) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a > 2 * margin
    ]
