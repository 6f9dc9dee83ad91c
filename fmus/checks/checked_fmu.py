"""The FMU that is checked: its archive, and after unpacking its folder and its model description."""

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from xml.etree import ElementTree as Xml

from fmus.checks.model import Model
from fmus.checks.problem import Problem
from fmus.checks.sections import section
from fmus.support.sandbox import Limits

FILE = "modelDescription.xml"
VERSIONS = ("2", "3")


@dataclass
class CheckedFmu:
    """An FMU under check. folder is empty until the archive is unpacked; limits hold for each trial of the FMU."""

    path: Path
    folder: Path
    limits: Limits = field(default_factory=Limits)

    @cached_property
    def root(self) -> Xml.Element:
        """The model description. Raises ParseError, ValueError or LookupError when it is no XML in a known encoding."""
        return Xml.parse(self.folder / FILE).getroot()

    @property
    def version(self) -> str:
        """2 or 3, or another text where the description has another version."""
        return (self.root.get("fmiVersion") or "")[:1]

    @cached_property
    def model(self) -> Model:
        """The variables and the structure of the model description."""
        return Model(self.root)

    def section(self, two: str, three: str) -> str:
        """A section of the standard, from its number in FMI 2.0.4 and in FMI 3.0."""
        return section(self.version, two, three)

    def error(self, check: str, message: str, where: str, two: str = "", three: str = "") -> Problem:
        """An error with its section in FMI 2.0.4 and in FMI 3.0."""
        return Problem(check, "error", message, where, section=self.section(two, three))

    def warning(self, check: str, message: str, where: str, two: str = "", three: str = "") -> Problem:
        return Problem(check, "warning", message, where, section=self.section(two, three))
