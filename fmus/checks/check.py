"""Every check of an FMU.

A check is a module of this folder, or of `fmus.checks.description`, with a STAGE and a function
`check(fmu: CheckedFmu) -> list[Problem]`:

    archive        before anything is unpacked; an error here forbids unpacking
    description    the model description, which can be read, and the other XML files
    binary         the shared libraries
    run            the FMU runs, apart from this process
    replay         results that come with the archive are compared; after an error of a run they are not

A new check is a new file; a trial of the running FMU is one in `fmus.checks.trials`.
"""

import tempfile
import zipfile
import zlib
from functools import cache
from pathlib import Path
from types import ModuleType
from xml.etree import ElementTree as Xml

from fmus.checks.checked_fmu import FILE, VERSIONS, CheckedFmu
from fmus.checks.host import host_folder, other_processor
from fmus.checks.other_tools import opinions
from fmus.checks.problem import SEVERITIES, Problem
from fmus.support.errors import InputError
from fmus.support.modules import modules_in
from fmus.support.sandbox import Limits

__all__ = ["Limits", "Problem", "check"]

STAGES = ("archive", "description", "binary", "run", "replay")


@cache
def _checks() -> dict[str, list[ModuleType]]:
    """The modules with a check by stage."""
    modules = [*modules_in("fmus.checks"), *modules_in("fmus.checks.description")]
    found = [module for module in modules if hasattr(module, "STAGE")]
    return {stage: [module for module in found if module.STAGE == stage] for stage in STAGES}


def check(path: str | Path, limits: Limits | None = None, other_tools: bool = True) -> list[Problem]:
    """The problems of an FMU, errors first; no error means clean.

    limits hold for each trial of the running FMU. With other_tools, fmpy and fmutool are asked for their opinion where
    the checks of the description find no error. Raises InputError when there is no such file.

        check("rider.fmu", Limits(time=10.0))
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"cannot read {path}: no such file")
    limits = limits or Limits()
    found = _at("archive", CheckedFmu(path, Path(), limits))
    if not any(problem.severity == "error" for problem in found):
        with tempfile.TemporaryDirectory(prefix="check-", ignore_cleanup_errors=True) as folder:
            try:
                with zipfile.ZipFile(path) as members:
                    members.extractall(folder)
            except (OSError, zipfile.BadZipFile, zlib.error, RuntimeError, NotImplementedError) as error:
                return [Problem("archive", "error", f"cannot be unpacked: {error}", path.name)]
            found += _unpacked(CheckedFmu(path, Path(folder), limits), other_tools)
    return sorted(dict.fromkeys(found), key=lambda problem: SEVERITIES.index(problem.severity))


def _at(stage: str, fmu: CheckedFmu) -> list[Problem]:
    return [problem for module in _checks()[stage] for problem in module.check(fmu)]


def _unpacked(fmu: CheckedFmu, other_tools: bool) -> list[Problem]:
    try:
        version = fmu.version
    except (Xml.ParseError, ValueError, LookupError) as error:  # the last two for encodings
        return [Problem("description", "error", f"is no XML: {error}", FILE)]
    if version not in VERSIONS:
        given = fmu.root.get("fmiVersion")
        return [Problem("description", "error", f"fmiVersion {given!r} is not checked (valid: 2.0, 3.0)", FILE)]
    found = _at("description", fmu)
    if other_tools and not any(problem.severity == "error" for problem in found):
        found += opinions(fmu)
    found += _at("binary", fmu)
    if obstacle := _obstacle(fmu):
        return [*found, obstacle]
    found += (run := _at("run", fmu))
    return found if any(problem.severity == "error" for problem in run) else found + _at("replay", fmu)


def _obstacle(fmu: CheckedFmu) -> Problem | None:
    """Why the FMU cannot be run on this machine."""
    here = host_folder(fmu.version)
    if not (fmu.folder / "binaries" / here).is_dir():
        return Problem("run", "warning", f"has no binary for this machine ({here}), so it was not run", "binaries")
    if other := other_processor(fmu.folder / "binaries" / here):
        return Problem("run", "warning", f"its binary is for {other}, so it was not run here", f"binaries/{here}")
    return None
