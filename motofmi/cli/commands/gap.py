"""The gap between a model and measured data, and the physical effect that the model lacks."""

import argparse
from typing import Any

import numpy as np

from fmus.support.errors import InputError
from motofmi.cli import batch_arguments as batches
from motofmi.cli import plan_arguments as planning
from motofmi.cli.arguments import mapping_of
from motofmi.cli.outputs import output_folder
from motofmi.cli.screen import Screen
from motofmi.reports.gap_summary import bars, headline, laws, nearest, next_run
from motofmi.reports.gap_tables import RUNS, candidates, compared, places
from motofmi.workflows.gap.find_gap import find_gap

# Numbers (8 bytes each) in an array that is allocated and freed once, before the fits. The GNU C library then keeps the
# memory of smaller freed arrays for reuse instead of returning it to the system. On a steer test of two pairs of runs
# of 12 s the system time fell from 2.7 to 1.5 s.
LARGE_ARRAY = 4_000_000
SUMMARY = "the physical effect that a model lacks, from measured data"
PLACE = 100
UNITS = {"delta_chi2": "1", "delta_bic": "1", "probability": "1", "excess": "1", "p_value": "1", "before": "1",
         "after": "1", "holdout_before": "1", "holdout_after": "1", "noise_floor": "1", "expected_delta_chi2": "1",
         "speed": "m/s", "frequency": "Hz", "damping_ratio": "1", "amplitude": "rad", "duration": "s"}  # fmt: skip
