"""What does the gap workflow say when the linear rider is fitted to the full one? The servo test at 1, 2, 4 and 8 deg.

Every run is a sweep up with the rig's noise, remnant and converters, checked on a sweep down. The base is the passive rider.
Where the handlebar's inertia is known, the limbs' share of it is what the passive rider lacks first; where it is not
(hands and bar cannot be told apart from one port), what is left is what no linear rider has: the geometry of the arms.
"""

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from fmus.progress import track
from identification.excitation import sweep
from identification.recordings import write_recording
from rider_fmu import riders
from rider_fmu.reduction import reduce
from scenarios.commands import gap
from scenarios.full_rider_on_the_rig import steer_test
from scenarios.report import COLOURS, Section, Table, new_figure

AMPLITUDES = (1.0, 2.0, 4.0, 8.0)  # deg
BAR, BAR_ERROR = 0.125, 0.00125  # kg.m2
UP, DOWN = 90.0, 80.0  # s


def run(amplitudes: tuple[float, ...] = AMPLITUDES, rider: str = "full_mean_2011", up: float = UP, down: float = DOWN) -> dict[str, Any]:
    """The verdicts by amplitude [deg] with the handlebar's inertia unknown, `known_bar` at the smallest, and the `reduced` rider.

    up and down are the sweeps' durations [s].
    """
    full, verdicts = riders.load(rider), {}
    with tempfile.TemporaryDirectory() as name:
        for amplitude in track(amplitudes, "sweeps and verdicts"):
            folder = Path(name) / f"{amplitude:g}_deg"
            folder.mkdir()
            for seed, (file, excitation) in enumerate({"up": sweep(0.5, 12, up, np.radians(amplitude)), "down": sweep(12, 0.5, down, np.radians(amplitude))}.items()):
                write_recording(steer_test(full, BAR, excitation, seed=seed), folder / f"{file}.csv")
            verdicts[amplitude] = verdict(folder)
        smallest = Path(name) / f"{min(amplitudes):g}_deg"
        (smallest / "rig.json").write_text(json.dumps({"handlebar_inertia": {"value": BAR, "standard_error": BAR_ERROR, "unit": "kg.m2"}}))
        known = verdict(smallest)
    return {"verdicts": verdicts, "known_bar": known, "smallest": min(amplitudes), "reduced": reduce(full)}


def verdict(folder: Path) -> dict[str, Any]:
    """What `motofmi gap` says of the recordings in a folder."""
    parser = argparse.ArgumentParser()
    gap.add_arguments(parser)
    return gap.run(parser.parse_args([str(folder / "up.csv"), "--holdout", str(folder / "down.csv"), "--out", str(folder / "gap")]))


def figure(found: dict[str, Any]) -> Figure:
    """The misfit of the held-out sweeps over the amplitude, before and after what was named."""
    picture, ax = new_figure(width=7, height=3.4)
    verdicts = found["verdicts"]
    for key, label, colour in (("holdout_before", "linear rider", COLOURS["reference"]), ("holdout_after", "with what was found", COLOURS["rider"])):
        ax.loglog(list(verdicts), [v["gap"][key] for v in verdicts.values()], "o-", color=colour, label=label)
    ax.axhline(1, color="#c00000", linewidth=1)
    ax.set(xlabel="amplitude of the sweep [deg]", ylabel="reduced chi-square, held out [1]")
    ax.legend(fontsize=8)
    return picture


def section(found: dict[str, Any]) -> Section:
    """What was said at each amplitude."""
    known, reduced = found["known_bar"], found["reduced"]
    said = "; ".join(f"{a:g} deg: {in_words(v)}" for a, v in found["verdicts"].items())
    text = [f"Where the handlebar's inertia is known, the workflow says at {found['smallest']:g} deg: {in_words(known)}. The limbs of the full rider bring "
            f"{reduced.steer_inertia:.3f} kg.m2 to the steer axis, which the passive rider of 2011 has not.",
            f"Where it is not known, nothing of the linear coefficients can be missing, and what is left is geometry. Said: {said}. No effect of the library is "
            "the geometry of arms, so that any single name here is a wrong one; what of the gap it leaves on the held-out sweep shows that."]  # fmt: skip
    rows = [[case, in_words(v), *(f"{v['gap'][k]:.4g}" if v["gap"][k] is not None else "" for k in ("before", "after", "holdout_before", "holdout_after"))]
            for case, v in ((f"{found['smallest']:g} deg, bar known", known), *((f"{a:g} deg", v) for a, v in found["verdicts"].items()))]  # fmt: skip
    headings = ("sweep", "said", "before", "after", "held out, before", "held out, after")
    return Section("What does the gap workflow say of the full rider?", text, [(figure(found), "Misfit over the amplitude, in units of the noise")],
                   [Table(headings, rows, "Reduced chi-square, one is the noise")])  # fmt: skip


def in_words(result: dict[str, Any]) -> str:
    """The verdict with its names and values."""
    effects = [f"{e['name']} ({e['form']}): " + ", ".join(f"{n} = {p['value']:.4g} +- {p['standard_error']:.2g} {p['unit']}" for n, p in e["parameters"].items())
               for e in result["effects"]]  # fmt: skip
    return " ".join([result["verdict"], " and ".join(effects) or ", ".join(result["tied"])]).strip()
