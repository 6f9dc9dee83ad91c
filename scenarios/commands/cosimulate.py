"""The FMUs of a vehicle and a device, run together."""

import argparse
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from fmus.component import Component, in_bounds
from fmus.cosimulation import TOLERANCE, cosimulate, join
from fmus.coupling import COUPLINGS, Network, coupling
from fmus.errors import InputError
from fmus.prediction import largest_stable_step, linear_network
from fmus.profiles import Profile, read_profile
from scenarios import names
from scenarios.ridden_fmus import errors_by_mode, mode_names, parts, ridden_fmus

HELP = """Runs the FMUs of a vehicle and a device together, and says beforehand what the coupling does to the modes.

  motofmi cosimulate --vehicle sharp_1971 --device rider:mean_2011 --speed 30 --initial steer_rate=0.5 --out run.csv
  motofmi cosimulate --device damper:7.5 --speed 50 --step 0.01 --coupling jacobi --initial roll_angle=0.05
  motofmi cosimulate --input manoeuvre.csv --step auto --duration 20 --out run.csv     (columns: time, speed, steer_torque ...)
  motofmi cosimulate --device rider:mean_2011,rider:roll_1971 --speed 40      (turns and leans)
  motofmi cosimulate --vehicle sharp_1971 --fmu somebodys_rider.fmu --speed 30

Couplings, the cheapest first (without --coupling the first whose modes are within the tolerance):
""" + "\n".join(f"  {c.name:20}{c.summary}; order {c.order}" for c in COUPLINGS.values())


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--vehicle", default="sharp_1971", help="a motorcycle's NAME or a .toml (default: sharp_1971)")
    parser.add_argument("--device", default="rider:mean_2011", help="rider:NAME, damper:NAME, damper:VALUE [N.m.s/rad], a .toml, a comma list of these, or none (default: rider:mean_2011)")
    parser.add_argument("--fmu", action="append", default=[], metavar="PATH", help="an FMU with the handlebar or the roll port instead of the vehicle or of the devices")
    parser.add_argument("--speed", type=float, help="forward speed [m/s] (default: 30)")
    parser.add_argument("--step", default="0.001", help="communication step [s], or auto: it follows power and modes during the run (default: 0.001)")
    parser.add_argument("--duration", type=float, default=5.0, help="[s] (default: 5)")
    parser.add_argument("--coupling", help="one of the couplings above")
    parser.add_argument("--tolerance", type=float, default=TOLERANCE, help=f"error of a mode's frequency as a fraction, ten times that of its damping ratio (default: {TOLERANCE:g})")
    parser.add_argument("--initial", action="append", default=[], metavar="NAME=VALUE", help="start value of a state")
    parser.add_argument("--set", dest="settings", action="append", default=[], metavar="NAME=VALUE", help="change a parameter")
    parser.add_argument("--input", metavar="FILE.csv", help="inputs over time: a column time [s] and columns named after inputs, interpolated linearly")
    parser.add_argument("--out", metavar="FILE.csv", help="where the rows go (default: cosimulation.csv)", default="cosimulation.csv")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    if not (np.isfinite(arguments.tolerance) and arguments.tolerance > 0):
        raise InputError(f"tolerance = {arguments.tolerance:g}: a tolerance must be positive and finite, as in {TOLERANCE:g}")
    vehicle, devices, assumed = parts(arguments)
    initial = names.assignments(arguments.initial)
    times, columns = read_profile(arguments.input) if arguments.input else (np.zeros(1), {})
    if "speed" in columns and arguments.speed is not None:
        raise InputError(f"the speed is given twice: --speed {arguments.speed:g} and the column speed of {arguments.input}")
    speed = float(columns["speed"][0]) if "speed" in columns else 30.0 if arguments.speed is None else arguments.speed
    if isinstance(vehicle, Component):
        in_bounds(speed, vehicle.table["speed"], vehicle.name)
    units = ridden_fmus(vehicle, devices, initial, speed)
    wiring = join(units)
    profile = Profile.over_time(Network(units, wiring), times, columns)
    linear = linear_network(units, wiring)
    named = mode_names(units)
    run = cosimulate(units, _step(arguments.step), arguments.duration, arguments.coupling, wiring=wiring, profile=profile,
                     out=arguments.out, tolerance=arguments.tolerance)  # fmt: skip
    predicted = errors_by_mode(named, run.predicted) if run.predicted else {}
    for unit in units.values():
        unit.close()
    return {
        "vehicle": vehicle.name, "device": ", ".join(d.name for d in devices) or "none", "assumed": assumed, "file": str(run.path), "duration": arguments.duration,
        "step": run.step, "steps": run.steps, "shortest_step": run.shortest, "longest_step": run.longest, "coupling": run.coupling, "steps_per_second": run.steps_per_second, "predicted": predicted,
        "stable": run.predicted.stable if run.predicted else None, "largest_stable_step": largest_stable_step(coupling(run.coupling), linear),
        "power_residual": run.power_residual,
        "bonds": {bond.name: {"power": bond.power, "energy": bond.energy, "exchanged": bond.exchanged, "energy_error": bond.energy_error} for bond in run.bonds},
    }  # fmt: skip


def _step(given: str) -> float | str:
    """Seconds, or what else was written."""
    try:
        return float(given)
    except ValueError:
        return given


def _lengths(result: dict[str, Any]) -> str:
    """The length of the steps [s], or the shortest and the longest."""
    shortest, longest = result["shortest_step"], result["longest_step"]
    return f"{shortest:g}" if shortest == longest else f"{shortest:.3g} to {longest:.3g}"


def show(result: dict[str, Any], console: Console) -> None:
    limit = result["largest_stable_step"]
    console.print(f"{result['vehicle']} with {result['device']}: {result['duration']:g} s in {result['steps']} steps of {_lengths(result)} s, "
                  f"coupling {result['coupling']}, {result['steps_per_second']:,.0f} steps/s")  # fmt: skip
    table = Table(title="What the coupling does to the modes, predicted", box=None)
    for heading in ("mode", "frequency [Hz]", "damping ratio", "error of frequency [%]", "of damping [%]", "of real part [1/s]"):
        table.add_column(heading, justify="right", no_wrap=heading == "mode")
    for mode, e in result["predicted"].items():
        table.add_row(mode.replace("_", "-"), f"{e['frequency']:.3f}", f"{e['damping_ratio']:.4f}", *(f"{100 * e[k]:+.3g}" for k in ("frequency_error", "damping_error")), f"{e['real_error']:+.2g}")
    console.print(table)
    if limit is not None:
        console.print(f"largest stable step {limit:.3g} s" + (" or more" if limit >= 1 else "") + ("" if result["stable"] else ": the coupling is UNSTABLE at this step"))
    for name, bond in result["bonds"].items():
        console.print(f"{name}: residual power up to {bond['power']:.3g} W, energy made {100 * bond['energy_error']:+.2g} % of {bond['exchanged']:.3g} J exchanged")
    console.print(f"written: {result['file']}")
    for parameter, reason in result["assumed"].items():
        console.print(f"assumed: {parameter} ({reason})")
