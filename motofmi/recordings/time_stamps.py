"""Time stamps as loggers write them: rounded, late by a little, or coarser than the sampling."""

import numpy as np

EQUAL = 1e-3  # relative to the rounding: steps with a smaller difference are equal
LATE_STAMPS = (
    "If the samples were taken at a regular rate and only their time stamps are late, leave out the column of the time "
    '(--map time=unused) and give the rate in rig.json beside the file: {"sampling": {"value": 100, "unit": "Hz"}}'
)
ENOUGH = 20  # least number of long steps, and of short ones, to distinguish rounding from missing samples


def interval(time: np.ndarray) -> float:
    """The sampling interval [s] of stamps (n,), 0 where most are the same.

    It is the mean of the steps near their median, which leaves gaps out. The median itself is one of the roundings: at
    256 Hz stamps in milliseconds step by 4 or 3, and 4 is 2.4 % off.
    """
    if coarse(time):
        return float(np.ptp(time) / (len(time) - 1))
    steps = np.diff(time)
    near = steps[_near(steps)]
    return float(near.mean()) if len(near) else 0.0


def complete(time: np.ndarray) -> bool:
    """Whether by the time stamps (n,) no sample is missing and none is written twice."""
    if coarse(time) or np.all(_near(np.diff(time))):
        return True
    taken = places(time)
    return taken is not None and int(taken[-1]) == len(time) - 1


def places(time: np.ndarray) -> np.ndarray | None:
    """The places (n,) of samples on a regular grid, by increasing stamps (n,); None where the stamps are of no such
    grid.

    On the grid of a clock each sample has a place of its own, and places that stay empty are missing samples. Stamps
    whose steps vary at random move away from every grid, so that two samples come to one place: they jitter, which
    says nothing of missing samples. The one parameter is the interval of the grid.
    """
    step = interval(time)
    phase = (time - time[0]) / step
    middle = np.angle(np.mean(np.exp(2j * np.pi * phase))) / (2 * np.pi)
    found = np.round(phase - middle).astype(int)
    return found - found[0] if np.all(np.diff(found) >= 1) else None


def regular_grid(time: np.ndarray, taken: np.ndarray) -> np.ndarray:
    """The times [s] of all samples on a regular grid, missing ones included, by stamps (n,) and their places (n,).

    The grid is the line by least squares through stamps over places. Its interval has a standard error of
    sqrt(12 / n^3) of the jitter of a stamp; the mean step, of the two ends alone, has sqrt(2) / n, which over a
    recording of some thousand samples is a time error as large as the jitter itself.
    """
    middle = taken.mean()
    step = float((taken - middle) @ (time - time.mean()) / np.sum((taken - middle) ** 2))
    return time.mean() + step * (np.arange(int(taken[-1]) + 1) - middle)


def holes(time: np.ndarray, longest: float) -> np.ndarray:
    """The samples (m,) after which more than `longest` intervals pass until the next, by stamps (n,)."""
    return np.flatnonzero(np.diff(time) > longest * interval(time))


def coarse(time: np.ndarray) -> bool:
    """Whether stamps (n,) are those of a regular grid, rounded to more than half of its interval.

    There are steps of two lengths then, which differ by the rounding, and no stamp is further from the grid than that.
    Missing samples add up. With a fixed number of significant digits the rounding grows with the time, and there are
    steps of several lengths: where stamps repeat the one before, none may be further from the grid than from the next
    other ones.
    """
    steps = np.diff(time)
    if np.all(_near(steps)):
        return False
    rounding = float(np.ptp(steps))
    long, short = (np.count_nonzero(np.abs(steps - end) < EQUAL * rounding) for end in (steps.max(), steps.min()))
    off = np.abs(time - np.linspace(time[0], time[-1], len(time)))
    if rounding > 0 and np.count_nonzero(steps == 0) >= ENOUGH:
        different, stamp = np.unique(time, return_inverse=True)
        apart = np.diff(different)
        return bool(np.all(off < (1 + EQUAL) * np.maximum(np.append(apart, 0), np.append(0, apart))[stamp]))
    return bool(min(long, short) >= ENOUGH and long + short == len(steps) and off.max() < (1 + EQUAL) * rounding)


def _near(steps: np.ndarray) -> np.ndarray:
    """Which steps (n,) are near their median."""
    usual = np.median(steps)
    return np.abs(steps - usual) < 0.5 * usual
