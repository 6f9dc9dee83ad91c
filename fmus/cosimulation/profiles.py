"""External inputs over time, as a speed or a disturbance; linear between the given points.

Columns are named after inputs. A heading with a unit, `speed [km/h]`, is converted to the unit of the input; without
one the numbers are in the unit of the input.
"""

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fmus.cosimulation.network import Network
from fmus.declaration.units import unit
from fmus.support.errors import InputError, unknown


@dataclass(frozen=True)
class Profile:
    """constant (nu,) for all inputs of a network; of those in `moving` values (n, m) at times (n,) [s]."""

    constant_values: np.ndarray
    times: np.ndarray
    moving: np.ndarray
    values: np.ndarray

    @classmethod
    def constant(cls, network: Network) -> "Profile":
        """Every input that is not driven keeps its present value."""
        return cls.over_time(network, np.zeros(1), {})

    @classmethod
    def over_time(cls, network: Network, times: np.ndarray, columns: Mapping[str, np.ndarray],
                  units: Mapping[str, str] | None = None) -> "Profile":  # fmt: skip
        """Columns (n,) by the name of an input, with or without its subsystem's name, at ascending times (n,) [s].

        units are those of columns, where they are not those of the inputs. Raises InputError for a name that is no free
        input, times that do not ascend, and a unit that cannot be converted to that of the input.
        """
        free = [name for name in network.inputs if name not in network.wiring]
        if not (np.diff(times) > 0).all():
            raise InputError("the times of the inputs must ascend")
        places = []
        for name in columns:
            matching = [f for f in free if f == name or f.partition(".")[2] == name]
            if len(matching) != 1:
                raise unknown("input", name, free)
            places.append(network.inputs.index(matching[0]))
        wanted = {name: network.unit_of(network.inputs[place]) for name, place in zip(columns, places, strict=True)}
        converted = [
            values * _factor(units[name], wanted[name], name) if units and name in units else values
            for name, values in columns.items()
        ]
        values = np.column_stack(converted) if columns else np.zeros((len(times), 0))
        return cls(network.external[0].copy(), times, np.array(places, int), values)

    def uncovered(self, begin: float, end: float) -> tuple[str, ...]:
        """A sentence where a run from `begin` to `end` [s] begins before the inputs or ends after them.

        Raises InputError where run and inputs have no time in common.
        """
        if not len(self.moving) or len(self.times) < 2:
            return ()
        first, last = float(self.times[0]), float(self.times[-1])
        given = f"the inputs are given from {first:g} to {last:g} s, the run is from {begin:g} to {end:g} s"
        if last <= begin or first >= end:
            raise InputError(f"{given}: shift the times of the inputs, or give a start and a duration within them")
        rounding = 1e-6 * (end - begin)
        covered = first <= begin + rounding and last >= end - rounding
        return () if covered else (f"{given}; outside of their times they keep their first and last values",)

    def at(self, times: np.ndarray) -> np.ndarray:
        """All external inputs (n, nu) at times (n,); zero where an output drives the input. Read-only."""
        if not len(self.moving):
            return np.broadcast_to(self.constant_values, (len(times), len(self.constant_values)))
        inputs = np.tile(self.constant_values, (len(times), 1))
        for k, place in enumerate(self.moving):
            inputs[:, place] = np.interp(times, self.times, self.values[:, k])
        return inputs


def _factor(given: str, wanted: str, name: str) -> float:
    """From the unit of a column to that of the input; 1 where the unit of the input is unknown."""
    try:
        return unit(given).to(unit(wanted)) if wanted else 1.0
    except InputError as error:
        raise InputError(f"the column {name} of the inputs: {error}") from None


def split_units(columns: Mapping[str, np.ndarray]) -> tuple[np.ndarray, dict[str, np.ndarray], dict[str, str]]:
    """Times (n,) [s], columns by name, and the units of those whose heading states one.

    Raises InputError for columns without a `time`, and for an unknown unit.
    """
    parts = {title: title.partition("[") for title in columns}
    units = {name.strip(): stated.rstrip("] ") for name, bracket, stated in parts.values() if bracket}
    found = {parts[title][0].strip(): values for title, values in columns.items()}
    for stated in units.values():
        unit(stated)
    if "time" not in found:
        raise unknown("column", "time", found)
    return found.pop("time") * unit(units.pop("time", "s")).to(unit("s")), found, units


def read_profile(path: str | Path) -> tuple[np.ndarray, dict[str, np.ndarray], dict[str, str]]:
    """Times (n,) [s], columns by name, and units by name, from a CSV file with a header.

    Columns are separated by commas, or by semicolons where the header has no comma; the decimal sign is then a point or
    a comma.

    Raises InputError for a file without a column `time`, with a value that is not a number, or that cannot be read.
    """
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            lines = file.read().splitlines()
        first = next((line for line in lines if line.strip()), "")
        semicolons = ";" in first and "," not in first
        header, *rows = [row for row in csv.reader(lines, delimiter=";" if semicolons else ",") if row]
    except (OSError, ValueError, UnicodeDecodeError) as error:
        raise InputError(
            f"cannot read inputs from {path}: {getattr(error, 'strerror', None) or 'it has no header and rows'}"
        ) from None
    try:
        if semicolons:
            rows = [[cell.replace(",", ".") for cell in row] for row in rows]
        table = np.array(rows, float).reshape(len(rows), len(header))
    except ValueError:
        raise InputError(
            f"{path}: every row needs {len(header)} numbers, one for each of {', '.join(header)}"
        ) from None
    if not rows or not np.isfinite(table).all():
        raise InputError(f"{path}: needs rows of finite numbers below its header")
    return split_units(dict(zip(header, table.T, strict=True)))
