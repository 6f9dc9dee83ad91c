"""Compliance checks of FMUs."""

import argparse
from typing import Any

from motofmi.cli.screen import Screen
from motofmi.workflows.check import check

SUMMARY = "compliance of FMUs of this and of other tools"
PLACE = 60
UNITS: dict[str, str] = {}
HELP = """Checks FMUs of this and of other tools against the FMI standard: the archive, its model description, its
binary, and its behaviour in short simulations, each in a process of its own. The exit status is 1 if an FMU has errors,
and 0 if it has only warnings.

  motofmi check rider_mean_2011.fmu
  motofmi check *.fmu --json problems.json
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fmus", nargs="+", metavar="FMU", help="the archives to check")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    return check(arguments.fmus).to_dict()


def exit_status(result: dict[str, Any]) -> int:
    return int(any(problem["severity"] == "error" for problem in result["problems"]))


def show(result: dict[str, Any], screen: Screen) -> None:
    paths = [result["fmu"]] if isinstance(result["fmu"], str) else result["fmu"]
    for path in paths:
        found = [problem for problem in result["problems"] if problem["fmu"] == path]
        errors = sum(problem["severity"] == "error" for problem in found)
        screen.print(f"{path}: {'clean' if not errors else f'{errors} error' + 's' * (errors > 1)}")
        for problem in found:
            screen.print(f"  {problem['severity']} {problem['check']}: {problem['message']} ({problem['where']})")
