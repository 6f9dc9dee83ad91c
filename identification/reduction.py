"""A fast recording reduced to fewer samples, piece by piece, so that it never is in memory as a whole.

All columns, the time among them, pass the same linear-phase low-pass filter, so nothing is shifted against
anything; then every k-th sample is kept.
"""

from collections.abc import Iterator
from itertools import chain

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.signal import firwin

from fmus.errors import InputError
from identification.time_stamps import interval


def reduced(chunks: Iterator[np.ndarray], rate: float, headers: list[str], time: str = "time") -> tuple[np.ndarray, tuple[str, ...]]:
    """The rows (n, columns) of all chunks at about `rate` [Hz], not below it, and a note on what was done.

    Raises InputError without a time column, and for a rate that is not positive.
    """
    if not rate > 0:
        raise InputError(f"rate = {rate:g} Hz; expected a positive sampling rate")
    first = next(chunks)
    times = [i for i, name in enumerate(headers) if name.split("[")[0].strip() == time]
    if not times:
        raise InputError(f"reducing to {rate:g} Hz needs a column '{time} [s]' (columns there: {', '.join(headers)}); map one with --map COLUMN=time")
    given = 1 / (interval(first[:, times[0]]) or np.inf)
    factor = int(given / rate * (1 + 1e-6))
    if factor < 2:
        return np.concatenate([first, *chunks]), ()
    taps = firwin(20 * factor + 1, 1 / factor)
    kept, rest = [first[:0]], first[:0]
    for chunk in chain([first], chunks):
        rows = np.concatenate([rest, chunk])
        if len(rows) < len(taps):
            rest = rows
            continue
        windows = sliding_window_view(rows, len(taps), axis=0)[::factor]
        kept.append(windows @ taps)
        rest = rows[len(windows) * factor :]
    note = f"reduced from {given:.6g} Hz to {given / factor:.6g} Hz while reading: low-pass filtered, every {factor}th sample kept"
    return np.concatenate(kept), (note,)
