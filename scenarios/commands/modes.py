"""Eigenvalues over speed and the named modes."""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from fmus.component import Component, in_bounds
from fmus.linear import StateSpace
from fmus.participation import participation
from fmus.ssp import read_ssp
from scenarios import names
from scenarios.ridden_fmus import over_speed_fmus, parts, ridden_fmus
from vehicle_fmu import MODES, modes, over_speed, ridden
from vehicle_fmu.mode_names import Linearised

HELP = """Eigenvalues over speed, named weave, wobble, capsize, rear wobble and rider-wobble, and where each is unstable.

  motofmi modes --vehicle sharp_1971 --device rider:mean_2011 --speed 1:60:0.5
  motofmi modes --vehicle reference_2011 --device damper:7.5 --speed 10,30,50
  motofmi modes --vehicle sharp_1971 --device rider:2_2011 --set arm_damping=30 --speed 1:60:1 --json modes.json
  motofmi modes --device rider:mean_2011,rider:roll_1971 --speed 5:60:5       (turns and leans)
  motofmi modes --vehicle sharp_1971 --fmu somebodys_rider.fmu --speed 1:60:1
  motofmi modes --ssp ridden.ssp --speed 10,30,50          (any wiring; adds which FMU takes part in which mode)
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--vehicle", default="sharp_1971", help="a motorcycle's NAME or a .toml (default: sharp_1971)")
    parser.add_argument("--device", default="none", help="rider:NAME, damper:NAME, damper:VALUE [N.m.s/rad], a .toml, a comma list of these, or none (default)")
    parser.add_argument("--speed", default="1:60:1", help="A:B:STEP, one value or a comma list [m/s] (default: 1:60:1)")
    parser.add_argument("--set", dest="settings", action="append", default=[], metavar="NAME=VALUE", help="change a parameter")
    parser.add_argument("--fmu", action="append", default=[], metavar="PATH", help="an FMU with the handlebar or the roll port instead of the vehicle or of the devices")
    parser.add_argument("--ssp", metavar="PATH", help="a system of FMUs, one of them with an input speed, instead of vehicle and device")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    speeds = names.numbers(arguments.speed, "speed", "m/s")
    if arguments.ssp:
        return of_ssp(arguments.ssp, speeds)
    vehicle, devices, assumed = parts(arguments)
    if isinstance(vehicle, Component):
        for speed in (speeds[0], speeds[-1]):
            in_bounds(speed, vehicle.table["speed"], vehicle.name)
    components = [d for d in devices if isinstance(d, Component)]
    if isinstance(vehicle, Component) and len(components) == len(devices):
        linearised = over_speed(ridden(vehicle, *components))
    else:
        linearised = over_speed_fmus(ridden_fmus(vehicle, devices))
    return as_result(modes(linearised, speeds), vehicle.name, ", ".join(d.name for d in devices) or "none", assumed)


def of_ssp(path: str, speeds: np.ndarray) -> dict[str, Any]:
    """The modes of the FMUs of an SSP archive and, by mode and FMU, the shares (n,) that they have in them."""
    units, wiring = read_ssp(path)
    linearised = over_speed_fmus(units, wiring)
    found = modes(linearised, speeds)
    shares: dict[str, dict[str, list[float | None]]] = {mode: {unit: [] for unit in units} for mode in found.unstable}
    for k, speed in enumerate(speeds):
        eigenvalues, participating = participation(space_at(linearised, speed))
        for mode, by_unit in shares.items():
            value = found[mode].eigenvalue[k]
            nearest = int(np.abs(eigenvalues - value).argmin())
            for unit, column in by_unit.items():
                column.append(None if np.isnan(value) else float(participating[unit][nearest]) if unit in participating else 0.0)
    for each in units.values():
        each.close()
    return {**as_result(found, Path(path).name, "none", {}), "participation": shares}


def space_at(linearised: Linearised, speed: float) -> StateSpace:
    """The state space at one speed [m/s]."""
    space = linearised(np.array([speed]))
    return replace(space, A=space.A[0], B=space.B[0], C=space.C[0], D=space.D[0])


def as_result(found, vehicle: str, device: str, assumed: dict[str, str]) -> dict[str, Any]:
    """The modes under the keys of the JSON file."""
    named = {
        mode: {"eigenvalue": list(found[mode].eigenvalue), "frequency": found[mode].frequency, "damping_ratio": found[mode].damping_ratio}
        for mode in MODES
    }
    return {"vehicle": vehicle, "device": device, "assumed": assumed, "speed": found.speed, "eigenvalues": found.eigenvalues,
            "modes": named, "unstable": found.unstable, "mixed": found.mixed}  # fmt: skip


def show(result: dict[str, Any], console: Console) -> None:
    table = Table(title=f"{result['vehicle']} with {result['device']}: damped frequency [Hz] and damping ratio, or real root [1/s]", box=None)
    present = [m for m in MODES if m in result["unstable"]]
    for heading in ("speed [m/s]", *(m.replace("_", "-") for m in present)):
        table.add_column(heading, justify="right")
    for k, speed in enumerate(result["speed"]):
        table.add_row(f"{speed:g}", *(_cell(result, mode, k, speed) for mode in present))
    console.print(table)
    for mode, bands in result["unstable"].items():
        text = ", ".join(f"{low:.1f} to {high:.1f}" for low, high in bands)
        console.print(f"{mode.replace('_', '-')}: {'unstable from ' + text + ' m/s' if bands else 'stable'}")
    for mode, shares in result.get("participation", {}).items():
        mean = {unit: np.mean([s for s in column if s is not None] or [0.0]) for unit, column in shares.items()}
        console.print(f"{mode.replace('_', '-')}: " + ", ".join(f"{unit} {100 * share:.0f} %" for unit, share in mean.items()) + " (mean over speed)")
    for parameter, reason in result["assumed"].items():
        console.print(f"assumed: {parameter} ({reason})")


def _cell(result: dict[str, Any], mode: str, k: int, speed: float) -> str:
    value = result["modes"][mode]["eigenvalue"][k]
    if np.isnan(value):
        return "-"
    mixed = mode in ("rider_wobble", "rear_wobble") and any(a - 1e-9 <= speed <= b + 1e-9 for a, b in result["mixed"])
    text = f"{value.imag / (2 * np.pi):.2f}, {-value.real / abs(value):.3f}" if value.imag > 0 else f"{value.real:.3f}"
    return text + (" (mixed)" if mixed else "")
