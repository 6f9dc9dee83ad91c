"""Reduction of a recording to a lower sampling rate while it is read, block by block, to limit the memory.

All columns, the time among them, pass the same linear-phase low-pass filter, so no column is delayed against
another; then every k-th sample is kept. Between samples that are further apart than usual, but within an interval of
the reduced rate, the columns are interpolated linearly. Other samples are missing, and so are filtered samples with a
missing one in the filter's length.
"""

from collections.abc import Iterator
from itertools import chain

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from fmus.support.errors import InputError
from motofmi.recordings.time_stamps import LATE_STAMPS, coarse, interval

PERIODS = 20  # length of the filter, in sampling intervals of the reduced rate


def reduced(
    blocks: Iterator[np.ndarray], rate: float, time: int, second: float = 1.0
) -> tuple[np.ndarray, tuple[str, ...]]:
    """The rows (n, columns) of all blocks at about `rate` [Hz], not below it, and a note on what was done; time
    is its column's place, and second is how many of its units are a second.

    NaN is a missing value, there and in the result. Raises InputError for a rate that is not positive, and where no
    stretch between missing samples is as long as the filter.
    """
    if not rate > 0:
        raise InputError(f"rate = {rate:g} Hz; expected a positive sampling rate")
    first = next(blocks)
    stamps = first[np.isfinite(first[:, time]), time]
    step = interval(stamps) if len(stamps) > 1 else 0.0
    given = second / (step or np.inf)
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
            rows = _with_missing_rows(rows[np.isfinite(rows[:, time])], step, time, factor * step)
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
    result = np.concatenate(kept)
    if len(result) and not np.any(np.isfinite(np.delete(result, time, axis=1))):
        steps = np.diff(stamps) / second
        raise InputError(
            f"no {PERIODS / rate:.3g} s without a missing sample, as a reduction to {rate:g} Hz needs: the time stamps "
            f"step by {steps.min():.3g} to {steps.max():.3g} s, {np.median(steps):.3g} s in the median. {LATE_STAMPS}"
        )
    return result, (note,)


def _with_missing_rows(rows: np.ndarray, step: float, time: int, longest: float) -> np.ndarray:
    """The rows with a further row for every sample at an interval `step` that is missing.

    Its time is interpolated, and so are its other values where the samples beside it are at most `longest` apart; all
    others are NaN. step and longest are in the unit of the time.
    """
    apart = np.diff(rows[:, time])
    missing = np.maximum(np.round(apart / step).astype(int) - 1, 0)
    if not np.any(missing):
        return rows
    of_row = np.repeat(np.arange(len(missing)), missing)
    share = (np.arange(len(of_row)) - np.repeat(np.cumsum(missing) - missing, missing) + 1) / (missing[of_row] + 1)
    between = rows[of_row] + share[:, None] * (rows[of_row + 1] - rows[of_row])
    unknown = apart[of_row] > longest * (1 + 1e-6)
    between[np.ix_(unknown, np.arange(rows.shape[1]) != time)] = np.nan
    return np.insert(rows, of_row + 1, between, axis=0)
