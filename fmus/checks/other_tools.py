"""What other checkers report that importers use: fmpy, and fmutool where it is installed. The checks of this project
decide what is an error; a deviating opinion is worth a warning."""

import json
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

from fmus.checks.checked_fmu import FILE, CheckedFmu
from fmus.checks.problem import Problem

TIME_LIMIT = 60.0  # s
LARGEST = 5000  # variables; fmpy's check of names takes milliseconds for each
FMPY = """import json, sys
from fmpy.validation import validate_fmu
print(json.dumps([str(problem) for problem in validate_fmu(sys.argv[1])]))
"""
FMUTOOL = "import sys; from fmu_manipulation_toolbox.cli.fmutool import fmutool; sys.exit(fmutool())"


def opinions(fmu: CheckedFmu) -> list[Problem]:
    """Warnings for what the other tools report; a note where they were not asked."""
    if len(fmu.model.variables) > LARGEST:
        return [
            Problem(
                "tools",
                "note",
                f"fmpy and fmutool were not asked: {len(fmu.model.variables)} variables, more than {LARGEST}",
                FILE,
            )
        ]
    return _fmpy(fmu.path) + _fmutool(fmu.path)


def _fmpy(path: Path) -> list[Problem]:
    said = _from_python(FMPY, path)
    if said is None:
        return [Problem("fmpy", "note", f"did not finish within {TIME_LIMIT:g} s", FILE)]
    try:
        return [Problem("fmpy", "warning", f"fmpy reports: {' '.join(p.split())}", FILE) for p in json.loads(said[0])]
    except ValueError:
        return [
            Problem("fmpy", "warning", f"fmpy reports: {said[1].strip().rpartition(chr(10))[2] or 'nothing'}", FILE)
        ]


def _fmutool(path: Path) -> list[Problem]:
    if find_spec("fmu_manipulation_toolbox") is None:
        return []
    said = _from_python(FMUTOOL, "-input", path, "-check")
    if said is None:
        return [Problem("fmutool", "note", f"did not finish within {TIME_LIMIT:g} s", path.name)]
    return [
        Problem("fmutool", "warning", f"fmutool reports: {line}", FILE)
        for line in re.findall(r"^ERROR\s*\|\s*(.*)$", "".join(said), re.MULTILINE)
    ]


def _from_python(code: str, *arguments: str | Path) -> tuple[str, str] | None:
    """What a line of Python writes in a process of its own; None when it takes too long."""
    command = [sys.executable, "-P", "-c", code, *map(str, arguments)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=TIME_LIMIT, check=False)
    except subprocess.TimeoutExpired:
        return None
    return done.stdout, done.stderr
