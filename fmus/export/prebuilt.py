"""Ready-made archives that an installed package carries, so that no compiler is needed for what it knows already.

A release puts them into `fmus/built` (see CONTRIBUTING). One is used when its model description is that of the
component, byte by byte: the identifier in it follows from all of the source code.
"""

import zipfile
from importlib.resources import files

from fmus.compilers import PLATFORMS

FOLDER = files("fmus").joinpath("built")


def find(archive: str, model_description: bytes) -> tuple[bytes, tuple[str, ...]] | None:
    """The bytes and the platforms of the ready-made archive of that file name, if there is one and it still fits."""
    path = FOLDER.joinpath(archive)
    if not path.is_file():
        return None
    with path.open("rb") as file, zipfile.ZipFile(file) as members:
        if members.read("modelDescription.xml") != model_description:
            return None
        folders = {name.split("/")[1] for name in members.namelist() if name.startswith("binaries/")}
    arm = archive.endswith("_arm64.fmu")
    platforms = tuple(p.name for p in PLATFORMS.values()
                      if set(p.tuples) <= folders or (p.folder in folders and arm == (p.name == "linux-arm64")))  # fmt: skip
    return path.read_bytes(), platforms
