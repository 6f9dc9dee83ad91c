"""Terminals: members that name variables, names that are unique (FMI 2.0.4 takes them from FMI 3.0)."""

from collections import Counter
from xml.etree import ElementTree as Xml

from fmus.checks.checked_fmu import CheckedFmu
from fmus.checks.problem import Problem

STAGE = "description"
FILE = "terminalsAndIcons/terminalsAndIcons.xml"


def check(fmu: CheckedFmu) -> list[Problem]:
    """Problems of the terminals; a file that is no XML is the schema's problem."""
    try:
        root = Xml.parse(fmu.folder / FILE).getroot()
    except (OSError, Xml.ParseError, ValueError, LookupError):
        return []
    known = {name for v in fmu.model.variables for name in (v.name, *(a.get("name") for a in v.aliases))}
    return [
        fmu.error("terminals", message, where, "2.3", "2.4.9.2")
        for where, message in _terminals(root.find("Terminals"), known, "")
    ]


def _terminals(parent: Xml.Element | None, known: set[str | None], path: str) -> list[tuple[str, str]]:
    """(terminal, what is wrong with it), nested terminals too."""
    found: list[tuple[str, str]] = []
    terminals = [] if parent is None else parent.findall("Terminal")
    repeated = [name for name, count in Counter(t.get("name") for t in terminals).items() if count > 1]
    found += [(f"terminal {path}{name}", "its name is not unique") for name in repeated]
    for terminal in terminals:
        name = f"terminal {path}{terminal.get('name')}"
        members = terminal.findall("TerminalMemberVariable")
        named = [m.get("variableName") for m in members]
        streams = [
            s.get(a)
            for s in terminal.findall("TerminalStreamMemberVariable")
            for a in ("inStreamVariableName", "outStreamVariableName")
        ]
        found += [
            (name, f"names the variable {v!r}, which the description does not have")
            for v in (*named, *streams)
            if v is not None and v not in known
        ]
        found += [(name, "has a member without a variable") for v in named if not v]
        if terminal.get("matchingRule") in ("plug", "bus"):
            found += [
                (name, f"its member {m.get('variableName')!r} has no memberName")
                for m in members
                if not m.get("memberName")
            ]
        doubled = [n for n, count in Counter(m.get("memberName") for m in members).items() if n and count > 1]
        found += [(name, f"has two members {n!r}") for n in doubled]
        found += _terminals(terminal, known, f"{path}{terminal.get('name')}.")
    return found
