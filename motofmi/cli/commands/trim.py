"""Steady turning at a speed, lean angles and accelerations: equilibrium and named modes."""

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
    "longitudinal_acceleration": "m/s2",
    "eigenvalues": "1/s",
    "eigenvalue": "1/s",
    "frequency": "Hz",
    "damping_ratio": "1",
}
HELP = """Equilibrium of a motorcycle in a corner at a speed and lean angles: steer angle, the steer torque that the
rider applies, yaw rate, travel of the suspensions, loads, forces, slip and camber angles of the tyres; and the modes
about it, named as in straight running and followed over the lean angle. With --longitudinal-acceleration the motorcycle
accelerates or brakes so slowly that nothing but its speed changes. Where no equilibrium exists the message says where it
ends, and why. Freedoms are locked by --set: front_suspension=0, rear_suspension=0, fork_lengthwise_bending=0,
front_tyre_deflection=0, rear_tyre_deflection=0, front_longitudinal_slip=0, rear_longitudinal_slip=0.

  motofmi trim --vehicle tum_2020 --speed 30 --lean 30
  motofmi trim --device rider:mean_2011 --speed 30 --lean 0:45:5 --plot corner.png --csv corner.csv
  motofmi trim --speed 20 --lean=-30,30 --set fork_bending=0
  motofmi trim --speed 30 --lean 20 --longitudinal-acceleration=-6:4:1
"""
ANGLES = (
    "steer_angle",
    "rear_suspension",
    "front_slip_angle",
    "rear_slip_angle",
    "front_camber_angle",
    "rear_camber_angle",
)


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
    parser.add_argument(
        "--longitudinal-acceleration",
        default="0",
        help="A:B:STEP, one value or a comma list [m/s2], as many as lean angles, or one of them "
        "(default: %(default)s)",
    )
    add_settings(parser)
    outputs.add_arguments(parser, "root locus over lean angle and acceleration", "equilibrium and modes at every point")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    found = trim(
        arguments.vehicle,
        separate(arguments.device),
        speed=arguments.speed,
        lean=numbers(arguments.lean, "lean", "deg", -np.inf),
        longitudinal_acceleration=numbers(
            arguments.longitudinal_acceleration, "longitudinal-acceleration", "m/s2", -np.inf
        ),
        set=assignments(arguments.settings),
    )
    outputs.save(found, arguments)
    return found.to_dict()


def show(result: dict[str, Any], screen: Screen) -> None:
    heads = [("lean [deg]", *grid_values(result["lean"]))]
    if np.any(result["longitudinal_acceleration"]):
        heads.append(("acceleration [m/s2]", *grid_values(result["longitudinal_acceleration"])))
    columns = [(name, "deg" if name in ANGLES else unit) for name, unit in QUANTITIES.items()]
    rows = [(f"{name.replace('_', ' ')} [{unit}]", *(_number(name, x) for x in result[name])) for name, unit in columns]
    title = f"{system(result)} at {result['speed']:g} m/s"
    screen.table(heads[0], [*heads[1:], *rows], f"{title}: steady turning")
    rows = [(mode.replace("_", "-"), *map(_eigenvalue, found["eigenvalue"])) for mode, found in result["modes"].items()]
    screen.table(heads[0], [*heads[1:], *rows], "Damped frequency [Hz] and damping ratio [1], or real root [1/s]")
    screen.assumed(result["assumed"])


def _number(name: str, value: float) -> str:
    value = float(np.degrees(value)) if name in ANGLES else value
    if name == "residual":
        return f"{value:.1e}"
    if name.endswith(("suspension", "deflection", "slip")) and name not in ANGLES:
        return f"{value:.5f}"
    return f"{value:.1f}" if abs(value) >= 100 else f"{round(value, 3) + 0.0:.3f}"  # + 0.0: no -0.000


def _eigenvalue(value: complex) -> str:
    if np.isnan(value):
        return "-"
    return f"{value.imag / (2 * np.pi):.2f}, {-value.real / abs(value):.3f}" if value.imag > 0 else f"{value.real:.3f}"
