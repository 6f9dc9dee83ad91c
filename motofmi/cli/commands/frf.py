"""Frequency response functions from recordings."""

import argparse
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from motofmi.cli import recording_arguments as shared
from motofmi.cli.screen import Screen, grid_values
from motofmi.recordings.channels import MOCKUP_ACCELERATION
from motofmi.reports.frf_figures import amplitude_and_phase, roll, save
from motofmi.workflows.frf import FrequencyResponse, estimate_frf
from motofmi.workflows.measured import recordings_of
from motofmi.workflows.roll_frf import RollTest, estimate_roll_frf, interval

SUMMARY = "frequency response functions from recordings"
PLACE = 80
UNITS = {"frequency": "Hz", "inertance": "(rad/s2)/(N.m)", "standard_deviation": "(rad/s2)/(N.m)",
         "phase_standard_deviation_deg": "deg", "confidence_95": "(rad/s2)/(N.m)", "phase_confidence_95_deg": "deg",
         "coherence": "1", "receptance": "rad/(N.m)", "impedance": "N.m.s/rad", "frf": "1",
         "relative_frf": "1"}  # fmt: skip
HELP = """Estimates the inertance of rider and handlebar (angular acceleration over torque) from recordings of the steer
test: the mean and the standard deviation over the runs, or the estimate and its standard error of a single run. A
recording with a column mockup_acceleration is a roll test (2008); rig.json then gives the heights of its sensors.

  motofmi frf sweep_1.csv sweep_2.csv sweep_3.csv
  motofmi frf sweep.csv --reference steer_torque --json frf.json         # the published estimator
  motofmi frf lab.mf4 --map "Torque=steer_torque" --map "Pot=steer_angle [deg]" --plot frf.svg --report frf.html
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    shared.add_arguments(parser)


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    options = shared.checked(arguments)
    runs = recordings_of(arguments.files, options.mapping, arguments.rate)
    if MOCKUP_ACCELERATION in runs[0].columns:
        test = estimate_roll_frf(runs[0], rig=arguments.rig, band=options.band)
        return _written(test, roll(test.frf), arguments)
    frf = estimate_frf(runs, reference=arguments.reference, band=options.band, width=arguments.width)
    return _written(frf, amplitude_and_phase(frf.mean), arguments)


def _written(found: FrequencyResponse | RollTest, figure: Figure, arguments: argparse.Namespace) -> dict[str, Any]:
    if arguments.plot:
        save(figure, arguments.plot)
    if arguments.report:
        found.report(arguments.report)
    return found.to_dict()


def show(result: dict[str, Any], screen: Screen) -> None:
    if "features" in result:
        _show_roll(result, screen)
        return
    rows = [(f, f"{abs(value):.4f}", f"{deviation:.4f}", f"{np.degrees(np.angle(value)):.1f}", f"{turn:.1f}",
             f"{coherence:.3f}")
            for f, value, deviation, turn, coherence in zip(grid_values(result["frequency"]), *(result[k] for k in (
                "inertance", "standard_deviation", "phase_standard_deviation_deg", "coherence")),
                                                            strict=True)]  # fmt: skip
    count, of = len(result["runs"]), result["standard_deviation_of"]
    spread = (
        {True: "standard deviation over the runs", False: "standard error of the estimate"}.get(of[0] == "runs")
        if len(set(of)) == 1
        else "standard deviation"
    )
    screen.table(("f [Hz]", "modulus [(rad/s2)/(N.m)]", "sd of modulus [(rad/s2)/(N.m)]", "phase [deg]",
                  "sd of phase [deg]", "coherence [1]"), rows,
                 f"inertance, {'one run' if count == 1 else f'mean of {count} runs'}; sd: {spread}")  # fmt: skip
    screen.warnings(result["warnings"])


def _show_roll(result: dict[str, Any], screen: Screen) -> None:
    rows = [(f, *(text for point, curve in result["frf"].items()
                  for text in (f"{abs(curve[k]):.3f}", f"{abs(result['relative_frf'][point][k]):.3f}")))
            for k, f in enumerate(grid_values(result["frequency"]))]  # fmt: skip
    headings = [text for point in result["frf"] for text in (f"|FRF| {point} [1]", f"|FRF - 1| {point} [1]")]
    screen.table(("f [Hz]", *headings), rows, "roll test: ratio of the amplitude at each point to that of the mock-up")
    for feature in result["features"]:
        screen.print(f"{'met' if feature['met'] else 'NOT met':8}{feature['quantity']}, {feature['point']}: "
                     f"{feature['feature'].replace('_', ' ')} {interval(feature['measured'])} {feature['unit']} "
                     f"(printed: {interval(feature['printed'])})")  # fmt: skip
    screen.warnings(result["warnings"])
