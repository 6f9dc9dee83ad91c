"""Short recordings in one: a step response that ends with the travel of a slide has some hundred samples, too few for
an estimate of its noise.

In the joined recording each is a stretch of its own between gaps. It has initial states of its own, and nothing is
compared in the gaps.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from motofmi.recordings.quality import channel_warnings
from motofmi.recordings.recording import Recording
from motofmi.recordings.resampling import uniform
from motofmi.recordings.time_stamps import interval

SAME_INTERVAL = 0.05  # relative difference of sampling intervals up to which recordings are joined
ROUNDING = 1e-9  # relative, of sums of intervals


def with_short_joined(recordings: Sequence[Recording], fewest: int) -> tuple[list[Recording], tuple[str, ...]]:
    """The recordings, those with the sampling interval of one that has fewer than `fewest` samples joined into one, and
    what was done.

    Recordings without others of their interval and their columns stay as they are.

        runs, notes = with_short_joined([read_recording(path) for path in steps], 200)
    """
    short = [r for r in recordings if len(r.time) < fewest]
    alike = [r for r in recordings if short and _alike(r, short[0])]
    if len(alike) < 2:
        return list(recordings), ()
    note = (
        f"{', '.join(r.name for r in alike)}: joined into one recording, since some have fewer than {fewest} samples; "
        "each has initial states of its own"
    )
    others = [r for r in recordings if not any(r is each for each in alike)]
    return [_joined(alike), *others], (note,)


def _alike(one: Recording, other: Recording) -> bool:
    """Whether two recordings have the same columns and nearly the same sampling interval."""
    intervals = interval(one.time), interval(other.time)
    return set(one.columns) == set(other.columns) and abs(intervals[0] - intervals[1]) <= SAME_INTERVAL * intervals[1]


def _joined(recordings: Sequence[Recording]) -> Recording:
    """Recordings one after the other on one regular grid, with gaps of their mean duration.

    Each begins on the grid, so that its first sample, from which on it moves, is kept.
    """
    made = [uniform(recording, bridged=1.0) for recording in recordings]
    regular = [recording for recording, _ in made]
    step = float(np.mean([interval(r.time) for r in regular]))
    pause = max(round(float(np.mean([np.ptp(r.time) for r in regular])) / step), 1)
    counts = [int(np.ptp(r.time) / step * (1 + ROUNDING)) + 1 for r in regular]
    firsts = np.cumsum([0, *(count - 1 + pause for count in counts[:-1])]).tolist()
    time = step * np.arange(firsts[-1] + counts[-1])
    taken = np.concatenate([first + np.arange(count) for first, count in zip(firsts, counts, strict=True)])
    columns: dict[str, np.ndarray] = {}
    for name in recordings[0].columns:
        parts = [
            CubicSpline(r.time - r.time[0], r[name])(step * np.arange(count))
            for r, count in zip(regular, counts, strict=True)
        ]
        columns[name] = np.interp(time, time[taken], np.concatenate(parts))
    ends = [first + count - 1 for first, count in zip(firsts, counts, strict=True)]
    gaps = [(float(time[last]), float(time[first])) for last, first in zip(ends[:-1], firsts[1:], strict=True)]
    bridged: list[tuple[float, float]] = []
    for r, first in zip(regular, firsts, strict=True):
        shift = float(time[first] - r.time[0])
        gaps += [(a + shift, b + shift) for a, b in r.gaps]
        bridged += [(a + shift, b + shift) for a, b in r.bridged]
    others = "1 other" if len(recordings) == 2 else f"{len(recordings) - 1} others"
    return replace(
        recordings[0],
        name=f"{recordings[0].name} and {others}",
        time=time,
        columns=columns,
        warnings=(*_warnings(recordings), *(note for _, notes in made for note in notes)),
        gaps=tuple(sorted(gaps)),
        bridged=tuple(bridged),
        joined=tuple(r.name for r in recordings),
        path=None,
    )


def _warnings(recordings: Sequence[Recording]) -> list[str]:
    """The warnings about the recordings, without those about columns that are constant in one: an input may differ from
    one recording to the next."""
    every = []
    for recording in recordings:
        constant = {name: values for name, values in recording.columns.items() if np.ptp(values) == 0}
        left_out = channel_warnings(recording.time, constant, recording.units)
        every += [f"{recording.name}: {warning}" for warning in recording.warnings if warning not in left_out]
    return every
