"""The XML files against the schemas of the standard, which fmpy brings."""

from functools import cache
from pathlib import Path
from typing import Any

import fmpy
from lxml import etree

from fmus.checks.checked_fmu import FILE, CheckedFmu
from fmus.checks.problem import Problem

STAGE = "description"
SHOWN = 10  # deviations of a file that are listed
# File, schema in FMI 2 and FMI 3, sections. FMI 2.0.4 takes terminals and build descriptions from FMI 3.
FILES = (
    (FILE, "fmi2/fmi2ModelDescription.xsd", "fmi3/fmi3ModelDescription.xsd", "2.2", "2.4"),
    (
        "terminalsAndIcons/terminalsAndIcons.xml",
        "fmi3/fmi3TerminalsAndIcons.xsd",
        "fmi3/fmi3TerminalsAndIcons.xsd",
        "2.3",
        "2.4.9",
    ),
    ("sources/buildDescription.xml", "fmi3/fmi3BuildDescription.xsd", "fmi3/fmi3BuildDescription.xsd", "2.3", "2.4.10"),
)


def check(fmu: CheckedFmu) -> list[Problem]:
    """Deviations from the schemas."""
    found = []
    for name, two, three, *numbers in FILES:
        path = fmu.folder / name
        if path.is_file():
            deviations = _deviations(path, two if fmu.version == "2" else three)
            found += [fmu.error("schema", message, name, *numbers) for message in deviations]
    return found


@cache
def _schema(name: str) -> Any:
    return etree.XMLSchema(file=str(Path(fmpy.__file__).parent / "schema" / name))


def _deviations(path: Path, schema: str) -> list[str]:
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False)
    try:
        tree = etree.parse(str(path), parser)
    except (etree.XMLSyntaxError, ValueError, LookupError, OSError) as error:
        return [f"is no XML: {error}"]
    judge = _schema(schema)
    if judge.validate(tree):
        return []
    said = [f"line {entry.line}: {entry.message}" for entry in judge.error_log]
    more = len(said) - SHOWN
    return [*said[:SHOWN], f"{more} more deviations from the schema"] if more > 0 else said
