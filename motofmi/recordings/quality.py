"""Checks of a recording: each fault is reported with its time and count; no value is changed."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from fmus.support.errors import InputError
from motofmi.recordings.channels import CHANNELS
from motofmi.recordings.time_stamps import coarse, interval

SETTLING = 50  # samples; channels that are constant for less may be the steps of a digital controller
MORE = 2.5  # by what factor a limit is held more often and for longer than other values


def complete_rows(time: np.ndarray, columns: Mapping[str, np.ndarray]) -> tuple[np.ndarray, list[str]]:
    """Which rows (n,) have the time and a value in every column, and warnings about the other rows, which count as
    missing."""
    complete, found = np.isfinite(time), []
    if not complete.all():
        found.append(
            f"{np.count_nonzero(~complete)} rows without a time are left out, first row {np.argmin(complete) + 1}"
        )
    for name, values in columns.items():
        known = np.isfinite(values)
        missing = time[~known & np.isfinite(time)]
        if len(missing):
            found.append(
                f"{name} has no value in {len(missing)} samples, from {missing[0]:g} s to {missing[-1]:g} s: they "
                "count as missing samples"
            )
        complete &= known
    return complete, found


def channel_errors(time: np.ndarray, columns: Mapping[str, np.ndarray], units: Mapping[str, str]) -> None:
    """Raises InputError where a column cannot be used at all: time that goes back, an essential
    channel that is constant."""
    back = np.flatnonzero(np.diff(time) < 0)
    if len(back):
        raise InputError(
            f"time goes back {len(back)} times, first from {time[back[0]]:g} s to {time[back[0] + 1]:g} s; one file is "
            "one run"
        )
    for name, values in columns.items():
        if name in CHANNELS and CHANNELS[name].essential and np.ptp(values) == 0:
            raise InputError(f"{name} is constant at {values[0]:g} {units[name]}; is the sensor connected?")


def sampling_warnings(time: np.ndarray) -> list[str]:
    """Duplicates, gaps with the number of samples dropped, and jitter."""
    steps, usual = np.diff(time), interval(time)
    found = []
    same = np.flatnonzero(steps == 0)
    if coarse(time):
        return [
            f"time stamps are coarse: they step by {steps.min():g} to {steps.max():g} s, where samples are {usual:.4g} "
            "s apart"
        ]
    if len(same):
        found.append(f"{len(same)} duplicate time stamps, first at {time[same[0]]:g} s")
    if usual == 0:  # most stamps are the same
        return found
    gaps = np.flatnonzero(steps > 1.5 * usual)
    if len(gaps):
        dropped = int(np.sum(np.round(steps[gaps] / usual) - 1))
        longest = gaps[np.argmax(steps[gaps])]
        found.append(
            f"{dropped} samples missing in {len(gaps)} gaps, first at {time[gaps[0]]:g} s, longest {steps[longest]:g} "
            f"s at {time[longest]:g} s"
        )
    regular = steps[(steps > 0) & (steps <= 1.5 * usual)]
    deviation = np.abs(regular - usual) / usual
    if len(regular) and np.sqrt(np.mean(deviation**2)) > 0.01:
        found.append(
            f"sampling jitter of {100 * np.sqrt(np.mean(deviation**2)):.1f} % of the interval (rms; largest "
            f"{100 * deviation.max():.0f} %)"
        )
    return found


def channel_warnings(time: np.ndarray, columns: Mapping[str, np.ndarray], units: Mapping[str, str]) -> list[str]:
    """Constant channels, clipping, and values outside the range of handlebar tests.

    A signal that is at one or the other of its limits most of the time is a command between two levels, not clipped.
    """
    found = []
    for name, values in columns.items():
        if np.ptp(values) == 0:
            found.append(f"{name} is constant at {values[0]:g} {units[name]}")
            continue
        limits = {side: clipped(sign * values) for side, sign in (("upper", 1.0), ("lower", -1.0))}
        switched = all(map(len, limits.values())) and sum(map(len, limits.values())) > len(values) / 2
        for side, at in limits.items():
            if len(at) and not switched and not is_steady(at, [y for other, y in columns.items() if other != name]):
                found.append(
                    f"{name} seems clipped at its {side} limit {values[at[0]]:g} {units[name]}: {len(at)} samples, "
                    f"first at {time[at[0]]:g} s"
                )
        largest = float(np.abs(values).max())
        if name in CHANNELS and largest > CHANNELS[name].largest:
            found.append(f"{name} reaches {largest:g} {units[name]}: are the channels swapped, or is its unit wrong?")
    return found


def rig_warnings(time: np.ndarray, rig: Mapping[str, Any]) -> list[str]:
    """A warning if the sampling rate differs from the one in rig.json."""
    stated = rig.get("sampling", {}).get("value")
    rate = 1 / max(interval(time), 1e-12)
    if stated and abs(rate / stated - 1) > 0.005:
        return [
            f"the time column says {rate:.6g} Hz, rig.json says {stated:g} Hz: with a wrong rate all frequencies are "
            "wrong"
        ]
    return []


def is_steady(at: np.ndarray, others: Sequence[np.ndarray]) -> bool:
    """Whether most of the samples (k,) at a limit are steady values: in the second half of a stretch over which all
    other channels (n,) are constant the channel is still there, where a motion beyond a limit would come back.

    The stretch is long, or the channel leaves the limit in the next one: during the steps of a digital controller it
    stays at a limit over several of them. Channels that never change are no evidence of a steady state.
    """
    varying = np.array([y for y in others if np.ptp(y) > 0])
    if not len(varying):
        return False
    changes = np.flatnonzero(np.any(np.diff(varying) != 0, axis=0)) + 1
    steady, following = 0, False
    for first, last in reversed(list(pairwise([0, *changes.tolist(), varying.shape[1]]))):
        inside = at[(at >= first) & (at < last)]
        stays = bool(np.count_nonzero(inside >= (first + last) / 2) > len(inside) / 2)
        steady += len(inside) if stays and (last - first >= SETTLING or not following) else 0
        following = stays
    return steady > len(at) / 2


def clipped(values: np.ndarray) -> np.ndarray:
    """Indices of samples held at the maximum by a limit.

    A saturated converter gives one value several times in a row, much more often than the values just below it and for
    longer than other values. At the peaks of a coarsely quantised sine the next levels occur as often, and a staircase
    stays at its other levels as long. The beginning and the end of a recording are no evidence of a limit, since a
    machine at rest may stay at the maximum there.
    """
    top, bottom = float(values.max()), float(values.min())
    lower = np.flatnonzero(values != top)
    if not len(lower):
        return np.array([], int)
    inside = values[lower[0] : lower[-1] + 1]
    span, held = top - bottom, inside == top
    levels = np.unique(inside[inside > top - 0.05 * span])
    step = float(levels[-1] - levels[-2]) if len(levels) > 1 else 0.0
    below = int(np.count_nonzero((inside < top) & (inside >= top - max(0.01 * span, 2.5 * step))))
    changed = np.flatnonzero(np.diff(inside)) + 1
    lengths, at_top = np.diff([0, *changed, len(inside)]), held[[0, *changed]]
    longest = lengths[at_top].max(initial=0)
    if longest < MORE * lengths[~at_top].mean() or np.count_nonzero(held) < MORE * max(below, 2):
        return np.array([], int)
    return np.flatnonzero(values == top)
