"""A rider's parameters from recordings."""

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from fmus.errors import InputError
from identification.bootstrap import bootstrap
from identification.fit import METHODS, Identification, identify
from identification.frf import mean_frf
from identification.response import Response
from scenarios import frf_figures, report
from scenarios import recordings_on_the_command_line as shared
from scenarios.command_line import write_text
from scenarios.measured_rider import (
    HANDLEBAR_INERTIA,
    PARAMETERS,
    derived_with_errors,
    qualified,
    rider_toml,
    rig_response,
    table_spread,
    write_population,
)

NAME = "identify"
HELP = """The six parameters of the passive rider from recordings of the steer test, with standard errors, and a rider's file
that build, modes and cosimulate take at once.

  motofmi identify sweep_1.csv sweep_2.csv --out mine.toml
  motofmi identify sweep.csv --method nyquist --bound steer_inertia=0.125:1 --plot fit.png --report fit.html
  motofmi identify sweep_*.csv --bootstrap 1000 --json fit.json
  motofmi identify rider_1.csv rider_2.csv rider_3.csv --mean --out mean_rider.toml
  motofmi identify --population 20 --out riders/        (20 riders from the spread of the 2011 paper's ten)
  motofmi identify sweep.csv --population 20 --out riders/        (20 riders from the fitted covariance)
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    shared.add_arguments(parser, files="*")
    parser.add_argument("--method", choices=METHODS, default="weighted", help="weighted by the estimate's own variance (default), or as in 2011, 2008")
    parser.add_argument("--mean", action="store_true", help="fit the mean FRF of different riders instead of runs of one rider")
    parser.add_argument("--bound", dest="bounds", action="append", default=[], metavar="NAME=LOW:HIGH", help="bounds of a parameter")
    parser.add_argument("--starts", type=int, default=4, help="starting values (default: 4)")
    parser.add_argument("--handlebar-inertia", type=float, metavar="KG.M2", help="inertia of the bare bar (default: rig.json, or 0.125)")
    parser.add_argument("--run-to-run", type=float, metavar="SHARE", help="how much the rider differs from run to run (default: from the runs)")
    parser.add_argument("--bootstrap", type=int, default=0, metavar="N", help="repeat the fit N times on resampled data, on all cores")
    parser.add_argument("--population", type=int, default=0, metavar="N", help="draw N riders and write them into the folder --out")
    parser.add_argument("--seed", type=int, default=0, help="of starting values and draws (default: 0)")
    parser.add_argument("--out", metavar="FILE.toml", help="the rider's file; with --population a folder")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    _check(arguments)
    if not arguments.files:
        source = "Drawn from the spread of the ten riders of Cossalter, Doria, Lot, Massaro, Meccanica 46 (2011), Table 2"
        return {"population": write_population(table_spread(arguments.population, arguments.seed), HANDLEBAR_INERTIA, Path(arguments.out), source)}
    runs, rig = shared.recordings(arguments)
    each = shared.frfs(runs, arguments)
    model = rig_response()
    bounds = {qualified(_known(name)): shared.limits(text, f"--bound {name}=") for name, _, text in (b.partition("=") for b in arguments.bounds)}
    found = identify([mean_frf(each)] if arguments.mean else each, model, arguments.method, bounds, arguments.starts, arguments.seed,
                     arguments.run_to_run)  # fmt: skip
    handlebar = arguments.handlebar_inertia or rig.get("handlebar_inertia", {}).get("value", HANDLEBAR_INERTIA)
    result = as_result(found, handlebar)
    result["runs"] = [run.name for run in runs]
    if arguments.bootstrap:
        draws = bootstrap(found, model, arguments.bootstrap, arguments.seed, bounds)
        low, high = np.percentile(draws, [2.5, 97.5], axis=0)
        result["bootstrap"] = {name: {"standard_error": float(s), "interval_95": [float(a), float(b)], "unit": unit}
                               for name, unit, s, a, b in zip(PARAMETERS, found.units, draws.std(axis=0, ddof=1), low, high, strict=True)}  # fmt: skip
    _write(arguments, found, model, handlebar, result)
    return result


def _check(arguments: argparse.Namespace) -> None:
    if not arguments.files and not arguments.population:
        raise InputError("identify needs recordings, or --population N to draw riders from the published spread")
    if arguments.population and not arguments.out:
        raise InputError("--population needs --out FOLDER for the riders' files")
    if arguments.out and not arguments.population and Path(arguments.out).suffix != ".toml":
        raise InputError(f"--out {arguments.out}: a rider's file ends in .toml")
    for option in ("starts", "bootstrap", "population"):
        if getattr(arguments, option) < (option == "starts"):
            raise InputError(f"--{option} {getattr(arguments, option)} is too small")


def _known(name: str) -> str:
    if name not in PARAMETERS:
        raise InputError(f"--bound {name!r}: no such parameter (valid: {', '.join(PARAMETERS)})")
    return name


def as_result(found: Identification, handlebar: float) -> dict[str, Any]:
    """The identification under the keys of the JSON file."""
    values = zip(PARAMETERS, found.values, found.standard_error, found.units, strict=True)
    return {
        "method": found.method,
        "parameters": {name: {"value": float(v), "standard_error": float(e), "unit": unit} for name, v, e, unit in values},
        "derived": derived_with_errors(found, handlebar),
        "residual": found.residual,
        "handlebar_inertia": handlebar,
        "reduced_chi_square": found.reduced_chi_square,
        "run_to_run": found.run_to_run,
        "correlation": found.correlation,
        "singular_values": found.singular_values,
        "agreeing_starts": found.agreeing_starts,
        "warnings": [w.replace("bar.", "").replace("rider.", "") for w in found.warnings],
    }


def _write(arguments: argparse.Namespace, found: Identification, model: Response, handlebar: float, result: dict[str, Any]) -> None:
    source = f"Identified from {', '.join(result['runs'])} ({found.method})"
    if arguments.population:
        draws = found.draws(arguments.population, arguments.seed)
        result["population"] = write_population(draws, handlebar, Path(arguments.out), f"{source}; drawn from the fitted covariance")
    elif arguments.out:
        write_text(Path(arguments.out), rider_toml(found, handlebar, "Measured rider, steer test", source))
        result["rider"] = arguments.out
    if arguments.plot or arguments.report:
        curve = frf_figures.fitted_curve(found, model)
        figures = [frf_figures.amplitude_and_phase(mean_frf(found.frfs), curve), frf_figures.nyquist(found, curve)]
        if arguments.plot:
            frf_figures.save(figures, arguments.plot)
        if arguments.report:
            captions = ("Amplitude and phase, measured and fitted.", "Measured points and fitted curve in the Nyquist plane.")
            table = report.Table(("parameter", "value", "standard error", "unit"), _rows(result["parameters"]) + _rows(result["derived"]))
            sections = [report.Section("Parameters", [_residuals(result), *result["warnings"]], [], [table]),
                        report.Section("Fit", [], list(zip(figures, captions, strict=True)))]  # fmt: skip
            report.Report("Identified rider", source, sections).write(Path(arguments.report))


def _rows(entries: dict[str, dict[str, Any]]) -> list[tuple[str, str, str, str]]:
    return [(name, "overdamped" if e["value"] is None else f"{e['value']:.5g}", "" if e["standard_error"] is None else f"{e['standard_error']:.2g}",
             e["unit"]) for name, e in entries.items()]  # fmt: skip


def _residuals(result: dict[str, Any]) -> str:
    return (f"mean distance of the radii {result['residual']['radius']:.4f} (rad/s2)/(N.m), of the phases {result['residual']['phase_deg']:.2f} deg; "
            f"reduced chi-square {result['reduced_chi_square']:.3g}")  # fmt: skip


def show(result: dict[str, Any], console: Console) -> None:
    if "parameters" in result:
        table = Table(title=f"rider identified from {', '.join(result['runs'])} ({result['method']})", box=None)
        for heading in ("", "value", "standard error", "unit"):
            table.add_column(heading, justify="right" if heading in ("value", "standard error") else "left")
        for row in _rows(result["parameters"]) + _rows(result["derived"]):
            table.add_row(*row)
        console.print(table)
        console.print(_residuals(result))
        for warning in result["warnings"]:
            console.print(f"warning: {warning}", style="yellow")
    for name in ("rider", "population"):
        if name in result:
            written = result[name]
            console.print(f"written: {written if isinstance(written, str) else f'{len(written)} riders in {written[0].parent}'}")
