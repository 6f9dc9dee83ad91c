"""Steady turning at a speed and lean angles: equilibrium and named modes."""

import argparse
from typing import Any

import numpy as np

from motofmi.cli import outputs
from motofmi.cli.arguments import assignments, numbers, separate
from motofmi.cli.component_arguments import DEVICE, add_settings
from motofmi.cli.screen import Screen, grid_values, system
from motofmi.workflows.trim import QUANTITIES, trim

SUMMARY = "steady turning at a speed and lean angles: equilibrium and modes"
PLACE = 31
UNITS = {
    **QUANTITIES,
    "speed": "m/s",
    "lean": "deg",
    "eigenvalues": "1/s",
    "eigenvalue": "1/s",
    "frequency": "Hz",
    "damping_ratio": "1",
}
HELP = """Equilibrium of a motorcycle in a corner at a speed and lean angles: steer angle, the steer torque that the
rider applies, yaw rate, loads, side forces, slip and camber angles of the tyres; and the modes about it, named as in
straight running and followed over the lean angle. The motorcycle is rigid in its plane: suspensions and tyres do not
deflect under their load. Where no equilibrium exists the message says at which lean angle it ends, and why.

  motofmi trim --vehicle tum_2020 --speed 30 --lean 30
  motofmi trim --device rider:mean_2011 --speed 30 --lean 0:45:5 --plot corner.png --csv corner.csv
  motofmi trim --speed 20 --lean=-30,30 --set fork_bending=0
"""
ANGLES = ("steer_angle", "front_slip_angle", "rear_slip_angle", "front_camber_angle", "rear_camber_angle")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--vehicle",
        default="tum_2020",
        help="a motorcycle with equations in large motion: a NAME of motofmi list, or a .toml (default: %(default)s)",
    )
    parser.add_argument("--device", default="none", help=f"{DEVICE} (default: none)")
    parser.add_argument("--speed", type=float, required=True, help="speed [m/s]")
    parser.add_argument(
        "--lean", required=True, help="A:B:STEP, one value or a comma list [deg], to the right positive"
    )
    add_settings(parser)
    outputs.add_arguments(parser, "root locus over the lean angle", "equilibrium and modes at every lean angle")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    found = trim(
        arguments.vehicle,
        separate(arguments.device),
        speed=arguments.speed,
        lean=numbers(arguments.lean, "lean", "deg", -np.inf),
        set=assignments(arguments.settings),
    )
    outputs.save(found, arguments)
    return found.to_dict()


def show(result: dict[str, Any], screen: Screen) -> None:
    leans = grid_values(result["lean"])
    columns = [(name, "deg" if name in ANGLES else unit) for name, unit in QUANTITIES.items()]
    rows = [(f"{name.replace('_', ' ')} [{unit}]", *(_number(name, x) for x in result[name])) for name, unit in columns]
    title = f"{system(result)} at {result['speed']:g} m/s"
    screen.table(("lean [deg]", *leans), rows, f"{title}: steady turning")
    rows = [(mode.replace("_", "-"), *map(_eigenvalue, found["eigenvalue"])) for mode, found in result["modes"].items()]
    screen.table(("lean [deg]", *leans), rows, "Damped frequency [Hz] and damping ratio [1], or real root [1/s]")
    screen.assumed(result["assumed"])


def _number(name: str, value: float) -> str:
    value = float(np.degrees(value)) if name in ANGLES else value
    if name == "residual":
        return f"{value:.1e}"
    return f"{value:.1f}" if abs(value) >= 100 else f"{round(value, 3) + 0.0:.3f}"  # + 0.0: no -0.000


def _eigenvalue(value: complex) -> str:
    if np.isnan(value):
        return "-"
    return f"{value.imag / (2 * np.pi):.2f}, {-value.real / abs(value):.3f}" if value.imag > 0 else f"{value.real:.3f}"
