"""The numbers of docs/magnetorheological_damper.md: the verdicts on the recordings of a damper, either of two runs fitted."""

from collections.abc import Callable
from pathlib import Path

import motofmi as mf
from benchmarks._recordings import folder_of_data

FOLDER = "mr_damper"
CASES = {  # fitted run, validation run
    "10 mm": ("10mm1Hz1A.csv", "25mm0p5Hz1A.csv"),
    "25 mm": ("25mm0p5Hz1A.csv", "10mm1Hz1A.csv"),
    "0 A": ("10mm1Hz0A.csv", None),
    "0.5 A": ("5mm3Hz0p5A.csv", None),
}


def run(progress: Callable, data: str | Path | None = None) -> dict:
    """For each case the effects, the rms of the residuals [N] before and after, and the closed share [%]."""
    folder = folder_of_data(data)
    if folder is None or not (folder / FOLDER).is_dir():
        return {"skipped": f"no folder {FOLDER} of recordings (--data)"}
    return {name: _case(folder / FOLDER, *CASES[name]) for name in progress(list(CASES), "recordings of a damper")}


def _case(folder: Path, fitted: str, kept: str | None) -> dict:
    found = mf.find_gap(
        folder / fitted,
        validation=[folder / kept] if kept else (),
        component=mf.mechanism("mass_spring_damper"),
        impose="displacement",
    )
    said = found.to_dict()
    return {
        "verdict": said["verdict"],
        "effects": {
            effect["name"]: {
                name: {key: value[key] for key in ("value", "standard_error")}
                for name, value in effect["parameters"].items()
            }
            for effect in said["effects"]
        },
        "rms": said["gap"]["rms"],
        "explained": {key: 100 * value for key, value in (said["explained"] or {}).items() if value is not None},
        "remainder": 100 * said["remainder"]["share"],
    }
