"""Transfer functions of a device at its port, with the vehicle's other motion held at zero."""

import argparse
from typing import Any

import numpy as np

from motofmi.cli import outputs
from motofmi.cli.arguments import assignments, numbers
from motofmi.cli.component_arguments import add_settings
from motofmi.cli.screen import Screen, grid_values
from motofmi.workflows.device import PORTS, transfer_functions

SUMMARY = "transfer functions of a rider or damper at its port"
PLACE = 40
UNITS = {
    "frequency": "Hz",
    "handlebar_torque": "N.m/rad",
    "frame_torque": "N.m/rad",
    "roll_torque": "N.m/rad",
    "lateral_force": "N/rad",
}
HELP = """Transfer functions of a device at its port, with the vehicle's other motion held at zero. Rider or damper:
from the steer angle to the torques on the front assembly and on the rear frame, T_h/delta and T_f/delta (Cossalter et
al. 2011, eqs 10 to 14, with the signs of the port). Leaning rider: from the roll angle to the roll torque and the
lateral force on the frame, T_phi/phi and F/phi.

  motofmi device rider:mean_2011 --frequency 0.5:12:0.05 --plot bode.png
  motofmi device damper:7.5 --frequency 1,2,5 --csv damper.csv
  motofmi device rider:roll_1971 --json -
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("device", help="rider:NAME, damper:NAME, damper:VALUE [N.m.s/rad], or a .toml")
    parser.add_argument(
        "--frequency", default="0.5:12:0.5", help="A:B:STEP, one value or a comma list [Hz] (default: %(default)s)"
    )
    add_settings(parser)
    outputs.add_arguments(parser, "Bode diagram", "transfer functions, real and imaginary part")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    found = transfer_functions(
        arguments.device, numbers(arguments.frequency, "frequency", "Hz"), set=assignments(arguments.settings)
    )
    outputs.save(found, arguments)
    return found.to_dict()


def show(result: dict[str, Any], screen: Screen) -> None:
    curves = [
        (torque, unit)
        for _, port in PORTS
        for torque, unit in zip(port, ("N.m/rad", "N/rad" if "lateral_force" in port else "N.m/rad"), strict=True)
        if torque in result
    ]
    headings = [text for torque, unit in curves for text in (f"|{torque.replace('_', ' ')}| [{unit}]", "phase [deg]")]
    rows = [(f, *(text for torque, _ in curves
                  for text in (f"{abs(result[torque][k]):.4g}", f"{np.degrees(np.angle(result[torque][k])):.1f}")))
            for k, f in enumerate(grid_values(result["frequency"]))]  # fmt: skip
    screen.table(("f [Hz]", *headings), rows, f"{result['device']}: torque or force per angle")
    screen.assumed(result["assumed"])