HELP = """Finds where a model deviates from measured data and which physical effect of the library explains the
deviation. Adds the effect to the model and compares the misfit before and after. The verdict is named (one effect or
pair explains the data), none (the model is consistent with the noise), unknown (no effect of the library explains the
data) or tied (several effects explain the data equally well). verdict.json, the report, the model and its FMU are
written into the folder --out.

Recordings of the steer test:
  motofmi gap sweep_up.csv stepped.csv --holdout sweep_down.csv --out gap
  motofmi gap sweep.csv --bare bare_bar.csv --rig my_rig.json --rider 3_2011
  motofmi gap --plan --sweep 0.5:12 --sweep 12:0.5 --amplitude 2       # before any test: detectable effects
Eigenvalues or runs of a vehicle:
  motofmi gap eigenvalues.csv --vehicle sharp_1971 --holdout others.csv
  motofmi gap run_1.csv run_2.csv --vehicle bicycle_at_4.toml --holdout run_3.csv
Inputs and outputs of a component:
  motofmi gap run.csv --component driven_joint --map "T=torque [N.m]" --holdout other.csv
  motofmi gap run.csv --component mass_spring_damper --impose displacement
Every test of a folder, or of a manifest with a row for each test:
  motofmi gap --batch recordings --component driven_joint --out batch     # runs.parquet, runs.csv, a folder per test
A verdict from what is known after a minute:
  motofmi gap run.csv --component driven_joint --holdout other.csv --time 60
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", nargs="*", metavar="FILE", help="recordings to fit, one run each")
    parser.add_argument(
        "--holdout",
        "--validation",
        nargs="+",
        action="extend",
        default=[],
        metavar="FILE",
        help="validation runs: recordings that are not fitted; the result is compared with them",
    )
    parser.add_argument(
        "--bare",
        nargs="+",
        action="extend",
        default=[],
        metavar="FILE",
        help="sweeps of the handlebar without a rider, from which its inertia, damping and stiffness are estimated",
    )
    parser.add_argument("--rig", metavar="FILE", help="rig.json (default: the one beside the first recording)")
    parser.add_argument(
        "--rider",
        default="mean_2011",
        metavar="NAME",
        help="published rider whose parameters are the starting values of the fit (default: %(default)s)",
    )
    parser.add_argument(
        "--map",
        action="append",
        default=[],
        metavar="COLUMN=VARIABLE",
        help='variable of a column, with its unit where the file gives none, as in "T=torque [N.m]", and a minus where '
        'its sign is reversed, as in "T=-torque"; repeatable',
    )
    parser.add_argument(
        "--rate",
        type=float,
        metavar="HZ",
        help="sampling rate [Hz] to which faster recordings are reduced while they are read",
    )
    parser.add_argument(
        "--tolerance",
        type=float,
        metavar="PER_CENT",
        help="misfit (rms, as a share of the measured rms) [%%] up to which the model is called sufficient if the "
             "noise is not known (default: 1)",
    )
    parser.add_argument(
        "--time",
        type=float,
        metavar="SECONDS",
        help="time budget of the search [s], as in --time 60: at its end the verdict is that of what is known by then, "
             "and a limitation says what was not done; the report follows (default: no limit)",
    )
    parser.add_argument("--effects", metavar="DIR", help="folder with Python files of further effects")
    parser.add_argument(
        "--vehicle",
        metavar="NAME",
        help="a motorcycle: a NAME of motofmi list, or a .toml; the files then hold its eigenvalues over speed, "
             "or recorded runs",
    )
    parser.add_argument(
        "--device",
        default="none",
        help="device at the vehicle's handlebar during the runs: rider:NAME, damper:VALUE [N.m.s/rad] or none "
             "(default: %(default)s)",
    )
    parser.add_argument(
        "--component",
        metavar="NAME|PATH.py:CLASS",
        help="the component whose inputs and outputs were recorded: mass_spring_damper, driven_joint, pendulum, "
             "two_mass, a .toml, or a Component class in a Python file",
    )
    parser.add_argument(
        "--impose",
        metavar="VARIABLE",
        help="state of the component (displacement or angle) that was imposed while the force or torque was measured",
    )
    parser.add_argument(
        "--free",
        nargs="+",
        action="extend",
        default=[],
        metavar="NAME",
        help="parameters to fit without a prior value",
    )
    planning.add_arguments(parser)
    batches.add_arguments(parser)
    parser.add_argument(
        "--out",
        metavar="DIR",
        type=output_folder,
        help="folder for verdict.json, model and report (default: gap; with --plan nothing is written without it)",
    )


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    if arguments.plan:
        return planning.run(arguments)
    given = {"component": arguments.component, "vehicle": arguments.vehicle, "device": arguments.device,
                 "rider": arguments.rider, "rig": arguments.rig, "impose": arguments.impose, "free": arguments.free,
                 "mapping": mapping_of(arguments.map), "effects": arguments.effects or (), "rate": arguments.rate,
                 "tolerance": None if arguments.tolerance is None else arguments.tolerance / 100,
                 "time": arguments.time}  # fmt: skip
    if arguments.batch:
        return batches.run("gap", arguments, given)
    if not arguments.files:
        raise InputError("gap needs recordings: motofmi gap FILE.csv [...] --holdout FILE.csv --out DIR")
    np.empty(LARGE_ARRAY)
    found = find_gap(arguments.files, validation=arguments.holdout, bare=arguments.bare, out=arguments.out or "gap",
                     **given)  # fmt: skip
    return found.to_dict()


def show(result: dict[str, Any], screen: Screen) -> None:
    if "reasons" in result:
        batches.show(result, screen)
        return
    if "verdict" not in result:
        planning.show(result, screen)
        return
    screen.print(headline(result), style="bold")
    for line in (*laws(result), *nearest(result), *bars(result)):
        screen.print(line)
    for effect in result["effects"]:
        screen.print(f"{effect['name']} ({effect['form']}): {effect['sentence']}")
    for table in (candidates(result, most=8), compared(result)):
        if table.rows:
            screen.table(table.headings, table.rows)
    gap = result["gap"]
    for name, label in RUNS.items():
        if gap[name] is not None:
            # A comparison of losses does not rest on the noise, by which chi-square weighs the frequencies.
            chi2 = "" if result["compared"] else f"reduced chi-square {gap[name]:.3f} (noise floor 1), "
            screen.print(f"{label:>23}: {chi2}rms {gap['rms'][name]:.3g} {gap['rms']['unit']}")
    if result["where"]:
        clearest = places(result, most=6)
        screen.table(clearest.headings, clearest.rows, "where the base deviates from the data")
    if proposed := next_run(result):
        screen.print(f"next experiment: {proposed}")
    screen.warnings(result["limitations"], "limitation")
