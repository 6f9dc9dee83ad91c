"""Simulation of a single FMU."""

import argparse
from typing import Any

from motofmi.cli import outputs
from motofmi.cli.arguments import units_of, values_of
from motofmi.cli.component_arguments import add_units
from motofmi.cli.screen import Screen
from motofmi.workflows.cosimulation import simulate

SUMMARY = "simulation of a single FMU"
PLACE = 75
UNITS = {"step": "s", "steps_per_second": "1/s"}
HELP = """Simulates a single FMU of this or of another tool (FMI 2.0 or 3.0, co-simulation) and writes its inputs and
outputs over time as CSV: numbers, Booleans as 0 or 1, enumerations as the number of the item, arrays with a column for
each element, as y[1]. Inputs of other types than Real or Float64 keep their value and have no column; notes name them
and the outputs that cannot be written, such as texts. Where the FMU asks for the end of the simulation, the run ends.

  motofmi simulate rider_mean_2011.fmu --input steer.csv --duration 10    # columns: time [s], steer_angle [rad]
  motofmi simulate rider:mean_2011 --set arm_damping=20 --set torso_angle=0.1
  motofmi simulate other.fmu --set limited=true --set mode=fast --unit torque=N.m --plot run.png
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "fmu", metavar="FMU", help="an archive, or the name or .toml of a component that is built first"
    )
    parser.add_argument(
        "--input",
        metavar="FILE.csv",
        help="inputs over time: a column time [s] and columns named as inputs, interpolated linearly between the rows; "
        "separated by commas, or by semicolons with a decimal point or comma",
    )
    parser.add_argument(
        "--step", type=float, help="communication step [s] (default: as in the FMU's default experiment, else 0.001)"
    )
    parser.add_argument(
        "--start", type=float, help="time at which it begins [s] (default: as in the FMU's default experiment, else 0)"
    )
    parser.add_argument(
        "--duration", type=float, help="simulated time [s] (default: to the end of the FMU's default experiment, else 5)"
    )
    parser.add_argument(
        "--set",
        dest="settings",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a parameter of any type, a constant input or the start value of a state; repeatable",
    )
    parser.add_argument(
        "--out",
        "--csv",
        metavar="FILE.csv",
        type=outputs.output_file(),
        default="simulation.csv",
        help="file for every input and output over time (default: %(default)s)",
    )
    add_units(parser)
    outputs.add_arguments(parser, "every input and output over time")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    found = simulate(arguments.fmu, inputs=arguments.input, step=arguments.step, duration=arguments.duration,
                     set=values_of(arguments.settings), units=units_of(arguments.units), out=arguments.out,
                     start=arguments.start)  # fmt: skip
    outputs.save(found, arguments)
    return {"fmu": arguments.fmu, "rows": found.steps + 1, "out": str(found.path), "step": found.step,
            "steps": found.steps, "columns": found.columns, "steps_per_second": found.steps_per_second,
            "notes": list(found.notes)}  # fmt: skip


def show(result: dict[str, Any], screen: Screen) -> None:
    screen.print(
        f"{result['fmu']}: {result['steps']} steps of {result['step']:g} s, {result['steps_per_second']:,.0f} steps/s"
    )
    screen.warnings(result["notes"], "note")
