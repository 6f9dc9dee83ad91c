"""Every check of an FMU that there is, ours or anybody's.

The archive is looked at before it is unpacked, its binaries run in a process of their own with a time limit.
"""

import tempfile
import zipfile
import zlib
from pathlib import Path
from xml.etree import ElementTree as Xml

from fmus.checks import archive, behaviour, binary, description
from fmus.checks.problem import Problem
from fmus.errors import InputError

__all__ = ["Problem", "check"]


def check(path: str | Path, time_limit: float = behaviour.TIME_LIMIT) -> list[Problem]:
    """The problems of an FMU, errors first; no error means clean.

    time_limit [s] holds for each kind of FMU in the archive. Raises InputError when there is no such file.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"cannot read {path}: no such file")
    found = archive.problems(path)
    if not found:
        with tempfile.TemporaryDirectory(prefix="check-") as folder:
            try:
                with zipfile.ZipFile(path) as members:
                    members.extractall(folder)
            except (OSError, zipfile.BadZipFile, zlib.error) as error:
                return [Problem("archive", "error", f"cannot be unpacked: {error}", path.name)]
            found = _unpacked(path, Path(folder), time_limit)
    return sorted(found, key=lambda problem: problem.severity != "error")


def _unpacked(path: Path, folder: Path, time_limit: float) -> list[Problem]:
    found = description.problems(path, folder)
    if any(p.check == "description" for p in found):
        return found
    root = Xml.parse(folder / "modelDescription.xml").getroot()
    version = root.get("fmiVersion", "")[:1]
    found += binary.problems(folder)
    here = binary.host_folder(version)
    if not (folder / "binaries" / here).is_dir():
        return [*found, Problem("run", "warning", f"has no binary for this machine ({here}), so it was not run", "binaries")]
    if other := binary.other_processor(folder / "binaries" / here):
        return [*found, Problem("run", "warning", f"its binary is for {other}, so it was not run here", f"binaries/{here}")]
    if any(p.severity == "error" and p.check in ("identifier", "fmpy", "structure") for p in found):
        return [*found, Problem("run", "warning", "was not run because of the errors found before", path.name)]
    for kind in ("CoSimulation", "ModelExchange"):
        if root.find(kind) is not None:
            found += behaviour.problems(folder, kind, time_limit)
    return found
