"""The replay of reference results in the folder of an unpacked archive (layered standard FMI-LS-REF).

The manifest `extra/org.fmi-standard.fmi-ls-ref/fmi-ls-manifest.xml` lists the files. Those in the form of
`fmus.export.reference` are replayed: an experiment with inputs and results, and the frequencies and damping ratios of
the modes.
"""

import csv
import json
import tempfile
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path, PurePosixPath
from typing import Any
from xml.etree import ElementTree as Xml

import numpy as np

from fmus.checks.problem import Problem
from fmus.cosimulation.simulate import simulate
from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem
from fmus.export.reference_folder import FOLDER, MANIFEST, REPLAY
from fmus.support.errors import InputError, MissingToolError, SimulationError
from fmus.support.sandbox import Limits, limit_resources

LARGEST = 64 * 2**20  # bytes of a file that is read


def inside(folder: str) -> None:
    """The other process: prints one JSON line for each problem."""
    limit_resources(Limits())
    for problem in replayed(Path(folder)):
        print(json.dumps(asdict(problem)), flush=True)


def replayed(folder: Path) -> Iterator[Problem]:
    """Problems of the reference results of the FMU that is unpacked in a folder."""
    manifest = Xml.parse(folder / MANIFEST).getroot()
    present = []
    for related in manifest.iterfind("Related"):
        path = PurePosixPath(related.get("source", ""))
        if path.is_absolute() or ".." in path.parts or ":" in str(path):
            continue  # files outside of the folder are not replayed
        if (folder / FOLDER / path).is_file():
            present.append(str(path))
        else:
            yield Problem(REPLAY, "warning", f"the manifest lists {path}, which is not in the archive", MANIFEST)
    for source in present:
        content = _json(folder / FOLDER / source) if source.endswith(".json") else {}
        try:
            with tempfile.TemporaryDirectory() as place:
                if {"inputs", "results", "start"} <= content.keys():
                    yield from _experiment(_packed(folder, Path(place)), folder / FOLDER, content, source)
                elif "modes" in content:
                    yield from _modes(_packed(folder, Path(place)), content, source)
        except (InputError, SimulationError, MissingToolError) as error:
            yield Problem(REPLAY, "error", f"cannot be replayed: {error}", source)
        except (TypeError, ValueError, KeyError, OSError) as error:
            yield Problem(REPLAY, "warning", f"is not in a form that can be replayed: {error!r}", source)


def _experiment(fmu: Path, folder: Path, given: Mapping[str, Any], where: str) -> Iterator[Problem]:
    """Problems of the outputs over time: each against the largest value of its column."""
    times, inputs = _table(folder / PurePosixPath(given["inputs"]).name)
    at, wanted = _table(folder / PurePosixPath(given["results"]).name)
    tolerance, step = float(given["tolerance"]), float(given["stepSize"])
    starts = {**{n: float(x[0]) for n, x in inputs.items()}, **{n: float(x) for n, x in given["start"].items()}}
    with FmuSubsystem(fmu, "fmu", starts) as subsystem:
        moving = {n: x for n, x in inputs.items() if np.ptp(x) > 0}
        run = simulate(subsystem, step, float(given["stopTime"]), times, moving)
    for name, values in wanted.items():
        if f"fmu.{name}" not in run:
            yield Problem(REPLAY, "error", f"the results have the output {name}, which the FMU does not have", where)
            continue
        found = np.interp(at, run["time"], run[f"fmu.{name}"])
        error = np.abs(found - values) / max(np.abs(values).max(), 1e-300)
        worst = int(error.argmax())
        if not error[worst] <= tolerance:
            yield Problem(
                REPLAY, "error",
                f"{name} is {found[worst]:.9g} at {at[worst]:g} s, the reference has {values[worst]:.9g} "
                f"(tolerance {tolerance:g} of the largest value)", where,
            )  # fmt: skip


def _modes(fmu: Path, given: Mapping[str, Any], where: str) -> Iterator[Problem]:
    """Problems of the modes of the FMU, linearised at its start values."""
    tolerance = float(given["tolerance"])
    with FmuSubsystem(fmu, "fmu") as subsystem:
        eigenvalues = np.linalg.eigvals(subsystem.linearised().A)
    for mode in given["modes"]:
        damping, frequency = float(mode["damping_ratio"]), float(mode["frequency"])
        size = 2 * np.pi * frequency / np.sqrt(1 - damping**2)
        expected = complex(-damping * size, 2 * np.pi * frequency)
        near = eigenvalues[np.abs(eigenvalues - expected).argmin()] if len(eigenvalues) else 0j
        found = near.imag / (2 * np.pi), -near.real / max(abs(near), 1e-300)
        if not (abs(found[0] - frequency) <= tolerance * size / (2 * np.pi) and abs(found[1] - damping) <= tolerance):
            yield Problem(
                REPLAY, "error",
                f"the mode of {frequency:.9g} Hz with the damping ratio {damping:.9g} has {found[0]:.9g} Hz and "
                f"{found[1]:.9g} here (tolerance {tolerance:g})", where,
            )  # fmt: skip


def _packed(folder: Path, place: Path) -> Path:
    """The FMU as an archive again, without the reference results."""
    path = place / "replayed.fmu"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
        for file in sorted(p for p in folder.rglob("*") if p.is_file() and not p.is_relative_to(folder / "extra")):
            archive.write(file, file.relative_to(folder).as_posix())
    return path


def _table(path: Path) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Times (n,) [s] and columns (n,) by name, in the units of the FMU."""
    header, *rows = csv.reader(_text(path).splitlines())
    table = np.array(rows, float)
    names = [title.partition(" [")[0] for title in header]
    return table[:, 0], dict(zip(names[1:], table.T[1:], strict=True))


def _json(path: Path) -> dict[str, Any]:
    try:
        found = json.loads(_text(path))
    except ValueError:
        return {}
    return found if isinstance(found, dict) else {}


def _text(path: Path) -> str:
    if path.stat().st_size > LARGEST:
        raise ValueError(f"{path.name} has more than {LARGEST} bytes")
    return path.read_text("utf-8")

