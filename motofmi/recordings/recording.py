"""One recorded run: its time, its channels in SI, and warnings about them."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from fmus.declaration.units import DISPLAY, convert
from fmus.support.errors import InputError, unknown
from fmus.support.notebook import html, new_axes
from motofmi.recordings.channels import CHANNELS, TIME, UNITS
from motofmi.recordings.time_stamps import interval


@dataclass(frozen=True, repr=False)
class Recording:
    """One run: time (n,) [s] and named columns (n,) in SI, their units, and warnings about them.

    gaps are the last recorded times before, and the first after, stretches [s] that are bridged but were not recorded;
    bridged are the same of stretches so short that a spline bridges them. headings are the names in the file of the
    columns that have another name here, negated those whose sign was reversed, and converted those with another unit in
    the file. unread are columns of the file without a unit, which are not in `columns`, and joined are the names of the
    runs of which this one was made. rig is the content of `rig.json`, file the name and path the path of the file that
    the run was read from.

        run = read_recording("sweep.csv")
        run["steer_torque"], run.units["steer_torque"], run.warnings
    """

    name: str
    time: np.ndarray
    columns: dict[str, np.ndarray]
    units: dict[str, str]
    warnings: tuple[str, ...] = ()
    rig: dict[str, Any] = field(default_factory=dict)
    gaps: tuple[tuple[float, float], ...] = ()
    file: str = ""
    bridged: tuple[tuple[float, float], ...] = ()
    headings: dict[str, str] = field(default_factory=dict)
    negated: frozenset[str] = frozenset()
    converted: frozenset[str] = frozenset()
    unread: tuple[str, ...] = ()
    joined: tuple[str, ...] = ()
    path: Path | None = None

    @cached_property
    def rate(self) -> float:
        """Samples per second [Hz], which neither gaps nor rounded time stamps move; infinite where all
        stamps are the same."""
        step = interval(self.time)
        return 1 / step if step else np.inf

    @cached_property
    def broken(self) -> np.ndarray:
        """Which samples (n,) lie in a gap."""
        return self.within(self.gaps)

    def within(self, intervals: Iterable[tuple[float, float]]) -> np.ndarray:
        """Which samples (n,) lie between the two times of any of the intervals [s]."""
        inside = np.zeros(len(self.time), bool)
        for begin, end in intervals:
            inside |= (begin < self.time) & (self.time < end)
        return inside

    @cached_property
    def stretches(self) -> tuple[slice, ...]:
        """The samples without gaps, in one slice for each stretch."""
        edges = np.flatnonzero(np.diff(np.concatenate([[True], self.broken, [True]])))
        return tuple(slice(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True))

    def option(self, column: str, unit: str = "") -> str:
        """The `--map` option that gives a column another unit; without a unit, the one that reverses its sign."""
        target = f"{column} [{unit}]" if unit else column if column in self.negated else f"-{column}"
        return f'--map "{self.headings.get(column, column)}={target}"'

    def parts(self, column: str) -> list[np.ndarray]:
        """The values of a column in each stretch without gaps."""
        return [self[column][stretch] for stretch in self.stretches]

    def from_zero(self) -> "Recording":
        """The recording with its first sample at time zero."""
        first = float(self.time[0])
        gaps, bridged = (tuple((a - first, b - first) for a, b in each) for each in (self.gaps, self.bridged))
        return replace(self, time=self.time - first, gaps=gaps, bridged=bridged)

    def __getitem__(self, column: str) -> np.ndarray:
        """The values (n,) of a column. Raises InputError for a column that is not there, with how to map one."""
        if column in self.columns:
            return self.columns[column]
        there = f"recording {self.file or self.name}"
        if column not in UNITS:
            raise unknown(f"column of {there}", column, self.columns)
        raise InputError(f"{there} has no column {column!r} (columns there: {', '.join(self.columns) or 'none'}); if "
                         f"one of the file's columns is the {column.replace('_', ' ')}, add --map \"COLUMN={column} "
                         f"[{UNITS[column]}]\"")  # fmt: skip

    def __repr__(self) -> str:
        duration = float(np.ptp(self.time)) if len(self.time) else 0.0
        doubts = f", {len(self.warnings)} warning{'s' if len(self.warnings) > 1 else ''}" if self.warnings else ""
        return (
            f"Recording({self.name!r}: {', '.join(self.columns)}; {len(self.time)} samples, {duration:.4g} s at "
            f"{self.rate:.4g} Hz{doubts})"
        )

    def _repr_html_(self) -> str:
        rows = [
            (
                name,
                self.units[name],
                f"{y.min():.4g}",
                f"{y.max():.4g}",
                CHANNELS[name].meaning if name in CHANNELS else "",
            )
            for name, y in self.columns.items()
        ]
        first = next(iter(self.columns), None)
        draw = None if first is None else lambda axes: self._draw(axes, first)
        return html(
            ". ".join([repr(self), *self.warnings]), ("channel", "unit", "minimum", "maximum", "meaning"), rows, draw
        )

    def plot(self, axes: Any = None) -> Any:
        """Every channel over time on axes of matplotlib, one below the other, which are returned; gaps are shaded."""
        axes = (
            new_axes(len(self.columns), sharex=True, squeeze=False, figsize=(8.0, 1.0 + 1.6 * len(self.columns)))[:, 0]
            if axes is None
            else axes
        )
        for one, name in zip(np.atleast_1d(axes), self.columns, strict=True):
            self._draw(one, name)
            one.set_xlabel("")
        np.atleast_1d(axes)[-1].set_xlabel("time [s]")
        return axes

    def _draw(self, axes: Any, name: str) -> None:
        shown = DISPLAY.get(self.units[name], self.units[name])
        axes.plot(self.time, convert(1.0, self.units[name], shown) * self.columns[name], linewidth=0.6)
        for begin, end in self.gaps:
            axes.axvspan(begin, end, color="#f4d6d6", zorder=0)
        axes.set(xlabel="time [s]", ylabel=f"{name.replace('_', ' ')}\n[{shown}]")

    def to_dataframe(self) -> Any:
        """Channels by time (pandas.DataFrame with the index `time` in s); `attrs` has the units by
        channel and the warnings."""
        import pandas as pd  # noqa: PLC0415 - imported on use

        frame = pd.DataFrame(dict(self.columns), index=pd.Index(self.time, name=TIME))
        frame.attrs |= {"name": self.name, "units": {TIME: UNITS[TIME], **self.units}, "warnings": list(self.warnings)}
        return frame
