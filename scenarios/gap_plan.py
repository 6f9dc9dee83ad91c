"""What a steer test that is planned could find: every effect with the strength from which it could be named.

    motofmi gap --plan --rig rig.json --rider mean_2011 --sweep 0.5:12 --amplitude 2 --duration 200 --gyro
"""

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from rich.console import Console
from rich.table import Table

from fmus.errors import InputError
from identification.excitation import sweep
from identification.gap.models.model import Model
from identification.gap.naming.fitting import fit
from identification.gap.proposing.nameable import Nameable, nameable
from identification.gap.proposing.planned import Channels, planned
from identification.gap.stands.test_stand import TestStand
from identification.recordings import read_rig
from scenarios.command_line import to_json, write_text
from scenarios.names import assignments
from scenarios.report import COLOURS, new_figure
from scenarios.rig_test import GYRO, GYRO_NOISE, rig_effects, rig_test

FILE, PICTURE = "plan.json", "plan.png"
NOISE = {"angle": 0.03, "torque": 0.2, "remnant": 0.4, "gyro": GYRO_NOISE}  # deg, N.m, N.m below 2 Hz, rad/s
REMNANT_BAND = 2.0  # Hz


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """What `--plan` takes besides --rig, --rider, --effects and --out."""
    parser.add_argument("--plan", action="store_true", help="before any test: what could be named, at which strength, with this rig and these noises")
    parser.add_argument("--sweep", action="append", default=[], metavar="FROM:TO", help="with --plan: a sweep [Hz], once per run (default: 0.5:12)")
    parser.add_argument("--amplitude", type=float, default=2.0, help="with --plan: of the sweeps [deg] (default: 2)")
    parser.add_argument("--duration", type=float, default=200.0, help="with --plan: of each sweep [s] (default: 200)")
    parser.add_argument("--sampling", type=float, default=128.0, help="with --plan: samples per second [Hz] (default: 128)")
    parser.add_argument("--gyro", action="store_true", help="with --plan: a rate gyro on the torso is recorded too")
    parser.add_argument("--noise", action="append", default=[], metavar="NAME=VALUE", help="with --plan: angle [deg], torque [N.m], "
                        "remnant [N.m, below 2 Hz] or gyro [rad/s] (default: 0.03, 0.2, 0.4, 0.01)")  # fmt: skip


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """The plan, also as plan.json and a picture in the --out folder. Raises InputError for what cannot be planned."""
    stand = rig_test(read_rig(arguments.rig) if arguments.rig else {}, arguments.rider)
    noise = _noise(arguments.noise, stand)
    model = Model(stand)
    sweeps = [_range(text) for text in arguments.sweep or ["0.5:12"]]
    excitations = [sweep(a, b, arguments.duration, float(np.radians(arguments.amplitude))) for a, b in sweeps]
    channels = Channels(arguments.sampling, float(np.radians(noise["angle"])), _spectrum(noise, arguments.sampling),
                        {GYRO: noise["gyro"]} if arguments.gyro else {})  # fmt: skip
    runs = [planned(e, channels, stand.columns, lambda run: model.outputs(run, model.start(), slopes=False)[0], seed) for seed, e in enumerate(excitations)]
    found = nameable(fit(model, runs, model.start()), rig_effects(arguments.effects))
    folder = Path(arguments.out)
    result = {
        "rider": arguments.rider, "amplitude": float(np.radians(arguments.amplitude)), "duration": arguments.duration, "gyro": arguments.gyro,
        "runs": [{"from": a, "to": b} for a, b in sweeps], "noise": noise,
        "effects": [{"name": n.effect.family, "form": n.effect.form, "parameter": n.parameter, "unit": n.unit, "noticed_from": n.noticed,
                     "named_from": n.named, "nearest_rival": n.rival, "tied": list(n.tied)} for n in found],
        "picture": PICTURE,
    }  # fmt: skip
    write_text(folder / FILE, to_json(result) + "\n")
    figure(found).savefig(folder / PICTURE, dpi=130, metadata={"Software": None})
    return result


def _noise(given: list[str], stand: TestStand) -> dict[str, float]:
    noise = {**NOISE, "gyro": stand.further[GYRO].noise, **assignments(given)}
    for name, value in noise.items():
        if name not in NOISE:
            raise InputError(f"--noise {name}={value:g}: expected one of {', '.join(NOISE)}")
        if not value >= 0:
            raise InputError(f"--noise {name}={value:g}: a deviation cannot be negative")
    return noise


def _range(text: str) -> tuple[float, float]:
    try:
        low, high = (float(x) for x in text.split(":"))
    except ValueError:
        raise InputError(f"--sweep {text}: expected FROM:TO in Hz, as in 0.5:12") from None
    return low, high


def _spectrum(noise: dict[str, float], rate: float):
    """Density of the torque's noise, as a variance per sample: white, and the remnant below its band."""
    share = rate / 2 / REMNANT_BAND / (np.pi / 4)  # the remnant's power lies in a small part of the band

    def density(f: np.ndarray) -> np.ndarray:
        return noise["torque"] ** 2 + noise["remnant"] ** 2 * share / (1 + (f / REMNANT_BAND) ** 2) ** 2

    return density


def figure(found: list[Nameable]) -> Figure:
    """How much more than to be noticed each effect needs to be named; those that are tied have no bar."""
    picture, axes = new_figure(width=7, height=0.22 * len(found) + 1)
    labels = [f"{n.effect.family} ({n.effect.form})" for n in found]
    ratios = [n.named / n.noticed if n.named and n.noticed else 0.0 for n in found]
    axes.barh(labels[::-1], ratios[::-1], color=COLOURS["rider"])
    axes.set(xlabel="strength to be named over strength to be noticed [1]; no bar: tied at any strength", xscale="symlog")
    return picture


def show(result: dict[str, Any], console: Console) -> None:
    """The plan as a table."""
    console.print(f"{result['rider']}: {len(result['runs'])} sweep(s) of {result['duration']:g} s at {np.degrees(result['amplitude']):g} deg"
                  f"{', with a torso gyro' if result['gyro'] else ''}", style="bold")  # fmt: skip
    table = Table(box=None)
    for heading in ("effect", "form", "parameter", "noticed from", "named from", "unit", "rival"):
        table.add_column(heading, justify="right" if "from" in heading else "left")
    for e in result["effects"]:
        noticed, named = (f"{e[key]:.3g}" if e[key] is not None else "never" for key in ("noticed_from", "named_from"))
        table.add_row(e["name"], e["form"], e["parameter"], noticed, named, e["unit"], ", ".join(e["tied"]) or e["nearest_rival"])
    console.print(table)
