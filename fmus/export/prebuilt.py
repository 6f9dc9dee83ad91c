"""Prebuilt archives in an installed package, so that its own components need no compiler.

A release puts them into `fmus/built` (see CONTRIBUTING). An archive is used when its model description equals that of
the component byte by byte; its GUID is computed from all of the source code.
"""

import zipfile
from importlib.resources import files

from fmus.export.compilers import PLATFORMS

FOLDER = files("fmus").joinpath("built")


def find(archive: str, model_description: bytes) -> tuple[bytes, tuple[str, ...]] | None:
    """The bytes and the platforms of the prebuilt archive of that file name; None where there is none or its model
    description differs."""
    path = FOLDER.joinpath(archive)
    if not path.is_file():
        return None
    with path.open("rb") as file, zipfile.ZipFile(file) as members:
        if members.read("modelDescription.xml") != model_description:
            return None
        folders = {name.split("/")[1] for name in members.namelist() if name.startswith("binaries/")}
    arm = archive.endswith("_arm64.fmu")
    platforms = tuple(p.name for p in PLATFORMS.values()
                      if set(p.tuples) <= folders
                      or (p.folder in folders and arm == (p.name == "linux-arm64")))  # fmt: skip
    return path.read_bytes(), platforms
