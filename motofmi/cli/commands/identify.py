"""A rider's parameters from recordings."""

import argparse
from typing import Any

from fmus.support.errors import InputError
from fmus.support.files import writable
from motofmi.cli import batch_arguments as batches
from motofmi.cli import recording_arguments as shared
from motofmi.cli.screen import Screen
from motofmi.identification.parameter_fit import METHODS
from motofmi.workflows.identify import identify, residuals, rows, save_drawn_riders, toml_path
from motofmi.workflows.measured_rider import PARAMETERS
from rider_fmu.rigs.handlebar import HANDLEBAR_INERTIA

SUMMARY = "parameters of a rider from recordings"
PLACE = 90
UNITS = {
    "radius": "(rad/s2)/(N.m)",
    "phase_deg": "deg",
    "handlebar_inertia": "kg.m2",
    "reduced_chi_square": "1",
    "run_to_run": "1",
}
HELP = """Identifies the six parameters of the passive rider, with standard errors, from recordings of the steer test.
The result can be written as a .toml, which build, modes and cosimulate accept.

  motofmi identify sweep_1.csv sweep_2.csv --out mine.toml
  motofmi identify sweep.csv --method nyquist --bound steer_inertia=0.125:1 --plot fit.png --report fit.html
  motofmi identify rider_1.csv rider_2.csv rider_3.csv --mean --out mean_rider.toml    # mean FRF of several riders
  motofmi identify sweep.csv --bootstrap 1000 --population 20 --out riders        # 20 random riders, fitted covariance
  motofmi identify --batch recordings --out batch            # every recording of a folder: one table of parameters
  motofmi identify --population 20 --out riders              # 20 random riders, spread of 2011
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    shared.add_arguments(parser, files="*")
    parser.add_argument(
        "--method",
        choices=METHODS,
        default="weighted",
        help="weighted by the variance of the FRF (default), nyquist as in the 2011 paper, or amplitude as in the 2008 "
             "paper",
    )
    parser.add_argument(
        "--mean",
        action="store_true",
        help="fit the mean FRF of several riders, one recording each, instead of the runs of one rider",
    )
    parser.add_argument(
        "--bound",
        dest="bounds",
        action="append",
        default=[],
        metavar="NAME=LOW:HIGH",
        help="bounds of a parameter, in SI units; repeatable",
    )
    parser.add_argument(
        "--starts", type=int, default=4, help="number of starting values of the fit (default: %(default)s)"
    )
    parser.add_argument(
        "--handlebar-inertia",
        type=float,
        metavar="KG.M2",
        help=f"inertia of the bare handlebar [kg.m2] (default: of rig.json, else {HANDLEBAR_INERTIA})",
    )
    parser.add_argument(
        "--run-to-run",
        type=float,
        metavar="SHARE",
        help="relative standard deviation of the rider's FRF from run to run, as a fraction (default: estimated from "
             "the runs)",
    )
    parser.add_argument(
        "--bootstrap",
        type=int,
        default=0,
        metavar="N",
        help="also estimate the standard errors by N fits to resampled data (bootstrap), on all cores",
    )
    parser.add_argument(
        "--population",
        type=int,
        default=0,
        metavar="N",
        help="draw N random riders and write a .toml of each into the folder --out",
    )
    parser.add_argument(
        "--seed", type=int, default=0, help="seed of the starting values and of the draws (default: %(default)s)"
    )
    batches.add_arguments(parser)
    parser.add_argument(
        "--out", metavar="FILE.toml", help="file for the rider; with --population the folder for the riders"
    )


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    _check(arguments)
    if not arguments.files and not arguments.batch:
        return {"population": save_drawn_riders(arguments.out, arguments.population, arguments.seed)}
    options = shared.checked(arguments)
    bounds = {
        _known(name): shared.limits(text, f"--bound {name}=")
        for name, _, text in (b.partition("=") for b in arguments.bounds)
    }
    given = {"method": arguments.method, "mapping": options.mapping, "rate": arguments.rate, "rig": arguments.rig,
                 "reference": arguments.reference, "band": options.band, "width": arguments.width,
                 "mean": arguments.mean, "bounds": bounds, "starts": arguments.starts,
                 "handlebar_inertia": arguments.handlebar_inertia, "run_to_run": arguments.run_to_run,
                 "bootstrap": arguments.bootstrap, "seed": arguments.seed}  # fmt: skip
    if arguments.batch:
        return batches.run("identify", arguments, given)
    found = identify(arguments.files, **given)
    result = found.to_dict()
    if arguments.population:
        result["population"] = found.save_population(arguments.out, arguments.population, arguments.seed)
    elif arguments.out:
        found.save(arguments.out)
        result["rider"] = arguments.out
    if arguments.plot:
        found.save_plot(arguments.plot)
    if arguments.report:
        found.report(arguments.report)
    return result


def _check(arguments: argparse.Namespace) -> None:
    if arguments.batch:
        if arguments.population:
            raise InputError("--batch and --population are given: expected one of them")
        return
    if not arguments.files and not arguments.population:
        raise InputError("identify needs recordings, or --population N to draw riders from the published distribution")
    if arguments.population and not arguments.out:
        raise InputError("--population needs --out FOLDER for the riders' files")
    for option in ("starts", "bootstrap", "population"):
        if getattr(arguments, option) < (option == "starts"):
            raise InputError(f"--{option} {getattr(arguments, option)} is too small: expected at least "
                             f"{int(option == 'starts')}")
    if arguments.out:
        writable(f"{arguments.out}/rider_001.toml" if arguments.population else toml_path(arguments.out))


def _known(name: str) -> str:
    if name not in PARAMETERS:
        raise InputError(f"--bound {name!r}: no such parameter (valid: {', '.join(PARAMETERS)})")
    return name


def show(result: dict[str, Any], screen: Screen) -> None:
    if "reasons" in result:
        batches.show(result, screen)
        return
    if "parameters" not in result:
        return
    screen.table(("parameter", "value", "standard error", "unit"), rows(result),
                 f"rider identified from {', '.join(result['runs'])} ({result['method']})")  # fmt: skip
    screen.print(residuals(result))
    screen.warnings(result["warnings"])
