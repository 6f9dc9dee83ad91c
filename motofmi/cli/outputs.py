"""The output of a command: its result as JSON or on the screen, and files.

Whether a file can be written is checked before the command computes anything.
"""

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from fmus.support.errors import InputError
from fmus.support.files import writable, write_atomically, write_text
from fmus.support.plain_json import to_json
from motofmi.cli.screen import Screen

FIGURES = (".png", ".svg", ".pdf")
MAX_LISTED = 12  # files of one folder that are listed by name; of a folder with more, their number is printed
STANDARD_OUTPUT = Path("-")  # as the FILE of --json


def output_file(*suffixes: str) -> Callable[[str], Path]:
    """The argparse type of a file to write, whose name ends in one of the suffixes if any are given."""

    def checked(text: str) -> Path:
        path = Path(text)
        if suffixes and path.suffix.lower() not in suffixes:
            raise argparse.ArgumentTypeError(f"{text!r} does not end in {', '.join(suffixes)}")
        try:
            return writable(path)
        except InputError as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    return checked


def output_folder(text: str) -> Path:
    """The argparse type of a folder to write files into."""
    try:
        return writable(Path(text) / "file").parent
    except InputError:
        raise argparse.ArgumentTypeError(
            f"no file can be written into the folder {text}: choose another folder"
        ) from None


def add_arguments(parser: argparse.ArgumentParser, figure: str, table: str = "") -> None:
    """Add `--plot`, and `--csv` where there is a table; `figure` and `table` describe their contents in the help
    text."""
    parser.add_argument("--plot", metavar="FILE", type=output_file(*FIGURES), help=f"{figure}, as .png, .svg or .pdf")
    if table:
        parser.add_argument("--csv", metavar="FILE.csv", type=output_file(),
                            help=f"{table}, with units in the headings")


def save(found: Any, options: argparse.Namespace) -> None:
    """Write the figure (`--plot`) and the table (`--csv`) of a result."""
    if options.plot:
        figure = np.ravel(found.plot())[0].figure
        write_atomically(options.plot, partial(figure.savefig, dpi=150))
    if getattr(options, "csv", None):
        table = _real_columns(found)
        write_atomically(options.csv, lambda path: table.to_csv(path, index=False, lineterminator="\n"))


def present(command: Any, result: dict[str, Any], json_file: Path | None, written: Sequence[Path]) -> None:
    """Print the result as JSON if `json_file` is `-`; else write the JSON file, if one is given, and show the result.

    `written` are the files that the command wrote; they are listed at the end.
    """
    if json_file == STANDARD_OUTPUT:
        with _standard_output():
            print(to_json(result))
        return
    if json_file:
        write_text(json_file, to_json(result) + "\n")
    with _standard_output():
        screen = Screen()
        if hasattr(command, "show"):
            command.show(result, screen)
        for files in described(written):
            screen.print(f"written: {files}")


@contextmanager
def _standard_output() -> Iterator[None]:
    """Everything is written at the end. An error of the system gets the name of the output, which it lacks."""
    try:
        yield
        sys.stdout.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OSError(error.errno, error.strerror, error.filename or "standard output") from None


def described(written: Sequence[Path]) -> list[str]:
    """The files that were written and still exist; of a folder with more than MAX_LISTED, their number."""
    folders: dict[Path, list[Path]] = {}
    for path in dict.fromkeys(path for path in written if path.exists()):
        folders.setdefault(path.parent, []).append(path)
    return [line for folder, paths in folders.items()
            for line in (map(str, paths) if len(paths) <= MAX_LISTED
                         else [f"{len(paths)} files in {folder}"])]  # fmt: skip


def _real_columns(found: Any) -> Any:
    """The result's table without an index; complex columns are split in two, and headings end in the unit."""
    table, units = found.to_dataframe().reset_index(), {"frequency": "Hz", **getattr(found, "units", {})}
    table = table.drop(columns="index", errors="ignore")
    for name in list(table.columns):
        heading = f" [{units[name]}]" if name in units else ""
        if np.iscomplexobj(table[name].to_numpy()):
            place = table.columns.get_loc(name)
            column = table.pop(name).to_numpy()
            table.insert(place, f"{name} real{heading}", column.real)
            table.insert(place + 1, f"{name} imag{heading}", column.imag)
        elif heading:
            table = table.rename(columns={name: f"{name}{heading}"})
    return table
