"""Archives of co-simulation FMUs, FMI 2.0 or 3.0: extracted once in a process, with their model descriptions."""

import atexit
import shutil
import tempfile
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from xml.etree import ElementTree

import fmpy
from fmpy.model_description import ModelDescription

from fmus.support.errors import InputError
from fmus.support.untrusted_archive import refuse_unsafe

VERSIONS = ("2", "3")


@dataclass(frozen=True)
class Archive:
    """An extracted archive.

    moving: the variables that take part in intermediate updates; has_directional_derivatives: of co-simulation. fmpy
    leaves both out of FMI 3.0.
    """

    description: ModelDescription
    folder: Path
    moving: frozenset[str]
    has_directional_derivatives: bool

    @property
    def version(self) -> str:
        """2 or 3."""
        return self.description.fmiVersion[0]

    @property
    def library(self) -> dict[str, str]:
        """The arguments with which fmpy loads the library."""
        return {
            "guid": self.description.guid,
            "unzipDirectory": str(self.folder),
            "modelIdentifier": self.description.coSimulation.modelIdentifier,
        }


def open_archive(path: str | Path) -> Archive:
    """The archive at a path, extracted into a folder that is removed at the end of the process.

    Raises InputError when it is no co-simulation FMU of FMI 2 or 3, and when it must not be unpacked.
    """
    path = Path(path)
    try:
        return _open_archive(path.resolve(), path.stat().st_mtime)
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from None


def model_description(path: str | Path) -> ModelDescription:
    """The model description of an archive. Raises InputError as `open_archive` does."""
    return open_archive(path).description


@lru_cache(maxsize=256)
def _open_archive(path: Path, modified: float) -> Archive:
    folder = Path(tempfile.mkdtemp(prefix="fmu-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    try:
        refuse_unsafe(path)
        description = fmpy.read_model_description(str(path), validate=False)
        fmpy.extract(str(path), str(folder))
        root = ElementTree.parse(folder / "modelDescription.xml").getroot()
    except InputError:
        raise
    except Exception as error:  # fmpy raises whatever zip and XML readers raise
        raise InputError(f"{path} is not an FMU that can be read: {error}") from None
    if description.coSimulation is None:
        raise InputError(f"{path} has no co-simulation part")
    if description.fmiVersion[0] not in VERSIONS:
        raise InputError(f"{path} is FMI {description.fmiVersion} (valid: 2.0, 3.0)")
    if description.guid is None:
        needed = "guid" if description.fmiVersion[0] == "2" else "instantiationToken"
        raise InputError(f"{path}: modelDescription.xml has no {needed}; enter the one with which the binary was built")
    moving = frozenset(
        v.get("name", "") for v in root.iterfind("ModelVariables/*") if v.get("intermediateUpdate") == "true"
    )
    directional = any(part.get("providesDirectionalDerivatives") == "true" for part in root.iterfind("CoSimulation"))
    return Archive(
        description, folder, moving, bool(description.coSimulation.providesDirectionalDerivative or directional)
    )
