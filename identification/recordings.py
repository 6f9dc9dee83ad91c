"""Recordings of a test rig: columns with units from a file, converted to SI, and checked but never repaired.

    time [s], steer_angle [deg], steer_torque [N.m], steer_angle_command [deg]
    0.0078125, 0.012, -1.76, 0.013

One file is one run. What is wrong with the sampling is said in `warnings`, with the time and the count.
"""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from fmus.errors import InputError, unknown
from fmus.files import write_beside
from fmus.units import unit
from identification.checks import channel_errors, channel_warnings, rig_warnings, sampling_warnings
from identification.csv_files import read_csv
from identification.formats import READERS
from identification.time_stamps import interval

# The channels of the rigs, and what each measures. Other columns keep the names that their file gives them.
QUANTITIES = {
    "time": "s",
    "steer_angle": "rad",
    "steer_angle_command": "rad",
    "steer_torque": "N.m",
    "steer_rate": "rad/s",
    "torso_rate": "rad/s",
    "roll_angle": "rad",
    "mockup_acceleration": "m/s2",
    "waist_acceleration": "m/s2",
    "shoulder_acceleration": "m/s2",
    "head_acceleration": "m/s2",
}
MINIMUM_SAMPLES = 16


@dataclass(frozen=True)
class Recording:
    """One run: time (n,) [s] and named columns (n,) in SI, their units, and what is doubtful about them.

    gaps are begin and end [s] of what is bridged but was not recorded.
    """

    name: str
    time: np.ndarray
    columns: dict[str, np.ndarray]
    units: dict[str, str]
    warnings: tuple[str, ...] = ()
    rig: dict[str, Any] = field(default_factory=dict)
    gaps: tuple[tuple[float, float], ...] = ()

    @cached_property
    def rate(self) -> float:
        """Samples per second [Hz], which neither gaps nor rounded time stamps move; infinite where all stamps are the same."""
        step = interval(self.time)
        return 1 / step if step else np.inf

    @cached_property
    def broken(self) -> np.ndarray:
        """Which samples (n,) lie in a gap."""
        return np.any([np.zeros(len(self.time), bool), *((begin < self.time) & (self.time < end) for begin, end in self.gaps)], axis=0)

    def from_zero(self) -> "Recording":
        """The recording with its first sample at time zero."""
        first = float(self.time[0])
        return replace(self, time=self.time - first, gaps=tuple((begin - first, end - first) for begin, end in self.gaps))

    def __getitem__(self, column: str) -> np.ndarray:
        if column not in self.columns:
            raise InputError(str(unknown(f"column of {self.name}", column, self.columns)) +
                             f"; map one with --map COLUMN={column}")  # fmt: skip
        return self.columns[column]


def read_recording(path: str | Path, mapping: Mapping[str, str] | None = None, rate: float | None = None,
                   quantities: Mapping[str, str] = QUANTITIES) -> Recording:  # fmt: skip
    """The run in a CSV, .mat, .uff, .mf4 or .parquet file.

    mapping gives columns other names, and units where the file has none: {"Torque": "steer_torque [N.m]"}.
    rate [Hz] reduces a faster recording while it is read, so that a large file needs little memory.
    quantities gives the SI unit of every name that is expected; a column of that name must have a unit that measures the same.
    Raises InputError for a file that cannot be read or used, with the line or the time of the fault.
    """
    path = Path(path)
    if path.is_dir():
        raise InputError(f"{path} is a folder; give the recordings in it, as in {path / '*.csv'}")
    reader = READERS.get(path.suffix.lower(), read_csv)
    try:
        raw, notes = reader(path, rate, next((c for c, v in (mapping or {}).items() if _split(v)[0] == "time"), "time"))
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror or error}") from None
    columns, units = _converted(raw, dict(mapping or {}), path, quantities)
    if "time" not in columns:
        raise InputError(f"{path}: no column 'time [s]' (columns there: {', '.join(columns)}); map one with --map COLUMN=time")
    time = columns.pop("time")
    if len(time) < MINIMUM_SAMPLES:
        raise InputError(f"{path}: {len(time)} samples, too few for any estimate (at least {MINIMUM_SAMPLES})")
    channel_errors(path, time, columns, units)
    rig = read_rig(path.parent)
    warnings = (*notes, *sampling_warnings(time), *channel_warnings(time, columns, units), *rig_warnings(time, rig))
    return Recording(path.stem, time, columns, units, warnings, rig)


