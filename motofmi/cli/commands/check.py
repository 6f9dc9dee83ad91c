"""Compliance checks of FMUs."""

import argparse
from typing import Any

from fmus.checks.problem import SEVERITIES
from fmus.support.sandbox import Limits
from motofmi.cli.screen import Screen
from motofmi.workflows.check import check

SUMMARY = "compliance of FMUs of this and of other tools"
PLACE = 60
STYLES = {"error": "red", "warning": "yellow", "note": None}
UNITS: dict[str, str] = {}
HELP = """Checks FMUs of this and of other tools against the FMI standard: the archive, its description files, its
binaries, and its behaviour in short trials. Each trial runs in a process of its own with limited time, memory and file
size, on Linux without network. Severities:

  error      violates the standard, or fails in use
  warning    permitted by the standard, but harmful
  note       what was not checked, or what a user may want to know

The exit status is 1 if an FMU has errors, else 0.

  motofmi check rider_mean_2011.fmu
  motofmi check *.fmu --json problems.json
  motofmi check unknown.fmu --time-limit 10 --memory 1024
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fmus", nargs="+", metavar="FMU", help="the archives to check")
    parser.add_argument(
        "--time-limit",
        type=float,
        default=Limits.time,
        metavar="SECONDS",
        help="time of each trial [s] (default: %(default)g)",
    )
    parser.add_argument(
        "--memory",
        type=float,
        default=Limits.memory / 2**20,
        metavar="MIB",
        help="memory of each trial [MiB] (default: %(default)g)",
    )


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    return check(arguments.fmus, time_limit=arguments.time_limit, memory=arguments.memory).to_dict()


def exit_status(result: dict[str, Any]) -> int:
    return int(any(problem["severity"] == "error" for problem in result["problems"]))


def show(result: dict[str, Any], screen: Screen) -> None:
    paths = [result["fmu"]] if isinstance(result["fmu"], str) else result["fmu"]
    for path in paths:
        found = [problem for problem in result["problems"] if problem["fmu"] == path]
        counts = [(word, sum(problem["severity"] == word for problem in found)) for word in SEVERITIES]
        screen.print(
            f"{path}: {', '.join(f'{count} {word}' + 's' * (count > 1) for word, count in counts if count) or 'clean'}"
        )
        for problem in found:
            screen.print(
                f"  {problem['severity']} {problem['check']}: {problem['message']} ({problem['where']})",
                style=STYLES[problem["severity"]],
            )
            for line in _details(problem):
                screen.print(f"      {line}")


def _details(problem: dict[str, Any]) -> list[str]:
    """The call, what the FMU logged, and the section of the standard, where the problem has them."""
    call = " returned ".join(text for text in (problem["call"], problem["status"]) if text)
    said = [
        call,
        f"log: {problem['log']}" if problem["log"] else "",
        f"see {problem['section']}" if problem["section"] else "",
    ]
    return ["; ".join(text for text in said if text)] if any(said) else []
