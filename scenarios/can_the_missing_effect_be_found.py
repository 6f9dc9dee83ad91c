"""Can the effect that a model misses be found in recordings?

A separate process draws a rider and an effect by a seed and writes recordings. The gap workflow, which has no access to
what was drawn, gives its verdict; then the two are compared.
"""

import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from motofmi.reports.gap_report import before_and_after_chart
from motofmi.reports.report import Section, Table
from motofmi.workflows.gap.find_gap import find_gap
from motofmi.workflows.scenarios import InReport

REPORT = InReport("tour", 50, "a hidden effect, found in recordings")


@dataclass(frozen=True)
class Finding:
    """The verdict (the contents of verdict.json), the hidden effect with its size, and the files with their meanings."""

    verdict: dict[str, Any]
    truth: dict[str, Any]
    files: list[tuple[Path, str]]


def run(out: Path, seed: int = 1) -> Finding:
    """Recordings into out/recordings, the verdict into out/gap; the truth is read only after the verdict."""
    recordings = out / "recordings"
    with tempfile.TemporaryDirectory() as vault:
        truth = Path(vault) / "truth.json"
        subprocess.run(
            [sys.executable, "-m", "motofmi.virtual_rig.hidden_effect", str(seed), str(recordings), str(truth)],
            check=True,
        )
        fitted = [recordings / f"{name}.csv" for name in ("sweep_up_2deg", "stepped_4deg")]
        verdict = find_gap(fitted, validation=recordings / "holdout_sweep_down_3deg.csv", out=out / "gap").to_dict()
        files = [
            (out / "gap" / verdict["report"], "report of the gap workflow"),
            (out / "gap" / "verdict.json", "verdict"),
            *(
                (out / "gap" / verdict[key], text)
                for key, text in (("model", "fitted model"), ("fmu", "its FMU"))
                if verdict[key]
            ),
            *((path, "recording") for path in sorted(recordings.glob("*.csv"))),
        ]
        return Finding(verdict, json.loads(truth.read_text()), files)


def section(found: Finding) -> Section:
    """The verdict beside the truth."""
    verdict, truth = found.verdict, found.truth
    effects = {effect["name"]: effect for effect in verdict["effects"]}
    right = truth["name"] in effects or truth["name"] in verdict["tied"]
    said = f"{verdict['verdict']}: {' and '.join(effects) or ', '.join(verdict['tied']) or '-'}"
    text = (f"The hidden effect was {truth['name']} ({truth['parameter']} = {truth['value']:.4g}); the verdict was "
            f"{said}, which is "
            f"{'right' if right else 'wrong'}.")  # fmt: skip
    rows = [[name, effect["form"], parameter, f"{value['value']:.4g} +- {value['standard_error']:.2g} {value['unit']}",
             f"{truth['value']:.4g}" if parameter.endswith(truth["parameter"]) and name == truth["name"] else ""]
            for name, effect in effects.items() for parameter, value in effect["parameters"].items()]  # fmt: skip
    table = Table(("effect", "form", "parameter", "found", "hidden"), rows, "The effects found")
    return Section(
        "Can the missing effect be found?",
        [text],
        [(before_and_after_chart(found.verdict), "The gap between model and recordings, before and after.")],
        [table] if rows else [],
        files=found.files,
    )
