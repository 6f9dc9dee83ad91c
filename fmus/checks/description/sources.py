"""Source code: files that the build description or the model description names exist; identifiers agree."""

from xml.etree import ElementTree as Xml

from fmus.checks.checked_fmu import FILE, CheckedFmu
from fmus.checks.problem import Problem

STAGE = "description"
BUILD = "sources/buildDescription.xml"


def check(fmu: CheckedFmu) -> list[Problem]:
    """Source files that are not there."""
    named = (
        [(FILE, e.get("name")) for e in fmu.root.iterfind("*/SourceFiles/File")]
        if (fmu.folder / "sources").is_dir()
        else []
    )
    found = []
    try:
        root = Xml.parse(fmu.folder / BUILD).getroot()
    except (OSError, Xml.ParseError, ValueError, LookupError):
        root = None
    if root is not None:
        named += [(BUILD, e.get("name")) for e in root.iter("SourceFile")]
        identifiers = {e.get("modelIdentifier") for e in fmu.root if e.tag in fmu.model.kinds}
        found += [
            fmu.error(
                "sources",
                f"a build configuration is for {c.get('modelIdentifier')!r}, which no interface has",
                BUILD,
                "2.3",
                "2.4.10",
            )
            for c in root.iter("BuildConfiguration")
            if c.get("modelIdentifier") not in identifiers
        ]
        found += [
            fmu.error("sources", "a set of source files names none", BUILD, "2.3", "2.4.10")
            for s in root.iter("SourceFileSet")
            if s.find("SourceFile") is None
        ]
    missing = [(where, name) for where, name in named if not name or not (fmu.folder / "sources" / name).is_file()]
    return found + [
        fmu.error("sources", f"names the source file {name!r}, which is not in the archive", where, "2.3", "2.4.10")
        for where, name in missing
    ]
