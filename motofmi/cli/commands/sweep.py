"""Studies over vehicles, devices, speeds, parameters and populations."""

import argparse
import sys
from pathlib import Path
from typing import Any

from fmus.support.errors import InputError
from motofmi.cli.component_arguments import DEVICE, VEHICLE
from motofmi.cli.outputs import output_folder
from motofmi.cli.screen import Screen
from motofmi.studies.population import DESIGNS
from motofmi.workflows.sweep.kinds import KINDS
from motofmi.workflows.sweep.study import Study
from motofmi.workflows.sweep.sweep import OUT, Prepared

SUMMARY = "studies over vehicles, devices, speeds, parameters and populations of riders"
PLACE = 75
UNITS = {"runs": "1", "failed": "1"}
HELP = """Runs every combination of vehicles, devices, speeds, parameter values and members of populations, on all cores
or on a Dask cluster. The results go into the folder --out: an xarray Dataset in Zarr (results.zarr) and a table with a
row for each run (runs.parquet). A run that fails is recorded with its reason. Started again, an interrupted study goes
on from what is complete.

  motofmi sweep --device damper:7.5 --set rider~riders_2011 --speed 1:60:1 --out riders
  motofmi sweep --vehicle sharp_1971 reference_2011 --device none rider:mean_2011 --set trail=0.08:0.12:9 --out trail
  motofmi sweep --set rider~mine.toml --set steering_damping~0:10 --count 1024 --design latin_hypercube --out mine
  motofmi sweep study.toml --scheduler tcp://host:8786 --out study

A study as a file has the same keys:

  kind = "modes"
  vehicle = "sharp_1971"
  device = ["none", "damper:7.5"]
  speed = "1:60:1"
  count = 100
  [set]
  rider = "~riders_2011"
  trail = "0.08:0.12:9"
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("study", nargs="?", metavar="STUDY.toml", help="the study; options change its keys")
    parser.add_argument("--kind", choices=list(KINDS), help="kind of run (default: modes)")
    parser.add_argument("--vehicle", nargs="+", action="extend", metavar="VEHICLE",
                        help=f"motorcycles (default: {VEHICLE})")  # fmt: skip
    parser.add_argument("--device", nargs="+", action="extend", metavar="DEVICE",
                        help=f"one or several of: {DEVICE} (default: none)")  # fmt: skip
    parser.add_argument("--speed", metavar="A:B:STEP", help="speeds [m/s] (default: 1:60:1)")
    parser.add_argument("--set", dest="settings", action="append", default=[], metavar="NAME=A:B:N|NAME~POPULATION",
                        help="values of a parameter: N values from A to B, a comma list, or NAME~A:B for members of a "
                             "range; rider~riders_2011 or rider~FILE.toml for a population of riders; "
                             "repeatable")  # fmt: skip
    parser.add_argument("--count", type=int, help="number of members of populations (default: 100)")
    parser.add_argument("--design", choices=DESIGNS, help="how members are drawn: at random, as a Latin hypercube, as "
                        "a Sobol sequence (default), or the published members themselves")  # fmt: skip
    parser.add_argument("--seed", type=int, help="seed of the members (default: 0)")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="Dask scheduler, as in tcp://host:8786 (default: "
                        "processes of this machine)")  # fmt: skip
    parser.add_argument("--workers", type=int, metavar="N", help="processes of this machine (default: all cores)")
    parser.add_argument("--plan", action="store_true", help="print the number of runs and the time, and run nothing")
    parser.add_argument("--report", action="store_true", help="also write report.html: stability maps, quantiles, "
                        "sensitivities, worst runs, with links into an explore page beside it")  # fmt: skip
    parser.add_argument("--out", type=output_folder, metavar="DIR", default=Path(OUT),
                        help="folder of the study (default: %(default)s)")  # fmt: skip


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    prepared = Prepared.of(_study(arguments), arguments.out)
    estimate = prepared.estimate(arguments.workers)
    if arguments.plan:
        return {"runs": prepared.runs.grid.runs, "estimate": estimate}
    print(estimate, file=sys.stderr)
    found = prepared.run(arguments.scheduler, arguments.workers,
                         lambda address: print(f"dashboard: {address}", file=sys.stderr))  # fmt: skip
    return {**found.to_dict(), **({"report": str(found.report())} if arguments.report else {})}


def _study(arguments: argparse.Namespace) -> Study:
    """The study of the file and the options, which come before the keys of the file."""
    given = {key: getattr(arguments, key) for key in ("kind", "vehicle", "device", "speed", "count", "design", "seed")
             if getattr(arguments, key) is not None}  # fmt: skip
    settings = _settings(arguments.settings)
    if settings:
        given["set"] = settings
    return Study.read(arguments.study, **given) if arguments.study else Study.of(given)


def _settings(texts: list[str]) -> dict[str, str]:
    """Values by parameter, from texts NAME=VALUES and NAME~POPULATION. Raises InputError for any other text."""
    found: dict[str, str] = {}
    for text in texts:
        place = min((text.index(sign) for sign in "=~" if sign in text), default=0)
        name, value = text[:place].strip(), text[place:].lstrip("=").strip()
        if not name or not value.strip("~"):
            raise InputError(f"--set {text!r} is neither NAME=VALUES nor NAME~POPULATION, as in trail=0.08:0.12:9 or "
                             "rider~riders_2011")  # fmt: skip
        if name in found:
            raise InputError(f"--set {name} is given twice")
        found[name] = value
    return found


def show(result: dict[str, Any], screen: Screen) -> None:
    if "estimate" in result:
        screen.print(result["estimate"])
        return
    screen.print(f"{result['runs']:,} runs, {result['failed']:,} failed")
    screen.print(f"results: {result['store']}, table: {result['table']}")
