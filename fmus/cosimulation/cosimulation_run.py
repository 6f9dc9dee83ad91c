"""The result of a co-simulation: its rows by name, its predicted errors, its residual power, as tables and figures."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fmus.cosimulation.coupling_error import Prediction
from fmus.cosimulation.power_bonds import PowerBond
from fmus.cosimulation.results import Rows, heading
from fmus.support.errors import unknown
from fmus.support.notebook import html, new_axes

TIME = "time"


@dataclass(frozen=True, repr=False)
class CosimulationRun:
    """A finished co-simulation: `run["vehicle.steer_angle"]` is a column (n,) over `run["time"]` in s.

    columns are the names with their units, `vehicle.steer_angle [rad]`. rows (n, columns) is empty where they went to
    the file at `path`; a column is then read from there. step [s] is the first step, steps their number, shortest and
    longest [s] the extremes. predicted holds the eigenvalues of the coupled simulation beside the exact ones; it is
    None where a subsystem cannot be linearised, and then meets_tolerance, too. meets_tolerance says whether every
    mode's error is within the tolerance; where not, advice is one sentence with a coupling or a step that meets it.
    notes are sentences on a run of a single FMU: an end that the FMU asked for, variables without a column.

        >>> run = mf.simulate("damper:7.5", inputs={"time": [0, 1], "steer_rate": [1, 1]}, step=0.01, duration=0.1)
        >>> run.keys()[-1], run.units["damper_7_5.handlebar_torque"]
        ('damper_7_5.frame_torque', 'N.m')
        >>> float(run["damper_7_5.handlebar_torque"][-1])
        -7.5
        >>> run.table().shape, run.power_residual, run.to_xarray().time.units
        ((11, 6), 0.0, 's')
        >>> run.save("run.csv").name, run.to_dataframe().columns[0]
        ('run.csv', 'time [s]')
        >>> axes = run.plot("damper_7_5.handlebar_torque")
    """

    step: float
    coupling: str
    columns: tuple[str, ...]
    rows: np.ndarray
    path: Path | None
    steps_per_second: float
    predicted: Prediction | None
    power_bonds: list[PowerBond]
    steps: int
    shortest: float
    longest: float
    meets_tolerance: bool | None = None
    advice: str | None = None
    notes: tuple[str, ...] = ()

    @property
    def units(self) -> dict[str, str]:
        """The unit of measure of each column by its name, `time` first."""
        return {name: unit.removesuffix("]") for name, _, unit in (column.partition(" [") for column in self.columns)}

    @property
    def power_residual(self) -> float:
        """The largest residual power at any bond [W]."""
        return max((bond.power for bond in self.power_bonds), default=0.0)

    def table(self) -> np.ndarray:
        """The rows (n, columns), read from the file where they went to one."""
        return self.rows if self.path is None else np.loadtxt(self.path, delimiter=",", skiprows=1, ndmin=2)

    def __getitem__(self, column: str) -> np.ndarray:
        """A column (n,) by its name without the unit. Raises InputError with the valid names for any other."""
        names = list(self.units)
        if column not in names:
            raise unknown("column", column, names)
        return self.table()[:, names.index(column)]

    def keys(self) -> list[str]:
        """The names of the columns, `time` first."""
        return list(self.units)

    def __iter__(self) -> Iterator[str]:
        return iter(self.units)

    def __contains__(self, column: object) -> bool:
        return column in self.units

    def __len__(self) -> int:
        return len(self.columns)

    @property
    def _summary(self) -> str:
        tolerance = {True: ", within the tolerance", False: ", beyond the tolerance", None: ""}[self.meets_tolerance]
        return (
            f"{self.steps} steps of {self.step:g} s, coupling {self.coupling}{tolerance}, {len(self.columns) - 1} "
            "signals"
        )

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self._summary}{f', rows in {self.path}' if self.path else ''}>"

    def _repr_html_(self) -> str:
        drawn = self._by_unit(())
        ends = [
            (name, values[0], values[-1], unit)
            for (name, unit), values in zip(self.units.items(), self.table().T, strict=True)
            if name != TIME
        ]
        rows = [(name, unit, f"{first:.5g}", f"{last:.5g}") for name, first, last, unit in ends]
        return html(
            self._summary,
            ("signal", "unit", "first", "last"),
            rows,
            (lambda axes: self._draw(axes, *next(iter(drawn.items())))) if drawn else None,
        )

    def plot(self, *names: str, axes: Any = None) -> Any:
        """Columns over time, one below the other for each unit of measure; all columns without names.

        Returns the array of axes of matplotlib; `axes` takes a column on axes that exist, for columns of one unit.
        Raises InputError for an unknown name.
        """
        groups = self._by_unit(names)
        every = np.atleast_1d(
            new_axes(max(len(groups), 1), 1, sharex=True, figsize=(7.0, 1.0 + 1.8 * max(len(groups), 1)))
            if axes is None
            else axes
        )
        for one, (unit, group) in zip(every, groups.items(), strict=True):
            self._draw(one, unit, group)
        return every

    def _by_unit(self, names: tuple[str, ...]) -> dict[str, list[str]]:
        units = self.units
        groups: dict[str, list[str]] = {}
        for name in names or [n for n in units if n != TIME]:
            if name not in units:
                raise unknown("column", name, units)
            groups.setdefault(units[name], []).append(name)
        return groups

    def _draw(self, axes: Any, unit: str, names: list[str]) -> None:
        columns, table = list(self.units), self.table()
        for name in names:
            axes.plot(table[:, 0], table[:, columns.index(name)], linewidth=1.0, label=name)
        axes.set(
            xlabel="time [s]",
            ylabel=heading("" if len(names) > 1 else names[0].partition(".")[2].replace("_", " "), unit).strip(),
        )
        axes.legend(fontsize="small")

    def save(self, path: str | Path) -> Path:
        """Write the rows as a CSV file; its path. Raises InputError where it cannot be written."""
        rows = Rows(self.columns, path)
        rows.write(self.table())
        rows.close()
        return Path(path)

    def to_dataframe(self) -> Any:
        """The rows with the columns of the CSV file, `time [s]` the first (pandas.DataFrame)."""
        import pandas as pd  # noqa: PLC0415 - imported on use

        return pd.DataFrame(self.table(), columns=list(self.columns))

    def to_xarray(self) -> Any:
        """Every signal over the coordinate `time` [s] (xarray.Dataset), units as attributes."""
        import xarray as xr  # noqa: PLC0415 - imported on use

        table, units = self.table(), self.units
        signals = {
            name: (TIME, table[:, k], {"units": unit}) for k, (name, unit) in enumerate(units.items()) if name != TIME
        }
        return xr.Dataset(signals, {TIME: (TIME, table[:, 0], {"units": units[TIME]})})
