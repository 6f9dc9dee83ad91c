"""The tests of a batch: the files of a folder, or the rows of a manifest.

A folder: every recording in it is a test; every folder in it is a test, too, whose recordings are its runs.

A manifest is a CSV file with a row for each test. The column `recordings` has its files, separated by semicolons and
relative to the manifest; `validation` and `bare` have further ones; `test` is the name (default: that of the first
file). Every other column is an argument of the workflow, for tests that differ in it; an empty cell leaves it out.

    test,recordings,validation,rider
    monday_1,monday/up.csv;monday/up_2.csv,monday/down.csv,3_2011
"""

import csv
import hashlib
import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fmus.support.errors import InputError, unknown
from motofmi.recordings.formats import PACKED, formats, run_name

FILES = ("recordings", "validation", "bare")  # columns that hold files
NAME = "test"
KEPT = ("mapping", "criteria", "bounds", "effects", "out")  # arguments that are no text, the same for all tests


@dataclass(frozen=True)
class Test:
    """A test of a batch: its name, its files by argument of the workflow, and its own further arguments."""

    __test__ = False  # not one of pytest's

    name: str
    files: Mapping[str, tuple[Path, ...]]
    arguments: Mapping[str, Any] = field(default_factory=dict)

    def hashes(self) -> dict[str, list[str]]:
        """The hashes of the files by argument; `missing` for those that are not there."""
        return {argument: [hashlib.sha256(p.read_bytes()).hexdigest() if p.is_file() else "missing" for p in paths]
                for argument, paths in self.files.items()}  # fmt: skip


def tests_of(given: str | Path, workflow: Callable) -> list[Test]:
    """The tests of a folder or of a manifest. Raises InputError for one without tests, for two of the same name, and
    for a column that is no argument of the workflow."""
    path = Path(given)
    if path.is_dir():
        found = _of_folder(path)
    elif path.is_file():
        found = _of_manifest(path, workflow)
    else:
        raise InputError(f"cannot read {path}: there is no such folder or file")
    if not found:
        raise InputError(f"{path} holds no recordings (formats: {', '.join(sorted(formats()))})")
    names = [test.name for test in found]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"two tests of {path} have the name {name!r}: name them in a column {NAME} of a manifest")
    return found


def _of_folder(folder: Path) -> list[Test]:
    found = []
    for path in sorted(folder.iterdir()):
        if path.name.startswith("."):
            continue
        runs = sorted(inner for inner in path.iterdir() if _is_recording(inner)) if path.is_dir() else [path]
        if path.is_dir() and runs:
            found.append(Test(path.name, {"recordings": tuple(runs)}))
        elif _is_recording(path):
            found.append(Test(run_name(path), {"recordings": (path,)}))
    return found


def _is_recording(path: Path) -> bool:
    suffix = Path(path.stem).suffix if path.suffix.lower() == PACKED else path.suffix
    return path.is_file() and suffix.lower() in formats() and not path.name.startswith(".")


def _of_manifest(path: Path, workflow: Callable) -> list[Test]:
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.DictReader(file)
            rows, columns = list(reader), list(reader.fieldnames or ())
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"cannot read {path}: {error}") from None
    parameters = inspect.signature(workflow).parameters
    known = [NAME, *(name for name in parameters if name not in KEPT)]
    for column in columns:
        if column not in known:
            raise InputError(f"{path}: {unknown('column', column, known)}")
    if "recordings" not in columns:
        raise InputError(f"{path} has no column recordings: a manifest has a row for each test, with its files there")
    return [_of_row(path, number, row, parameters) for number, row in enumerate(rows, start=2)]


def _of_row(path: Path, number: int, row: Mapping[str, Any], parameters: Mapping[str, inspect.Parameter]) -> Test:
    files = {argument: tuple(path.parent / part.strip()
                             for part in (row.get(argument) or "").split(";") if part.strip())
             for argument in FILES}  # fmt: skip
    if not files["recordings"]:
        raise InputError(f"{path}, line {number}: no recordings")
    given = {name: _value(f"{path}, line {number}: {name}", text.strip(), parameters[name])
             for name, text in row.items()
             if name not in (NAME, *FILES) and isinstance(text, str) and text.strip()}  # fmt: skip
    return Test((row.get(NAME) or "").strip() or run_name(files["recordings"][0]),
                {argument: paths for argument, paths in files.items() if paths}, given)  # fmt: skip


def _value(place: str, text: str, parameter: inspect.Parameter) -> Any:
    """A cell as the argument: a number, several words, or text. Raises InputError for what should be a number."""
    kind = str(parameter.annotation)
    if "Sequence[str]" in kind:
        return text.split()
    if "float" not in kind and "int" not in kind:
        return text
    try:
        return int(text) if kind == "<class 'int'>" else float(text)
    except ValueError:
        raise InputError(f"{place} = {text!r} is not a number") from None
