"""The main tasks in sequence, with one report."""

import argparse
from pathlib import Path
from typing import Any

from motofmi.cli.outputs import output_folder
from motofmi.cli.screen import Screen
from motofmi.workflows.tour import tour

SUMMARY = "the main tasks in one minute, with one report"
PLACE = 10
UNITS = {"seconds": "s"}
HELP = """Runs the main tasks in about a minute: builds FMUs of a motorcycle, a rider and a damper, co-simulates them,
exchanges the rider for the damper, compares the modes with published ones, finds an effect with the gap workflow in the
recordings of a simulated test rig, and writes one HTML report that needs no network.

  motofmi tour
  motofmi tour --seed 7 --out results          # another rider and another effect
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--out",
        default="tour",
        type=output_folder,
        metavar="DIR",
        help="folder for the report and the other files (default: %(default)s)",
    )
    parser.add_argument(
        "--seed",
        default=1,
        type=int,
        help="seed of the random rider and effect of the simulated test rig (default: %(default)s)",
    )


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    return tour(arguments.out, seed=arguments.seed).to_dict()


def show(result: dict[str, Any], screen: Screen) -> None:
    screen.table(
        ("step", "time [s]", "answer"), [(s["name"], f"{s['seconds']:.1f}", s["answer"]) for s in result["steps"]]
    )
    screen.print(f"Open {Path(result['out']) / result['report']}")
