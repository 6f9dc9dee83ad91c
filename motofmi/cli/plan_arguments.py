"""`motofmi gap --plan`: its options, and the plan as a table on the screen."""

import argparse
from typing import Any

import numpy as np

from fmus.support.errors import InputError
from motofmi.cli.arguments import assignments
from motofmi.cli.screen import Screen
from motofmi.workflows.gap.plan_experiment import HEADINGS, PICTURE, Plan, plan_experiment


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of `--plan` besides --rig, --rider, --effects and --out."""
    parser.add_argument(
        "--plan",
        action="store_true",
        help="before any test: print the magnitude from which each effect would be detected, and named, with this rig "
             "and noise",
    )
    parser.add_argument(
        "--sweep",
        action="append",
        default=[],
        metavar="FROM:TO",
        help="with --plan: first and last frequency of a sweep [Hz]; repeatable, one run each (default: 0.5:12)",
    )
    parser.add_argument(
        "--amplitude", type=float, default=2.0, help="with --plan: amplitude of the sweeps [deg] (default: %(default)g)"
    )
    parser.add_argument(
        "--duration", type=float, default=200.0, help="with --plan: duration of each sweep [s] (default: %(default)g)"
    )
    parser.add_argument(
        "--sampling", type=float, default=128.0, help="with --plan: sampling rate [Hz] (default: %(default)g)"
    )
    parser.add_argument("--gyro", action="store_true", help="with --plan: record a rate gyro on the torso too")
    parser.add_argument("--noise", action="append", default=[], metavar="NAME=VALUE",
                        help="with --plan: standard deviation of the noise: angle [deg], torque [N.m], remnant [N.m, "
                             "below 2 Hz] or gyro [rad/s] (default: 0.03, 0.2, 0.4, 0.01); repeatable")  # fmt: skip


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """The plan as a dictionary; with --out also written as plan.json and plan.png into that folder."""
    plan = plan_experiment(arguments.rig, [_range(text) for text in arguments.sweep or ["0.5:12"]],
                           rider=arguments.rider, amplitude=float(np.radians(arguments.amplitude)),
                           duration=arguments.duration, sampling=arguments.sampling, gyro=arguments.gyro,
                           noise=assignments(arguments.noise), effects=arguments.effects or ())  # fmt: skip
    if arguments.out:
        plan.save(arguments.out)
    return {**plan.to_dict(), "picture": PICTURE if arguments.out else None}


def show(result: dict[str, Any], screen: Screen) -> None:
    """Print the plan as a table."""
    plan = Plan(**{key: value for key, value in result.items() if key not in ("picture", "units")})
    runs = len(plan.runs)
    screen.print(f"{plan.rider}: {'one sweep' if runs == 1 else f'{runs} sweeps'} of {plan.duration:g} s at "
                 f"{np.degrees(plan.amplitude):g} deg"
                 f"{', with a torso gyro' if plan.gyro else ''}", style="bold")  # fmt: skip
    screen.table(HEADINGS, plan.rows)


def _range(text: str) -> tuple[float, float]:
    try:
        low, high = (float(x) for x in text.split(":"))
    except ValueError:
        raise InputError(f"--sweep {text}: expected FROM:TO in Hz, as in 0.5:12") from None
    return low, high
