"""Recordings from files and into files. A column is used where it has a unit, or a name and a unit from the mapping:

    time [s], steer_angle [deg], steer_torque [N.m], steer_angle_command [deg]

Everything is SI from here on. One file is one run. Faults of the sampling are in `warnings`, with
the time and the count.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import psutil

from fmus.declaration.units import unit
from fmus.support.errors import InputError, unknown
from fmus.support.files import write_atomically
from motofmi.recordings.channels import CHANNELS, TIME, UNITS, channel_name, si_unit
from motofmi.recordings.downsampling import reduced
from motofmi.recordings.formats import opened, run_name
from motofmi.recordings.quality import channel_errors, channel_warnings, complete_rows, rig_warnings, sampling_warnings
from motofmi.recordings.recording import Recording
from motofmi.recordings.rig_file import read_rig
from motofmi.recordings.table import Table, name_and_unit, with_time, with_unit

MINIMUM_SAMPLES = 16
UNUSED = "unused"  # the name that leaves a column out


@dataclass(frozen=True)
class Source:
    """Where a channel comes from: the file's column and its place, the channel's name, its SI unit,
    and the factor to it."""

    place: int
    column: str
    name: str
    unit: str
    factor: float


def read_recording(path: str | Path, mapping: Mapping[str, str] | None = None, rate: float | None = None,
                   quantities: Mapping[str, str] = UNITS) -> Recording:  # fmt: skip
    """The run in a file of any format that `formats.supported()` lists.

    mapping gives columns other names, and units where the file has none: {"Torque": "steer_torque [N.m]"}; a minus
    before the name reverses the sign, and the name `unused` leaves a column out. rate [Hz] reduces a faster recording
    while it is read, so that a large file needs little memory. quantities gives the SI unit of every name that is
    expected; a column of that name must have a unit that measures the same. Of several columns of one name, that one is
    used. The time of a file without such a column follows from the sampling rate in `rig.json`. Raises InputError for
    a file that cannot be read or used, with the line or the time of the fault, and MissingToolError where the format
    needs a package that is not installed.

        >>> read_recording("sweep.csv", {"Torque": "steer_torque [N.m]"})     # doctest: +SKIP
    """
    path = Path(path)
    if path.is_dir():
        raise InputError(f"{path} is a folder; give the recordings in it, as in {path / '*.csv'}")
    rig = read_rig(path.parent)
    with opened(path) as table:
        mapping = dict(mapping or {})
        sources, notes = _sources(table, mapping, quantities)
        left_out = {_column(table, c) for c, target in mapping.items() if target == UNUSED}
        if TIME not in (s.name for s in sources):
            table = with_time(table, _sampling_rate(rig, table.names), left_out)
            mapping = {c: target for c, target in mapping.items() if target != UNUSED}
            sources, notes = _sources(table, mapping, quantities)
        unread = tuple(n for n in table.names if n not in left_out and n not in {s.column for s in sources})
        rows, reduction = _rows(table, sources, rate)
        values = {s.name: y if s.factor == 1 else y * s.factor for s, y in zip(sources, rows.T, strict=True)}
        units = {s.name: s.unit for s in sources if s.name != TIME}
        time, columns, gaps = _complete(values, quantities)
        if len(time) < MINIMUM_SAMPLES:
            raise InputError(f"{len(time)} samples, too few for any estimate (at least {MINIMUM_SAMPLES})")
        channel_errors(time, columns, units)
    warnings = (
        *notes,
        *reduction,
        *gaps,
        *sampling_warnings(time),
        *channel_warnings(time, columns, units),
        *rig_warnings(time, rig),
    )
    headings = {s.name: s.column for s in sources if s.name != s.column}
    negated = frozenset(s.name for s in sources if s.factor < 0)
    converted = frozenset(s.name for s in sources if abs(s.factor) != 1)
    return Recording(
        run_name(path), time, columns, {name: units[name] for name in columns}, warnings, rig, file=path.name,
        headings=headings, negated=negated, converted=converted, unread=unread, path=path,
    )


def write_recording(recording: Recording, path: str | Path) -> None:
    """Write the run as CSV with a unit in brackets per column; six digits, the time with ten."""
    header = ",".join([f"{TIME} [s]", *(f"{name} [{recording.units[name]}]" for name in recording.columns)])
    table = np.column_stack([recording.time, *recording.columns.values()])
    row = ",".join(["%.10g"] + ["%.6g"] * len(recording.columns))
    write_atomically(path, lambda file: np.savetxt(file, table, row, header=header, comments="", encoding="utf-8"))


def _sources(table: Table, mapping: Mapping[str, str], quantities: Mapping[str, str]) -> tuple[list[Source], list[str]]:
    """The columns that are used, and warnings about those that are not although they have a unit."""
    wanted = {_column(table, column): name_and_unit(target.removeprefix("-")) for column, target in mapping.items()}
    reversed_ = {_column(table, column) for column, target in mapping.items() if target.startswith("-")}
    taken = {name for name, _ in wanted.values()} | set(table.names)
    sources: list[Source] = []
    notes, without_unit = [], []
    for place, (column, stated) in enumerate(zip(table.names, table.units, strict=True)):
        alias = _expected_name(column, stated, quantities)
        name, given = wanted.get(column, (alias if alias not in taken else column, ""))
        if name == UNUSED:
            continue
        given = given or stated
        if not given and name not in quantities:
            continue  # a label or a counter: without a unit it is no quantity
        if not given:
            without_unit.append((column, f"{name} [{quantities[name]}]"))
            continue
        try:
            expected = quantities.get(name) or si_unit(given)
        except InputError:
            notes.append(f"{column} is left out: its unit [{given}] is unknown")
            continue
        if unit(given).exponents != unit(expected).exponents:
            hint = "the acceleration of gravity is written [gn], [g] is gram" if given == "g" else (
                f'scale its numbers in the file, or add --map "{column}={name} [{expected}]" to read them in {expected}'
            )
            raise InputError(f"column {column!r} is in [{given}], but {name} is measured in [{expected}]; {hint}")
        if name in (s.name for s in sources):
            raise InputError(f"two columns are {name!r}; map all but one to another name")
        sign = -1.0 if column in reversed_ else 1.0
        sources.append(Source(place, column, name, expected, sign * unit(given).to(unit(expected))))
    if without_unit:
        raise InputError(_units_wanted(without_unit))
    return sources, notes


def _column(table: Table, given: str) -> str:
    """The name in the table of a column as a user gives it, with or without its unit. Raises InputError where there is
    no such column."""
    name, stated = name_and_unit(given)
    for known in (given, with_unit(name, stated), name):
        if known in table.names:
            return known
    raise unknown("column", name, table.names)


def _expected_name(column: str, stated: str, quantities: Mapping[str, str]) -> str:
    """The expected name of a column with a stated unit; its own where it is not expected.

    Of several columns of one name, that with a unit of the expected quantity is meant.
    """
    name, own = name_and_unit(column)
    if not own or own != stated:
        return channel_name(column, quantities)
    alias = channel_name(name, quantities)
    with suppress(InputError):  # an unknown unit
        if alias in quantities and unit(own).exponents == unit(quantities[alias]).exponents:
            return alias
    return column


def _sampling_rate(rig: Mapping[str, Any], columns: Sequence[str]) -> float:
    """The sampling rate [Hz] of rig.json, for a file without a time. Raises InputError where it does not state one."""
    if "sampling" not in rig:
        raise InputError(
            f"no column '{TIME} [s]' (columns there: {', '.join(columns)}); map one with --map \"COLUMN={TIME} [s]\", "
            'or give the sampling rate in rig.json beside the file: {"sampling": {"value": 100, "unit": "Hz"}}'
        )
    rate = float(rig["sampling"]["value"])
    if not rate > 0:
        raise InputError(f"rig.json: sampling is {rate:g} Hz; expected a sampling rate above 0")
    return rate


def _units_wanted(columns: Sequence[tuple[str, str]]) -> str:
    """What to do where columns (name, `name [unit]` in SI) have no unit."""
    options = " ".join(f'--map "{column}={target}"' for column, target in columns)
    several = len(columns) > 1
    names = " and ".join(filter(None, [", ".join(repr(c) for c, _ in columns[:-1]), repr(columns[-1][0])]))
    return (f"column{'s' if several else ''} {names} {'have' if several else 'has'} no unit; write it in the heading, "
            "as in "
            f"{columns[0][1]!r}, or add {options} with the unit{'s' if several else ''} that the file has")  # fmt: skip


def _rows(table: Table, sources: Sequence[Source], rate: float | None) -> tuple[np.ndarray, tuple[str, ...]]:
    """The numbers (n, k) of the k sources, reduced to the rate [Hz] where one is given, and a note on that."""
    places = [s.place for s in sources]
    blocks = table.blocks if places == list(range(len(table.names))) else (block[:, places] for block in table.blocks)
    try:
        if rate is not None:
            place = [s.name for s in sources].index(TIME)
            return reduced(iter(blocks), rate, place, 1 / sources[place].factor)
        if table.expected_bytes > psutil.virtual_memory().available:
            raise MemoryError
        together = list(blocks)
        return together[0] if len(together) == 1 else np.concatenate(together), ()
    except MemoryError:
        size = f" of {table.expected_bytes / 1e6:.0f} MB" if table.expected_bytes else ""
        raise InputError(
            f"the recording{size} does not fit in memory; reduce it while it is read with rate=128 (--rate 128) [Hz]"
        ) from None


def _complete(
    values: dict[str, np.ndarray], quantities: Mapping[str, str]
) -> tuple[np.ndarray, dict[str, np.ndarray], list[str]]:
    """Time (n,) and columns (n,) of the rows where nothing that is expected is missing, and warnings
    about what is left out."""
    time, notes = values.pop(TIME), []
    for name in [
        n for n, y in values.items() if not np.isfinite(y).all() and (n not in quantities or not np.isfinite(y).any())
    ]:
        missing = np.count_nonzero(~np.isfinite(values.pop(name)))
        if name in CHANNELS and CHANNELS[name].essential and missing == len(time):
            raise InputError(f"{name} has no value in any sample; is the sensor connected?")
        notes.append(f"{name} is left out: it has no value in {missing} of {len(time)} samples")
    whole, more = complete_rows(time, values)
    if whole.all():
        return time, values, notes
    return time[whole], {name: y[whole] for name, y in values.items()}, [*notes, *more]
