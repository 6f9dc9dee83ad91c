"""Reduction of a recording to a lower sampling rate while it is read, block by block, to limit the memory.

All columns, the time among them, pass the same linear-phase low-pass filter, so no column is delayed against
another; then every k-th sample is kept. Filtered samples with a missing sample in the filter's length are missing.
"""

from collections.abc import Iterator
from itertools import chain

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from fmus.support.errors import InputError
from motofmi.recordings.time_stamps import coarse, interval

PERIODS = 20  # length of the filter, in sampling intervals of the reduced rate


def reduced(blocks: Iterator[np.ndarray], rate: float, time: int) -> tuple[np.ndarray, tuple[str, ...]]:
    """The rows (n, columns) of all blocks at about `rate` [Hz], not below it, and a note on what was done; time
    is its column's place.

    NaN is a missing value, there and in the result. Raises InputError for a rate that is not positive.
    """
    if not rate > 0:
        raise InputError(f"rate = {rate:g} Hz; expected a positive sampling rate")
    first = next(blocks)
    stamps = first[np.isfinite(first[:, time]), time]
    step = interval(stamps) if len(stamps) > 1 else 0.0
    given = 1 / (step or np.inf)
    factor = int(given / rate * (1 + 1e-6))
    if factor < 2:
        return np.concatenate([first, *blocks]), ()
    from scipy.signal import firwin  # noqa: PLC0415 - imported on use: it takes 0.5 s

    taps = firwin(PERIODS * factor + 1, 1 / factor)
    kept, rest = [first[:0]], first[:0]
    regular = not coarse(stamps)
    for block in chain([first], blocks):
        rows = np.concatenate([rest, block])
        if regular:
            rows = _with_missing_rows(rows[np.isfinite(rows[:, time])], step, time)
        if len(rows) < len(taps):
            rest = rows
            continue
        windows = sliding_window_view(rows, len(taps), axis=0)[::factor]
        kept.append(windows @ taps)
        rest = rows[len(windows) * factor :]
    note = (
        f"reduced from {given:.6g} Hz to {given / factor:.6g} Hz while reading: low-pass filtered, every {factor}th "
        f"sample kept; transitions shorter than {factor / given:.2g} s, such as dry friction through zero rate, "
        "appear wider"
    )
    return np.concatenate(kept), (note,)


def _with_missing_rows(rows: np.ndarray, step: float, time: int) -> np.ndarray:
    """The rows with a row of NaN, besides its time, for every sample [interval step, s] that is missing."""
    missing = np.round(np.diff(rows[:, time]) / step).astype(int) - 1
    if not np.any(missing > 0):
        return rows
    after = np.repeat(np.arange(len(missing)), np.maximum(missing, 0)) + 1
    filled = np.insert(rows, after, np.nan, axis=0)
    stamps = filled[:, time]
    unknown = np.isnan(stamps)
    stamps[unknown] = np.interp(np.flatnonzero(unknown), np.flatnonzero(~unknown), stamps[~unknown])
    return filled
