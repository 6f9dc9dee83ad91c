"""The numbers of docs/steer_by_wire_bicycle.md: the verdicts on the recordings of the bicycle, its matrices free or held."""

import re
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import motofmi as mf
from benchmarks._recordings import SOURCES, folder_of_data, missing

SOURCE = SOURCES["steer-by-wire bicycle"]
CASES = {"free": ("all",), "held": ()}  # the entries without a prior, and within the prior of the workflow
GAIN = "steer_by_steer_torque"
SHOWN = ("coulomb_friction", "roll_inertia", "steer_damping")


def run(progress: Callable, data: str | Path | None = None) -> dict[str, Any]:
    """For each case reduced chi-squares, the leading effects and the recorded time that is compared."""
    folder = folder_of_data(data)
    if reason := missing(folder, SOURCE):
        return {"skipped": reason}
    assert folder is not None
    found = {}
    for name, free in progress(list(CASES.items()), "recordings of a bicycle"):
        with tempfile.TemporaryDirectory() as made:
            vehicle = Path(made, "authors.toml")
            vehicle.write_text(SOURCE.vehicle, "utf-8")
            fitted, kept = SOURCE.files(folder, Path(made))
            found[name] = entry(mf.find_gap(fitted, validation=kept, vehicle=vehicle, free=free).to_dict())
    return found


def entry(said: Mapping[str, Any]) -> dict[str, Any]:
    """What the page shows of a verdict."""
    chi = said["gap"]
    times = [tuple(map(float, each)) for sentence in said["limitations"]
             for each in re.findall(r"(\d+) of (\d+) s are compared", sentence)]  # fmt: skip
    runs = {"fitted": times[: len(SOURCE.fitted)], "validation": times[len(SOURCE.fitted) :]}
    gains = {name: max(each["delta_chi2"] for each in said["candidates"] if each["name"] == name) for name in SHOWN}
    return {
        "verdict": said["verdict"],
        "closest": said["closest"]["name"],
        "fitted": {"base": chi["before"], "with_effect": chi["after"]},
        "validation": {"base": chi["holdout_before"], "with_effect": chi["holdout_after"]},
        "explained": {key: 100 * value for key, value in said["explained"].items()},
        "delta_chi2": gains,
        "compared_s": {name: {"compared": sum(c for c, _ in of), "recorded": sum(r for _, r in of)} for name, of in runs.items()},
        "torque_gain": said["base"].get(GAIN),
        "gravity_in_roll": said["base"]["roll_by_roll_angle_0"],
    }  # fmt: skip
