"""Transfer functions of a device at its port, the vehicle's other motion held still."""

import argparse
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from fmus.component import Component
from fmus.errors import InputError
from fmus.linear import linearise
from fmus.ports import TORQUES
from fmus.roll_port import FLOWS
from scenarios import names

HELP = """Transfer functions T_h/delta and T_f/delta of a rider or damper, from the steer angle to the torques on the
front assembly and on the rear frame, with the frame held still (2011, eqs 10 to 14; the port's signs); of a rider who
leans T_phi/phi and F/phi, from the roll angle to the roll torque and the lateral force on the frame.

  motofmi device rider:mean_2011 --frequency 0.5:12:0.05
  motofmi device damper:7.5 --frequency 1,2,5 --json -
  motofmi device rider:roll_1971
"""
PORTS = (("steer", tuple(TORQUES)), ("roll", FLOWS))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("device", help="rider:NAME, damper:NAME, damper:VALUE [N.m.s/rad] or a .toml")
    parser.add_argument("--frequency", default="0.5:12:0.5", help="A:B:STEP, one value or a comma list [Hz]")
    parser.add_argument("--set", dest="settings", action="append", default=[], metavar="NAME=VALUE", help="change a parameter")


def transfer_functions(device: Component, frequency: np.ndarray) -> dict[str, np.ndarray]:
    """Torques and forces at the device's port per angle [N.m/rad, N/rad], complex (n,), at frequencies (n,) in Hz."""
    space = linearise(device)
    omega = 2 * np.pi * np.asarray(frequency, float)
    motion, torques = next(port for port in PORTS if port[1][0] in device.outputs)
    return {torque: space.frequency_response(omega, torque, f"{motion}_angle") + 1j * omega * space.frequency_response(omega, torque, f"{motion}_rate")
            for torque in torques}  # fmt: skip


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    given = names.device(arguments.device)
    if given is None:
        raise InputError("device 'none' has no transfer functions (valid: rider:NAME, damper:NAME, damper:VALUE)")
    (device,) = names.with_settings({"device": given}, names.assignments(arguments.settings))
    assert device is not None
    frequency = names.numbers(arguments.frequency, "frequency", "Hz")
    return {"device": device.name, "assumed": device.assumed, "frequency": frequency, **transfer_functions(device, frequency)}


def show(result: dict[str, Any], console: Console) -> None:
    table = Table(title=f"{result['device']}: torque or force per angle", box=None)
    table.add_column("f [Hz]", justify="right")
    curves = [(torque, unit) for _, port in PORTS for torque, unit in zip(port, ("N.m/rad", "N/rad" if "lateral_force" in port else "N.m/rad"), strict=True) if torque in result]
    for torque, unit in curves:
        table.add_column(f"|{torque.replace('_', ' ')}| [{unit}]", justify="right")
        table.add_column("phase [deg]", justify="right")
    for f, *values in zip(result["frequency"], *(result[torque] for torque, _ in curves), strict=True):
        table.add_row(f"{f:.3g}", *(text for z in values for text in (f"{abs(z):.4g}", f"{np.degrees(np.angle(z)):.1f}")))
    console.print(table)
    for parameter, reason in result["assumed"].items():
        console.print(f"assumed: {parameter} ({reason})")
