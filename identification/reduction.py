"""A fast recording reduced to fewer samples, piece by piece, so that it never is in memory as a whole.

All columns, the time among them, pass the same linear-phase low-pass filter, so nothing is shifted against
anything; then every k-th sample is kept.
"""

from collections.abc import Iterator
from itertools import chain

import numpy as np
from scipy.signal import firwin, lfilter

from fmus.errors import InputError


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
    given = 1 / np.median(np.diff(first[:, times[0]]))
    factor = int(given / rate * (1 + 1e-6))
    if factor < 2:
        return np.concatenate([first, *chunks]), ()
    taps = firwin(20 * factor + 1, 1 / factor)
    state = np.zeros((len(taps) - 1, first.shape[1]))
    kept, seen = [], 0
    for chunk in chain([first], chunks):
        filtered, state = lfilter(taps, 1.0, chunk, axis=0, zi=state)
        rows = np.arange(seen, seen + len(chunk))
        kept.append(filtered[(rows >= len(taps) - 1) & (rows % factor == 0)])
        seen += len(chunk)
    note = f"reduced from {given:.6g} Hz to {given / factor:.6g} Hz while reading: low-pass filtered, every {factor}th sample kept"
    return np.concatenate(kept), (note,)
