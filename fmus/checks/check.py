"""Every check of an FMU, this project's and those of fmpy and fmutool.

A check is a module of this folder with a STAGE and a function `check(fmu: CheckedFmu) -> list[Problem]`:

    archive        before anything is unpacked; a problem here forbids unpacking
    description    the model description, which can be read
    binary         the shared libraries
    run            the FMU runs, in a process of its own; not after an error that makes a run meaningless

A new check is a new file here.
"""

import tempfile
import zipfile
import zlib
from functools import cache
from pathlib import Path
from types import ModuleType
from xml.etree import ElementTree as Xml

from fmus.checks.checked_fmu import FILE, TIME_LIMIT, VERSIONS, CheckedFmu
from fmus.checks.host import host_folder, other_processor
from fmus.checks.problem import Problem
from fmus.support.errors import InputError
from fmus.support.modules import modules_in

__all__ = ["Problem", "check"]

STAGES = ("archive", "description", "binary", "run")
NO_RUN_AFTER = ("identifier", "fmpy", "structure")  # errors of these make a run meaningless


@cache
def _checks() -> dict[str, list[ModuleType]]:
    """The modules with a check by stage."""
    found = [module for module in modules_in("fmus.checks") if hasattr(module, "STAGE")]
    return {stage: [module for module in found if module.STAGE == stage] for stage in STAGES}


def check(path: str | Path, time_limit: float = TIME_LIMIT) -> list[Problem]:
    """The problems of an FMU, errors first; no error means clean.

    time_limit [s] holds for each kind of FMU in the archive. Raises InputError when there is no such file.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"cannot read {path}: no such file")
    found = _at("archive", CheckedFmu(path, Path(), time_limit))
    if not found:
        with tempfile.TemporaryDirectory(prefix="check-") as folder:
            try:
                with zipfile.ZipFile(path) as members:
                    members.extractall(folder)
            except (OSError, zipfile.BadZipFile, zlib.error) as error:
                return [Problem("archive", "error", f"cannot be unpacked: {error}", path.name)]
            found = _unpacked(CheckedFmu(path, Path(folder), time_limit))
    return sorted(found, key=lambda problem: problem.severity != "error")


def _at(stage: str, fmu: CheckedFmu) -> list[Problem]:
    return [problem for module in _checks()[stage] for problem in module.check(fmu)]


def _unpacked(fmu: CheckedFmu) -> list[Problem]:
    try:
        version = fmu.version
    except (Xml.ParseError, ValueError, LookupError) as error:  # the last two for encodings
        return [Problem("description", "error", f"is no XML: {error}", FILE)]
    if version not in VERSIONS:
        return [
            Problem(
                "description",
                "error",
                f"fmiVersion {fmu.root.get('fmiVersion')!r} is not checked (valid: 2.0, 3.0)",
                FILE,
            )
        ]
    found = _at("description", fmu) + _at("binary", fmu)
    obstacle = _obstacle(fmu, found)
    return [*found, obstacle] if obstacle else found + _at("run", fmu)


def _obstacle(fmu: CheckedFmu, found: list[Problem]) -> Problem | None:
    """Why the FMU is not run."""
    here = host_folder(fmu.version)
    if not (fmu.folder / "binaries" / here).is_dir():
        return Problem("run", "warning", f"has no binary for this machine ({here}), so it was not run", "binaries")
    if other := other_processor(fmu.folder / "binaries" / here):
        return Problem("run", "warning", f"its binary is for {other}, so it was not run here", f"binaries/{here}")
    if any(p.severity == "error" and p.check in NO_RUN_AFTER for p in found):
        return Problem("run", "warning", "was not run because of the errors found before", fmu.path.name)
    return None
