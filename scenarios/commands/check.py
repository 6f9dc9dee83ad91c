"""Every compliance check there is, on ours and on other people's FMUs."""

import argparse
from pathlib import Path
from typing import Any

from rich.console import Console

from fmus.check import check
from fmus.errors import InputError
from fmus.progress import track

HELP = """Checks FMUs, also other people's: what the standard asks of the archive, of its model description and of its binary, and
how it behaves in a short run, in a process of its own. Clean means no error; exit status 1 when there are errors.

  motofmi check rider_mean_2011.fmu
  motofmi check *.fmu --json -
"""

def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fmus", nargs="+", metavar="FMU", help="the archives")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    paths = [Path(path) for path in arguments.fmus]
    for path in paths:
        if not path.is_file():
            raise InputError(f"there is no file {path}; give the path of an .fmu archive")
    problems = [{"fmu": str(path), **vars(problem)} for path in track(paths, "checking", len(paths)) for problem in check(path)]
    return {"fmu": str(paths[0]) if len(paths) == 1 else [str(path) for path in paths], "problems": problems}


def exit_status(result: dict[str, Any]) -> int:
    return int(any(problem["severity"] == "error" for problem in result["problems"]))


def show(result: dict[str, Any], console: Console) -> None:
    paths = [result["fmu"]] if isinstance(result["fmu"], str) else result["fmu"]
    for path in paths:
        found = [problem for problem in result["problems"] if problem["fmu"] == path]
        errors = sum(problem["severity"] == "error" for problem in found)
        console.print(f"{path}: {'clean' if not errors else f'{errors} error' + 's' * (errors > 1)}")
        for problem in found:
            console.print(f"  {problem['severity']} {problem['check']}: {problem['message']} ({problem['where']})")
