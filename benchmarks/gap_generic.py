"""Blind cases of the gap workflow on mechanisms that are no rig of ours: which effect is named, under excitations that nobody chose.

    python -m benchmarks.gap_generic --cases 150 --out generic

The simulator is that of the tests, which shares no code with the library. Every case draws a mechanism, how it is
driven (by a torque, with its angle imposed, in a closed loop, as two masses with two outputs, as a heavy mass on a
stiff spring), an excitation, a sampling rate, a noise of 0.2 to 3 % and the size of what is hidden; a third hide
nothing, others forms that the library lacks, or what is in no library. A row per case goes to the study in the --out
folder, so that a run can be taken up again. confusion counts truth -> answer.
"""

import json
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._resumed import command_line, resumed
from benchmarks.gap_blind import share_of
from fmus.declaration.component import Component
from fmus.mechanisms import DrivenJoint, MassSpringDamper, Pendulum, TwoMass
from fmus.support.errors import InputError
from fmus.support.progress import track
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.selection.any_component import investigate
from motofmi.recordings.recording import Recording
from tests.simulators.mechanism_cases import FAMILY, OUTSIDE, UNLIKE, Case, draw

CASES = 150
UNITS = {"torque": "N.m", "angle": "rad", "load_angle": "rad", "force": "N", "displacement": "m"}
FAMILIES = FAMILY | UNLIKE


def mechanism(case: Case) -> Component:
    """The mechanism that was recorded, with values that are near."""
    near = case.near
    if case.setting == "mass_spring_damper":
        return MassSpringDamper(mass=near["J"], spring_stiffness=near["k"], spring_damping=near["c"])
    if case.setting == "two_mass":
        return TwoMass(
            drive_inertia=near["J"],
            load_inertia=near["J2"],
            stiffness=near["k"],
            damping=near["c"],
            drive_damping=near["c1"],
            load_damping=near["c2"],
        )
    if case.hidden == "sine":
        return Pendulum(inertia=near["J"], gravity_stiffness=near["k"], damping=near["c"])
    return DrivenJoint(inertia=near["J"], stiffness=near["k"], damping=near["c"])


def find(case: Case) -> dict[str, Any]:
    """What the workflow says of a case."""
    recording = Recording(f"{case.hidden}_{case.number}", case.time, case.columns, {n: UNITS[n] for n in case.columns})
    try:
        test = input_output_experiment(
            mechanism(case), list(recording.columns), "angle" if case.setting == "imposed" else ""
        )
        verdict = investigate(test, [prepare_sampled_run(recording, test)]).verdict
    except InputError as error:
        return {"verdict": "refused", "names": [], "why": str(error)}
    gain = verdict.base.chi2 - verdict.best.chi2
    return {"verdict": verdict.verdict, "names": sorted(c.family for c in verdict.effects), "forms": [c.effect.form for c in verdict.effects],
            "unspecified_form": verdict.unspecified_form, "tied": [c.family for c in verdict.tied], "closest": [c.family for c in verdict.candidates[:1]],
            "reduced": verdict.best.reduced, "delta_chi2": gain}  # fmt: skip


def run(
    progress: Callable[..., Iterable], cases: int = CASES, out: str | Path | None = None, first: int = 0
) -> dict[str, Any]:
    """Rates and the confusion matrix of cases from the first on; those that the folder `out` holds already are not run
    again."""

    def one(number: int) -> dict[str, Any]:
        case, begun = draw(first + number), time.perf_counter()
        found = {"hidden": case.hidden, "setting": case.setting, "kind": case.kind, "noise": case.noise, **find(case)}
        return found | {"seconds": time.perf_counter() - begun}

    return summary(resumed(cases, out, one, first=first))


def summary(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Rates with Wilson's intervals, and the confusion matrix."""
    nothing = [r for r in rows if r["hidden"] == "none"]
    known, unlike, outside = ([r for r in rows if r["hidden"] in group] for group in (FAMILY, UNLIKE, OUTSIDE))
    rates = {
        "nothing hidden: false alarms": share_of([_named(r) or r["verdict"] == "tied" for r in nothing]),
        "nothing hidden: none": share_of([r["verdict"] == "none" for r in nothing]),
        "effect of the library: right name, or a tied set with it": share_of([_right(r) or _tied(r) for r in known]),
        "effect of the library: right name alone": share_of([_right(r) for r in known]),
        "effect of the library: wrong name": share_of([_wrong(r) for r in known]),
        "unlike form: right family, or a tied set with it": share_of([_right(r) or _tied(r) for r in unlike]),
        "unlike form: wrong name": share_of([_wrong(r) for r in unlike]),
        "outside of the library: a name": share_of([_named(r) for r in outside]),
    }
    confusion = Counter((r["hidden"], " + ".join(r["names"]) or r["verdict"]) for r in rows)
    return {"cases": len(rows), "rates": rates, "confusion": {f"{truth} -> {answer}": n for (truth, answer), n in sorted(confusion.items())},
            "settings": dict(Counter(r["setting"] for r in rows)), "median_seconds": float(np.median([r["seconds"] for r in rows]))}  # fmt: skip


def _named(row: dict[str, Any]) -> bool:
    return row["verdict"] == "named"


def _right(row: dict[str, Any]) -> bool:
    return row["names"] == [FAMILIES[row["hidden"]]]


def _tied(row: dict[str, Any]) -> bool:
    return row["verdict"] == "tied" and FAMILIES[row["hidden"]] in row["tied"]


def _wrong(row: dict[str, Any]) -> bool:
    return _named(row) and any(name != FAMILIES[row["hidden"]] for name in row["names"])


def main() -> None:
    arguments = command_line("gap_generic", __doc__, CASES, first=0)
    print(json.dumps(run(track, arguments.cases, arguments.out, arguments.first), indent=1))


if __name__ == "__main__":
    main()
