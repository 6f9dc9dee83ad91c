"""Co-simulation of the FMUs of a vehicle and its devices."""

import argparse
import warnings
from typing import Any

from fmus.cosimulation.cosimulate import TOLERANCE
from fmus.cosimulation.coupling import COUPLINGS
from fmus.cosimulation.coupling_error import ToleranceWarning
from motofmi.cli import component_arguments as given
from motofmi.cli import outputs
from motofmi.cli.arguments import assignments, units_of
from motofmi.cli.sandboxed import run_sandboxed
from motofmi.cli.screen import Screen, system
from motofmi.workflows.cosimulation import cosimulate

SUMMARY = "co-simulation of the FMUs of a vehicle and its devices"
PLACE = 70
RIDER = "rider:mean_2011"
UNITS = {"lean": "deg", "duration": "s", "step": "s", "shortest_step": "s", "longest_step": "s",
         "largest_stable_step": "s",
         "steps_per_second": "1/s", "frequency": "Hz", "damping_ratio": "1", "frequency_error": "1",
         "damping_error": "1", "real_error": "1/s", "power_residual": "W", "power": "W", "energy": "J",
         "exchanged": "J", "energy_error": "1"}  # fmt: skip
HELP = """Co-simulates the FMUs of a motorcycle and of the devices at its ports, and predicts the error that the
coupling causes in the frequency and damping ratio of every mode.

  motofmi cosimulate --vehicle sharp_1971 --device rider:mean_2011 --speed 30 --initial steer_rate=0.5 --out run.csv
  motofmi cosimulate --device damper:7.5 --speed 50 --step 0.01 --coupling jacobi --initial roll_angle=0.05
  motofmi cosimulate --input run.csv --step auto --duration 20    # columns: time [s], speed [m/s], steer_torque [N.m]
  motofmi cosimulate --fmu rider_of_another_tool.fmu --speed 30 --unit handlebar_torque=N.m
  motofmi cosimulate --vehicle tum_2020 --lean 30 --speed 30 --initial steer_rate=0.5     # starts in steady turning
  motofmi cosimulate --ssp ridden.ssp --speed 30     # a system of FMUs, also one of another tool

Couplings, the least costly first; without --coupling the first one with mode errors within the tolerance is used:
""" + "\n".join(f"  {c.name:20}{c.summary}; order {c.order}" for c in COUPLINGS.values())
RESIDUAL = ("Residual power: torque times rate as one FMU received it, minus torque times rate as the other FMU "
            "computed it, at the end of each step. Its integral over time is the energy that the coupling "
            "adds.")  # fmt: skip


