"""Verdicts of docs/gap.md on components of a user's own and on hands at the handlebar, simulated by other solvers."""

import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import motofmi as mf
from tests.simulators.other_components import (
    Accelerometer,
    Operator,
    Tanks,
    TwoCarts,
    accelerometer_run,
    carts_run,
    operator_run,
    tanks_run,
)

FITTED, VALIDATION = 1, 2  # seeds
Case = tuple[str, str, type, Callable, dict[str, float], dict[str, tuple[str, float]]]
# The component, what is hidden in words and as arguments of the simulator, and the found parameters in words with their
# true values.
CASES: tuple[Case, ...] = (
    ("tanks", "nothing", Tanks, tanks_run, {}, {}),
    ("tanks", "overflow at 0.12 m, half of it into the lower tank", Tanks, tanks_run, {"overflow": 0.12, "share": 0.5},
     {"threshold": ("threshold", 0.12), "share": ("share", 0.5)}),
    ("two driven masses", "dry friction of 1.5 N at the second one", TwoCarts, carts_run, {"friction": 1.5},
     {"friction_torque": ("friction", 1.5)}),
    ("mass with accelerometer, 200 Hz", "dry friction of 1.5 N", Accelerometer, accelerometer_run, {"friction": 1.5},
     {"friction_torque": ("friction", 1.5)}),
    ("operator with a delay of 0.15 s", "nothing", Operator, operator_run, {}, {}),
    ("operator with a delay of 0.15 s", "delay of 0.25 s", Operator, operator_run, {"delay": 0.25}, {"delay": ("further delay", 0.1)}),
    ("operator with a delay of 0.15 s", "threshold of perception 0.04 rad", Operator, operator_run, {"threshold": 0.04},
     {"half_width": ("half width", 0.04)}),
)  # fmt: skip
SPEEDS, ERROR = np.arange(12.0, 58.0, 3.0), 0.05  # m/s, 1/s
HANDS = {"weave and wobble": ("weave", "wobble"), "weave": ("weave",)}


def run(progress: Callable, cases: tuple[Case, ...] = CASES, hands: dict[str, tuple[str, ...]] = HANDS) -> dict[str, Any]:
    """The verdict of every case with values, standard errors and processor time [s]; of hands the effective
    parameters."""
    rows = [_case(*case) for case in progress(cases, "components")]
    return {"components": rows, "hands": {name: _hands(modes) for name, modes in hands.items()}}


def _case(name: str, hidden: str, component: type, simulator: Callable, arguments: dict, wanted: dict) -> dict[str, Any]:
    begun = sum(os.times()[:4])
    runs = [simulator(run, seed, **arguments) for run, seed in (("fitted", FITTED), ("held", VALIDATION))]
    found = mf.find_gap(runs[0], validation=runs[1], component=component())
    parameters = {key: value for effect in found.effects for key, value in effect["parameters"].items()}
    return {
        "component": name, "hidden": hidden, "verdict": found.verdict,
        "effects": [{"name": each["name"], "form": each["form"]} for each in found.effects],
        "values": {words: {**{key: parameters[parameter][key] for key in ("value", "standard_error", "unit")}, "true": true}
                   for parameter, (words, true) in wanted.items() if parameter in parameters},
        "cpu_seconds": sum(os.times()[:4]) - begun,
    }  # fmt: skip


def _hands(modes: tuple[str, ...]) -> dict[str, Any]:
    """The verdict on eigenvalues of Sharp's motorcycle with the mean rider at its handlebar."""
    rng, exact = np.random.default_rng(0), mf.modes("sharp_1971", "rider:mean_2011", SPEEDS)
    rows = ["speed [m/s],mode,real [1/s],imag [rad/s],real_se,imag_se"]
    for mode in modes:
        for speed, x in zip(SPEEDS, exact[mode].eigenvalue, strict=True):
            real, imag = np.array([x.real, x.imag]) + ERROR * rng.standard_normal(2)
            rows.append(f"{speed},{mode},{real},{imag},{ERROR},{ERROR}")
    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder) / "eigenvalues.csv"
        table.write_text("\n".join(rows), "utf-8")
        found = mf.find_gap(table, vehicle="sharp_1971")
    effects, best = found.effects, found.selection.best
    rider = mf.rider("mean_2011").values
    errors = {name: abs(each["value"] - rider[name]) / each["standard_error"]
              for effect in effects for name, each in effect["parameters"].items() if name in rider}  # fmt: skip
    return {
        "verdict": found.verdict, "effects": [each["name"] for each in effects],
        "effective_parameters": float(best.effective_parameters(found.selection.effects[0].effect)) if effects else None,
        "largest_error": max(errors.values(), default=None),
    }  # fmt: skip


def table(results: dict[str, Any]) -> str:
    """The table of docs/gap.md."""
    lines = ["| component | hidden | verdict | value +- standard error (true) | CPU s |", "|---|---|---|---|---|"]
    for row in results["components"]:
        names = " and ".join(f"`{each['name']}`" for each in row["effects"]) or f"`{row['verdict']}`"
        values = ", ".join(f"{words} {_value(each)}" for words, each in row["values"].items())
        lines.append(f"| {row['component']} | {row['hidden']} | {names} | {values} | {row['cpu_seconds']:.0f} |")
    return "\n".join(lines) + "\n"


def _value(each: dict[str, Any]) -> str:
    digits = max(0, 1 - int(np.floor(np.log10(each["standard_error"]))))
    unit = "" if each["unit"] == "1" else f" {each['unit']}"
    return f"{each['value']:.{digits}f} +- {each['standard_error']:.{digits}f}{unit} ({each['true']:g})"