def write_recording(recording: Recording, path: str | Path) -> None:
    """Write the run as CSV with a unit in brackets per column; six digits, the time with ten."""
    header = ",".join(["time [s]", *(f"{name} [{recording.units[name]}]" for name in recording.columns)])
    table = np.column_stack([recording.time, *recording.columns.values()])
    row = ",".join(["%.10g"] + ["%.6g"] * len(recording.columns))
    write_beside(path, lambda file: np.savetxt(file, table, row, header=header, comments="", encoding="utf-8"))


def read_rig(folder: str | Path) -> dict[str, Any]:
    """What `rig.json` says, {} without one: each entry {value, unit, standard_error} as in the file, in SI.

    folder is the recordings' folder or the file itself. Raises InputError for a file that is not as expected.
    """
    path = Path(folder)
    path = path / "rig.json" if path.is_dir() else path
    if not path.exists():
        return {}
    try:
        contents = json.loads(path.read_text("utf-8"))
        rig = {}
        for name, entry in contents.items():
            if name == "noise":  # {"noise": {"angle": {"value": 0.001, "unit": "rad"}}}: deviations by channel
                rig[name] = {channel: each["value"] * unit(each["unit"]).factor for channel, each in entry.items()}
                continue
            scale = unit(entry["unit"]).factor
            rig[name] = {**entry, "value": entry["value"] * scale, "unit": si_unit(entry["unit"])}
            if "standard_error" in entry:
                rig[name]["standard_error"] = entry["standard_error"] * scale
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise InputError(f'{path}: expected {{"handlebar_inertia": {{"value": 0.125, "standard_error": 0.00125, "unit": "kg.m2"}}}} '
                         f"and the like, found {f'no {error}' if isinstance(error, KeyError) else error}") from None  # fmt: skip
    return rig


def _converted(raw: Mapping[str, np.ndarray], mapping: dict[str, str], path: Path,
               quantities: Mapping[str, str]) -> tuple[dict[str, np.ndarray], dict[str, str]]:  # fmt: skip
    """The columns in SI by name, from headers `name [unit]`."""
    headers = {_split(header)[0]: header for header in raw}
    for name in mapping:
        if name not in headers and name not in raw:
            raise InputError(f"{path}: {unknown('column', name, headers)}")
    columns, units = {}, {}
    for name, header in headers.items():
        wanted, given = _split(mapping.get(header, mapping.get(name, name)))
        given = given or _split(header)[1]
        if not given and wanted not in quantities:
            continue  # a label or a counter: without a unit it is no quantity
        if not given:
            raise InputError(f"{path}: column {name!r} has no unit; write it as '{name} [{quantities[wanted]}]' "
                             f"or give it with --map \"{name}={wanted} [{quantities[wanted]}]\"")  # fmt: skip
        expected = quantities.get(wanted, si_unit(given))
        if unit(given).exponents != unit(expected).exponents:
            raise InputError(f"{path}: column {name!r} is in [{given}], but {wanted} is measured in [{expected}]")
        if wanted in columns:
            raise InputError(f"{path}: two columns are {wanted!r}; map all but one to another name")
        factor = unit(given).to(unit(expected))
        columns[wanted] = raw[header] if factor == 1 else raw[header] * factor
        units[wanted] = expected
    units.pop("time", None)
    return columns, units


def _split(header: str) -> tuple[str, str]:
    """`name [unit]` as (name, unit); unit is empty where there is none."""
    match = re.fullmatch(r"\s*(.*?)\s*[\[(]([^\])]*)[\])]\s*", header)
    return (match[1], match[2]) if match else (header.strip(), "")


def si_unit(name: str) -> str:
    """The name of the SI unit that measures the same as the given one: rad for deg, N.m for mNm."""
    given = unit(name)
    if given.factor == 1.0:
        return name
    by_exponents = {unit(known).exponents: known for known in (*QUANTITIES.values(), "N", "kg.m2", "Hz", "m", "kg", "m/s", "V", "1")}
    if given.exponents in by_exponents:
        return by_exponents[given.exponents]
    return ".".join(f"{base}{power}" for base, power in zip(("kg", "m", "s", "A", "K", "rad"), given.exponents, strict=True) if power)