def add_arguments(parser: argparse.ArgumentParser) -> None:
    given.add_vehicle(parser)
    parser.add_argument("--device", help=f"{given.DEVICE} (default: {RIDER}, or the --fmu with the port of a device)")
    given.add_archives(parser)
    given.add_ssp(parser)
    given.add_units(parser)
    parser.add_argument("--speed", type=float, help="forward speed [m/s] (default: 30)")
    parser.add_argument(
        "--lean",
        type=float,
        help="lean angle of the steady turning in which the run starts [deg], to the right positive; the vehicle is "
             "then in large motion (tum_2020), with the drive torque and the steer torque of motofmi trim",
    )
    parser.add_argument(
        "--step",
        default="0.001",
        help="communication step [s], or auto: controlled during the run by the residual power and the modes (default: "
             "%(default)s)",
    )
    parser.add_argument(
        "--duration", type=float, help="simulated time [s] (default: 5; of an .ssp as in its default experiment)"
    )
    parser.add_argument("--coupling", help="one of the couplings above (default: the first within the tolerance)")
    parser.add_argument(
        "--tolerance",
        type=float,
        default=TOLERANCE,
        help="admissible relative error of a mode's frequency; the admissible error of its damping ratio is ten times "
             f"larger (default: {TOLERANCE:g})",
    )
    parser.add_argument(
        "--initial",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="start value of a state, in SI units; repeatable",
    )
    given.add_settings(parser)
    parser.add_argument(
        "--input",
        metavar="FILE.csv",
        help="inputs over time: a column time [s] and columns named as inputs, interpolated linearly between the rows",
    )
    parser.add_argument(
        "--out",
        "--csv",
        metavar="FILE.csv",
        type=outputs.output_file(),
        help="file for every output over time (default: %(default)s)",
        default="cosimulation.csv",
    )
    parser.add_argument(
        "--sandbox",
        action="store_true",
        help="run in a process with limited time, memory and file size, on Linux without network, for FMUs that are "
             "not trusted; see docs/check.md for what this cannot prevent",
    )
    outputs.add_arguments(parser, "every output over time")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    if arguments.sandbox:
        return run_sandboxed(__name__, argparse.Namespace(**{**vars(arguments), "sandbox": False}))
    vehicle, devices = given.vehicle_and_devices(arguments, arguments.device, [RIDER])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ToleranceWarning)  # shown as `advice`
        found = cosimulate(
            vehicle, devices, speed=arguments.speed, duration=arguments.duration, step=_step(arguments.step),
            coupling=arguments.coupling, tolerance=arguments.tolerance, initial=assignments(arguments.initial),
            set=assignments(arguments.settings), inputs=arguments.input, ssp=arguments.ssp,
            units=units_of(arguments.units), out=arguments.out, lean=arguments.lean,
        )  # fmt: skip
    outputs.save(found, arguments)
    return found.to_dict()


def _step(given: str) -> float | str:
    """The step in seconds, or the text if it is no number (`auto`)."""
    try:
        return float(given)
    except ValueError:
        return given


def _lengths(result: dict[str, Any]) -> str:
    """The communication step [s] as text; of variable steps the shortest and the longest."""
    shortest, longest = result["shortest_step"], result["longest_step"]
    return f"{shortest:g}" if shortest == longest else f"{shortest:.3g} to {longest:.3g}"


def show(result: dict[str, Any], screen: Screen) -> None:
    limit = result["largest_stable_step"]
    screen.print(f"{system(result)}: {result['duration']:g} s in {result['steps']} steps of {_lengths(result)} s, "
                 f"coupling {result['coupling']}, {result['steps_per_second']:,.0f} steps/s")  # fmt: skip
    if result["predicted"]:
        rows = [(_mode(mode), f"{e['frequency']:.3f}", f"{e['damping_ratio']:.4f}",
                 *(f"{100 * e[k]:+.3g}" for k in ("frequency_error", "damping_error")), f"{e['real_error']:+.2g}")
                for mode, e in result["predicted"].items()]  # fmt: skip
        screen.table(("mode", "frequency [Hz]", "damping ratio [1]", "frequency error [%]", "damping error [%]",
                      "real-part error [1/s]"), rows,
                     "Predicted error of each mode by the coupling:")  # fmt: skip
    if limit is not None:
        screen.print(
            f"largest stable step {limit:.3g} s"
            + (" or more" if limit >= 1 else "")
            + ("" if result["stable"] else ": the coupling is UNSTABLE at this step")
        )
    if result["advice"]:
        screen.print(f"note: {result['advice']}")
    for name, bond in result["bonds"].items():
        screen.print(
            f"{name}: residual power up to {bond['power']:.3g} W, energy added by the coupling "
            f"{100 * bond['energy_error']:+.2g} % of {bond['exchanged']:.3g} J exchanged"
        )
    if result["bonds"]:
        screen.print(RESIDUAL)
    screen.assumed(result["assumed"])


def _mode(name: str) -> str:
    """A mode's name for the screen; a mode without a name has its frequency as key, as in `0.99_Hz`."""
    return f"unnamed mode, {name.replace('_', ' ')}" if name.endswith("_Hz") else name.replace("_", "-")
