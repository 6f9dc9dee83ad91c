"""Frequency response functions from recordings."""

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from identification.frf import FRF, mean_frf
from identification.recordings import Recording
from identification.roll import REFERENCE, roll_frf
from rider_fmu.roll_features import FEATURES, readings
from scenarios import frf_figures, report
from scenarios import recordings_on_the_command_line as shared

NAME = "frf"
HELP = """Inertance of rider and handlebar, angular acceleration over torque, from recordings of the steer test: the mean
over the runs, with the standard deviation over the runs or, for a single run, the estimate's own standard error.

  motofmi frf sweep_1.csv sweep_2.csv sweep_3.csv
  motofmi frf sweep.csv --reference steer_torque --json papers_estimator.json
  motofmi frf roll.csv      (mockup_acceleration and others: the roll test of 2008, with heights in rig.json)
  motofmi frf lab.mf4 --map "Torque=steer_torque" --map "Pot=steer_angle [deg]" --plot frf.svg --report frf.html
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    shared.add_arguments(parser)


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    runs, rig = shared.recordings(arguments)
    if REFERENCE in runs[0].columns:
        return roll(runs[0], rig, arguments)
    each = shared.frfs(runs, arguments)
    mean = mean_frf(each)
    if arguments.plot:
        frf_figures.save([frf_figures.amplitude_and_phase(mean)], arguments.plot)
    result = as_result(mean, each)
    if arguments.report:
        section = report.Section("Inertance", [f"{len(each)} runs, cross-spectra with {mean.reference}.", *result["warnings"]],
                                 [(frf_figures.amplitude_and_phase(mean), "Amplitude and phase, as in Fig. 3 of the 2011 paper.")])  # fmt: skip
        report.Report("Frequency response function", f"From {', '.join(run.name for run in runs)}.", [section]).write(Path(arguments.report))
    return result


def roll(run: Recording, rig: dict[str, Any], arguments: argparse.Namespace) -> dict[str, Any]:
    """FRF_i and rFRF_i of a roll test (2008, eqs 6 to 12) at steps of 0.25 Hz, and the published features."""
    low, high = shared.limits(arguments.band, "--band")
    frequencies = np.arange(low, min(high, 7.0) + 1e-9, 0.25)
    heights = {name.removesuffix("_height"): entry["value"] for name, entry in rig.items() if name.endswith("_height")}
    frf = roll_frf(run, heights, frequencies)
    if arguments.plot:
        frf_figures.save([frf_figures.roll(frf)], arguments.plot)
    features: list[dict[str, Any]] = [
        {"quantity": f.quantity, "point": f.point, "feature": f.name, "printed": [f.low, f.high], "measured": [low, high], "unit": f.unit,
         "met": bool(f.low <= low and high <= f.high)}
        for f, (low, high) in zip(FEATURES, readings(frf.absolute, frf.frequency), strict=True)
    ]  # fmt: skip
    if arguments.report:
        rows = [(f"{f['quantity']}, {f['point']}", f["feature"].replace("_", " "), *(_range(f[k]) for k in ("printed", "measured")), f["unit"],
                 "met" if f["met"] else "missed") for f in features]  # fmt: skip
        section = report.Section("Roll test", list(run.warnings), [(frf_figures.roll(frf), "As in Figs 16 to 23 of the 2008 paper.")],
                                 [report.Table(("FRF", "feature", "printed", "measured", "unit", ""), rows, marks=[r[-1] for r in rows])])  # fmt: skip
        report.Report("Roll test", f"From {run.name}.", [section]).write(Path(arguments.report))
    return {"runs": [run.name], "frequency": frf.frequency, "frf": frf.absolute, "relative_frf": frf.relative,
            "features": features, "warnings": list(run.warnings)}  # fmt: skip


def _range(ends: list[float]) -> str:
    return f"{ends[0]:.3g}" if ends[0] == ends[1] else f"{ends[0]:.3g} to {ends[1]:.3g}"


def as_result(mean: FRF, each: list[FRF]) -> dict[str, Any]:
    """The FRF under the keys of the JSON file; deviations are of the modulus, and in degrees of the phase."""
    modulus, phase = mean.confidence(1.0)
    repeated = np.isfinite(mean.modulus_deviation)
    confidence = mean.confidence()
    return {
        "runs": [f.name for f in each],
        "reference": mean.reference,
        "frequency": mean.frequency,
        "inertance": mean.inertance,
        "standard_deviation": np.where(repeated, mean.modulus_deviation, modulus),
        "phase_standard_deviation_deg": np.degrees(np.where(repeated, mean.phase_deviation, phase)),
        "standard_deviation_of": ["runs" if r else "estimate" for r in repeated],
        "confidence_95": confidence[0],
        "phase_confidence_95_deg": np.degrees(confidence[1]),
        "coherence": mean.coherence,
        "receptance": mean.receptance,
        "impedance": mean.impedance,
        "warnings": shared.warnings_of(each),
    }


def show(result: dict[str, Any], console: Console) -> None:
    if "features" in result:
        show_roll(result, console)
        return
    grid = Table(title=f"inertance, mean of {len(result['runs'])} runs", box=None)
    for heading in ("f [Hz]", "modulus [(rad/s2)/(N.m)]", "+-", "phase [deg]", "+-", "coherence"):
        grid.add_column(heading, justify="right")
    rows = zip(*(result[k] for k in ("frequency", "inertance", "standard_deviation", "phase_standard_deviation_deg", "coherence")), strict=True)
    for f, value, deviation, turn, coherence in rows:
        grid.add_row(f"{f:.3g}", f"{abs(value):.4f}", f"{deviation:.4f}", f"{np.degrees(np.angle(value)):.1f}", f"{turn:.1f}", f"{coherence:.3f}")
    console.print(grid)
    for warning in result["warnings"]:
        console.print(f"warning: {warning}", style="yellow")


def show_roll(result: dict[str, Any], console: Console) -> None:
    grid = Table(title="roll test: |FRF|, |FRF - 1|", box=None)
    for heading in ("f [Hz]", *result["frf"]):
        grid.add_column(heading, justify="right")
    for k, f in enumerate(result["frequency"]):
        grid.add_row(f"{f:.3g}", *(f"{abs(curve[k]):.3f}, {abs(result['relative_frf'][point][k]):.3f}" for point, curve in result["frf"].items()))
    console.print(grid)
    for feature in result["features"]:
        console.print(f"{'met' if feature['met'] else 'NOT met':8}{feature['quantity']}, {feature['point']}: {feature['feature'].replace('_', ' ')} "
                      f"{_range(feature['measured'])} {feature['unit']} (printed: {_range(feature['printed'])})")  # fmt: skip
    for warning in result["warnings"]:
        console.print(f"warning: {warning}", style="yellow")
