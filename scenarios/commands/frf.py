"""Frequency response functions from recordings."""

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from identification.frf import FRF, mean_frf
from scenarios import frf_figures, report
from scenarios import recordings_on_the_command_line as shared

NAME = "frf"
HELP = """Inertance of rider and handlebar, angular acceleration over torque, from recordings of the steer test: the mean
over the runs, with the standard deviation over the runs or, for a single run, the estimate's own standard error.

  motofmi frf sweep_1.csv sweep_2.csv sweep_3.csv
  motofmi frf sweep.csv --reference steer_torque --json papers_estimator.json
  motofmi frf lab.mf4 --map "Torque=steer_torque" --map "Pot=steer_angle [deg]" --plot frf.svg --report frf.html
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    shared.add_arguments(parser)


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    runs, _ = shared.recordings(arguments)
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
    table = Table(title=f"inertance, mean of {len(result['runs'])} runs", box=None)
    for heading in ("f [Hz]", "modulus [(rad/s2)/(N.m)]", "+-", "phase [deg]", "+-", "coherence"):
        table.add_column(heading, justify="right")
    rows = zip(*(result[k] for k in ("frequency", "inertance", "standard_deviation", "phase_standard_deviation_deg", "coherence")), strict=True)
    for f, value, deviation, turn, coherence in rows:
        table.add_row(f"{f:.3g}", f"{abs(value):.4f}", f"{deviation:.4f}", f"{np.degrees(np.angle(value)):.1f}", f"{turn:.1f}", f"{coherence:.3f}")
    console.print(table)
    for warning in result["warnings"]:
        console.print(f"warning: {warning}", style="yellow")
