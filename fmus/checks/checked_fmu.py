"""The FMU that is checked: its archive, and after unpacking its folder and its model description."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from xml.etree import ElementTree as Xml

FILE = "modelDescription.xml"
VERSIONS = ("2", "3")
VARIABLES = {"2": "ModelVariables/ScalarVariable", "3": "ModelVariables/*"}
TIME_LIMIT = 60.0


@dataclass
class CheckedFmu:
    """An FMU under check. folder is empty until the archive is unpacked; time_limit [s] holds for
    each run of the FMU."""

    path: Path
    folder: Path
    time_limit: float = TIME_LIMIT

    @cached_property
    def root(self) -> Xml.Element:
        """The model description. Raises ParseError, ValueError or LookupError when it is no XML in a known encoding."""
        return Xml.parse(self.folder / FILE).getroot()

    @property
    def version(self) -> str:
        """2 or 3, or another text where the description has another version."""
        return (self.root.get("fmiVersion") or "")[:1]

    @property
    def variables(self) -> list[Xml.Element]:
        return self.root.findall(VARIABLES[self.version])
