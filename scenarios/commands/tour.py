"""The main job on real input, from components to one report."""

import argparse
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

from rich.console import Console
from rich.table import Table

from fmus.progress import track
from scenarios import (
    can_the_missing_effect_be_found,
    does_the_rider_calm_the_wobble,
    how_near_are_the_papers,
    is_a_rider_a_damper,
    what_if_the_rider_is_swapped_for_a_damper,
    what_moves_in_each_mode,
)
from scenarios.report import Report

HELP = """The main job on real input, in under a minute: builds the FMUs of a motorcycle, a rider and a damper, co-simulates
them, swaps one for the other, compares the modes with the published ones, lets the gap workflow find an effect that a
virtual rig keeps secret, and writes one report that opens offline.

  motofmi tour
  motofmi tour --seed 7                    (another rider, another secret)
  motofmi tour --out results --json -
"""

REPORT = "report.html"
LEAD = ("Published riders, motorcycles and steering dampers, built as FMUs, co-simulated, and compared by their modes with what was "
        "printed. Every number below was computed by this run.")  # fmt: skip


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--out", default="tour", type=Path, metavar="DIR", help="where to (default: tour)")
    parser.add_argument("--seed", default=1, type=int, help="of the virtual rig's secret (default: 1)")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    out = arguments.out
    questions: list[tuple[str, Any, Callable[[], Any]]] = [
        ("root loci: rider, damper, changed damping", does_the_rider_calm_the_wobble, does_the_rider_calm_the_wobble.run),
        ("mode phasors", what_moves_in_each_mode, what_moves_in_each_mode.run),
        ("transfer functions of rider and dampers", is_a_rider_a_damper, is_a_rider_a_damper.run),
        ("FMUs built, co-simulated, rider swapped for damper", what_if_the_rider_is_swapped_for_a_damper,
         lambda: what_if_the_rider_is_swapped_for_a_damper.run(out)),
        ("a hidden effect, found in recordings", can_the_missing_effect_be_found,
         lambda: can_the_missing_effect_be_found.run(out, arguments.seed)),
        ("printed against computed", how_near_are_the_papers, how_near_are_the_papers.run),
    ]  # fmt: skip
    report, steps = Report("motofmi: the tour", LEAD), []
    for title, scenario, question in track(questions, "tour", len(questions)):
        start = perf_counter()
        section = scenario.section(question())
        report.sections.append(section)
        steps.append({"name": title, "seconds": perf_counter() - start, "answer": section.paragraphs[0]})
    start = perf_counter()
    report.write(out / REPORT)
    steps.append({"name": "report", "seconds": perf_counter() - start, "answer": f"{out / REPORT}"})
    return {"steps": steps, "report": REPORT, "out": str(out)}


def show(result: dict[str, Any], console: Console) -> None:
    table = Table(box=None)
    table.add_column("step")
    table.add_column("s", justify="right")
    table.add_column("answer")
    for step in result["steps"]:
        table.add_row(step["name"], f"{step['seconds']:.1f}", step["answer"])
    console.print(table)
    console.print(f"Open {Path(result['out']) / result['report']}")
