"""Can the effect that a model misses be found in recordings?

A process of its own draws a rider and an effect by a seed and writes recordings; the gap workflow, which cannot read
what was drawn, says what it finds; then the two are compared.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from scenarios.commands import gap
from scenarios.report import COLOURS, Section, Table, new_figure


@dataclass(frozen=True)
class Finding:
    """What the workflow said, and what had been hidden."""

    verdict: dict[str, Any]
    truth: dict[str, Any]


def run(out: Path, seed: int = 1) -> Finding:
    """Recordings into out/recordings, the verdict into out/gap; the truth is read only after the verdict."""
    recordings = out / "recordings"
    with tempfile.TemporaryDirectory() as vault:
        truth = Path(vault) / "truth.json"
        subprocess.run([sys.executable, "-m", "scenarios.rig_with_a_secret", str(seed), str(recordings), str(truth)], check=True)
        parser = argparse.ArgumentParser()
        gap.add_arguments(parser)
        fitted = [str(recordings / f"{name}.csv") for name in ("sweep_up_2deg", "stepped_4deg")]
        held = str(recordings / "holdout_sweep_down_3deg.csv")
        verdict = gap.run(parser.parse_args([*fitted, "--holdout", held, "--out", str(out / "gap")]))
        return Finding(verdict, json.loads(truth.read_text()))


def figure(found: Finding) -> Figure:
    """The gap before and after, on the runs that were fitted and on the one that was held out."""
    picture, ax = new_figure(width=7, height=2.6)
    gap_ = found.verdict["gap"]
    names = [("before", "fitted runs, before"), ("after", "fitted runs, after"), ("holdout_before", "held-out run, before"),
             ("holdout_after", "held-out run, after")]  # fmt: skip
    shown = [(label, gap_[key]) for key, label in names if gap_[key] is not None][::-1]
    colours = [COLOURS["reference"] if "before" in label else COLOURS["rider"] for label, _ in shown]
    ax.barh([label for label, _ in shown], [value for _, value in shown], color=colours)
    ax.axvline(1, color="#c00000", linewidth=1)
    ax.set(xscale="log", xlabel="reduced chi-square [1]; the line is the noise floor", ylabel="run [-]")
    return picture


def section(found: Finding) -> Section:
    """The verdict beside the truth."""
    verdict, truth = found.verdict, found.truth
    effects = {effect["name"]: effect for effect in verdict["effects"]}
    right = truth["name"] in effects or truth["name"] in verdict["tied"]
    said = f"{verdict['verdict']}: {' and '.join(effects) or ', '.join(verdict['tied']) or '-'}"
    text = (f"Hidden was {truth['name']} ({truth['parameter']} = {truth['value']:.4g}); the workflow said {said}, which is "
            f"{'right' if right else 'wrong'}.")  # fmt: skip
    rows = [[name, effect["form"], parameter, f"{value['value']:.4g} +- {value['standard_error']:.2g} {value['unit']}",
             f"{truth['value']:.4g}" if parameter.endswith(truth["parameter"]) and name == truth["name"] else ""]
            for name, effect in effects.items() for parameter, value in effect["parameters"].items()]  # fmt: skip
    table = Table(("effect", "form", "parameter", "found", "hidden"), rows, "What was found")
    return Section("Can the missing effect be found?", [text], [(figure(found), "The gap between model and recordings")], [table] if rows else [])
