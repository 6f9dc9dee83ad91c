"""Eigenvalues and named modes over speed."""

import argparse
from collections.abc import Sequence
from typing import Any

import numpy as np

from fmus.support.errors import InputError
from motofmi.cli import component_arguments as given
from motofmi.cli import outputs
from motofmi.cli.arguments import assignments, numbers, units_of
from motofmi.cli.screen import Screen, grid_values, system
from motofmi.workflows.modes import ModesComparison, VehicleModes, compare_modes, modes, state_space
from vehicle_fmu import MODES

SUMMARY = "eigenvalues and named modes over speed"
PLACE = 30
UNITS = {
    "speed": "m/s",
    "eigenvalues": "1/s",
    "eigenvalue": "1/s",
    "frequency": "Hz",
    "damping_ratio": "1",
    "unstable": "m/s",
    "mixed": "m/s",
}
HELP = """Eigenvalues of a motorcycle with devices at its ports over speed: the modes weave, wobble, capsize,
rear-wobble and rider-wobble with damped frequency and damping ratio, and the speeds at which each is unstable.

  motofmi modes --vehicle sharp_1971 --device rider:mean_2011 --speed 1:60:0.5
  motofmi modes --device none --device rider:mean_2011 --device damper:7.5 --plot root_locus.png    # compared
  motofmi modes --device rider:2_2011 --set arm_damping=30 --json modes.json --csv modes.csv
  motofmi modes --device rider:mean_2011,rider:roll_1971 --speed 5:60:5      # one rider who steers and leans
  motofmi modes --device rider:mean_2011 --speed 20:40:5 --matlab bike.mat   # A, B, C, D over speed
  motofmi modes --fmu rider_of_another_tool.fmu --speed 1:60:1
  motofmi modes --ssp ridden.ssp --speed 10,30,50       # a system of FMUs, with participation factors of each FMU
"""
MIXED = ("(mixed): rear-wobble and rider-wobble are not distinct at this speed. They are named by the ratio of rear to "
         "front tyre side force, and the two ratios differ by less than a factor of two.")  # fmt: skip


def add_arguments(parser: argparse.ArgumentParser) -> None:
    given.add_vehicle(parser)
    parser.add_argument("--device", dest="devices", action="append", default=[], metavar="DEVICE",
                        help=f"{given.DEVICE} (default: none); repeatable, the modes with each are compared")  # fmt: skip
    parser.add_argument(
        "--speed", default="1:60:1", help="A:B:STEP, one value or a comma list [m/s] (default: %(default)s)"
    )
    given.add_settings(parser)
    given.add_archives(parser)
    given.add_ssp(parser)
    given.add_units(parser)
    parser.add_argument("--matlab", metavar="FILE.mat", type=outputs.output_file(".mat"),
                        help="matrices A, B, C, D of the linearised system for MATLAB (A(:, :, k) at speed(k)) and the "
                             "names of states, inputs and outputs; with one --device only")  # fmt: skip
    outputs.add_arguments(parser, "root locus", "eigenvalue, frequency and damping ratio of every mode over speed")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    if arguments.matlab and len(arguments.devices) > 1:
        raise InputError(
            f"--matlab writes one system, but {len(arguments.devices)} are given by --device: give --device once"
        )
    speeds, settings = numbers(arguments.speed, "speed", "m/s", zero=True), assignments(arguments.settings)
    found = _modes_of(arguments, speeds, settings)
    outputs.save(found, arguments)
    if arguments.matlab:
        _save_matlab(arguments, speeds, settings)
    return found.to_dict()


def _modes_of(
    arguments: argparse.Namespace, speeds: np.ndarray, settings: dict[str, float]
) -> VehicleModes | ModesComparison:
    units, systems = units_of(arguments.units), _systems(arguments)
    vehicle, devices = systems[0]
    if len(systems) == 1 or arguments.ssp:
        return modes(vehicle, devices, speeds, set=settings, ssp=arguments.ssp, units=units)
    return compare_modes(vehicle, [devices for _, devices in systems], speeds, set=settings, units=units)


def _systems(arguments: argparse.Namespace) -> list[tuple[Any, Any]]:
    """The vehicle with the devices of each `--device`."""
    return [given.vehicle_and_devices(arguments, devices, [None]) for devices in arguments.devices or [None]]


def _save_matlab(arguments: argparse.Namespace, speeds: np.ndarray, settings: dict[str, float]) -> None:
    """Write the linearised system: matrices of shape (n, m) at one speed, (n, m, speeds) at several."""
    at = speeds if len(speeds) > 1 else speeds[0]
    if arguments.ssp:
        space = state_space(ssp=arguments.ssp, speed=at, set=settings, units=units_of(arguments.units))
    else:
        vehicle, devices = _systems(arguments)[0]
        space = state_space(vehicle, devices, at, set=settings, units=units_of(arguments.units))
    space.save_matlab(arguments.matlab, {"speed": speeds})


def show(result: dict[str, Any], screen: Screen) -> None:
    if "devices" in result:
        for each in result["devices"].values():
            show(each, screen)
            screen.print()
        return
    present = [mode for mode in MODES if mode in result["unstable"]]
    rows = [
        (speed, *(_cell(result, mode, k) for mode in present)) for k, speed in enumerate(grid_values(result["speed"]))
    ]
    screen.table(("speed [m/s]", *(mode.replace("_", "-") for mode in present)), rows,
                 f"{system(result)}: damped frequency [Hz] and damping ratio [1], or real root [1/s]")  # fmt: skip
    if any("(mixed)" in cell for row in rows for cell in row):
        screen.print(MIXED)
    for mode, bands in result["unstable"].items():
        screen.print(f"{mode.replace('_', '-')}: {'unstable ' + ', '.join(map(_band, bands)) if bands else 'stable'}")
    for mode, shares in result.get("participation", {}).items():
        mean = {unit: np.mean([s for s in column if s is not None] or [0.0]) for unit, column in shares.items()}
        screen.print(f"{mode.replace('_', '-')}: "
                     + ", ".join(f"{unit} {100 * share:.0f} %" for unit, share in mean.items())
                     + " of the participation factors (mean over speed)")  # fmt: skip
    screen.assumed(result["assumed"])


def _band(ends: Sequence[float]) -> str:
    low, high = (f"{end:.1f}".removesuffix(".0") for end in ends)
    return f"at {low} m/s" if low == high else f"from {low} to {high} m/s"


def _cell(result: dict[str, Any], mode: str, k: int) -> str:
    value, speed = result["modes"][mode]["eigenvalue"][k], result["speed"][k]
    if np.isnan(value):
        return "-"
    mixed = mode in ("rider_wobble", "rear_wobble") and any(a - 1e-9 <= speed <= b + 1e-9 for a, b in result["mixed"])
    text = f"{value.imag / (2 * np.pi):.2f}, {-value.real / abs(value):.3f}" if value.imag > 0 else f"{value.real:.3f}"
    return text + (" (mixed)" if mixed else "")
