"""Blind cases of the gap workflow on recorded runs of a vehicle of which not all states are logged: which effect is named.

    python -m benchmarks.gap_vehicle_runs --cases 120 --out runs

The simulators are those of the tests, which share no code with the library: every case draws a motorcycle or a bicycle,
its speed, the channels that are logged, what drives it, disturbances, noises, and the size of what is hidden; half of
them hide nothing. A row per case goes to the study in the --out folder, so that a run can be taken up again. confusion
counts truth -> answer.
"""

import json
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._resumed import command_line, resumed
from benchmarks.gap_blind import share_of
from fmus.support.errors import InputError
from fmus.support.progress import track
from motofmi.recordings.reading import read_recording
from motofmi.workflows import components
from motofmi.workflows.gap.vehicle import vehicle_runs_experiment
from motofmi.workflows.gap.vehicle_predictions import predictable_effects, predicted_runs, verdict_on_predictions
from tests.simulators.hidden_bicycle import write_matrices
from tests.simulators.ride_cases import Case, draw
from tests.vehicle_fmu.test_motorcycle import KANE_NAMES
from vehicle_fmu import Motorcycle

CASES, FIRST = 120, 1000
CLEAR = 40.0  # delta chi-square of the true family from which it is strong enough


def find(case: Case, folder: Path) -> dict[str, Any]:
    """What the workflow says of a case."""
    if case.vehicle == "bicycle":
        vehicle = components.vehicle(write_matrices(folder / "bicycle.toml"))
    else:
        vehicle = Motorcycle("known", **{KANE_NAMES[n]: x for n, x in case.known.items() if n in KANE_NAMES})
    experiment = vehicle_runs_experiment(vehicle, predicted=True)
    try:
        runs = predicted_runs([read_recording(file) for file in case.files], experiment)
        verdict = verdict_on_predictions(experiment, runs, [], predictable_effects(vehicle, experiment, runs))
    except InputError as error:
        return {"verdict": "refused", "names": [], "tied": [], "why": str(error), "delta_chi2": 0.0, "closest": []}
    gain = max((c.delta_chi2 for c in verdict.candidates if c.family == case.family), default=0.0)
    return {"verdict": verdict.verdict, "names": sorted(c.family for c in verdict.effects), "forms": [c.effect.form for c in verdict.effects],
            "unspecified_form": verdict.unspecified_form, "tied": [c.family for c in verdict.tied], "before": verdict.base.reduced, "after": verdict.best.reduced,
            "delta_chi2": gain, "closest": [(c.family, c.effect.form, round(c.delta_chi2, 1)) for c in verdict.candidates[:3]]}  # fmt: skip


def run(
    progress: Callable[..., Iterable], cases: int = CASES, out: str | Path | None = None, first: int = FIRST
) -> dict[str, Any]:
    """Rates and the confusion matrix; cases that the folder `out` holds already are not run again."""

    def one(number: int) -> dict[str, Any]:
        with tempfile.TemporaryDirectory() as folder:
            case, begun = draw(first + number, Path(folder)), time.perf_counter()
            found = find(case, Path(folder))
        truth = {"hidden": case.hidden, "family": case.family, "size": str(case.size), "vehicle": case.vehicle, "kind": case.kind,
                "speeds": [round(v, 1) for v in case.speeds], "channels": case.channels}  # fmt: skip
        return truth | found | {"seconds": time.perf_counter() - begun}

    return summary(resumed(cases, out, one, first=first))


def summary(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Rates with Wilson's intervals, and the confusion matrix."""
    quiet = [r for r in rows if r["hidden"] == "none"]
    inside, outside = (
        [r for r in rows if r["hidden"] != "none" and bool(r["family"]) == known] for known in (True, False)
    )
    clear = [r for r in inside if r["delta_chi2"] >= CLEAR]
    rates = {
        "nothing hidden: false alarms": share_of([_says(r) for r in quiet]),
        "nothing hidden: none": share_of([r["verdict"] == "none" for r in quiet]),
        "effect of the library, delta chi-square from 40: its name, or a tied set with it": share_of(
            [_holds(r) for r in clear]
        ),
        "the same: its name alone": share_of([r["names"] == [r["family"]] for r in clear]),
        "effect of the library of any strength: its name, or a tied set with it": share_of([_holds(r) for r in inside]),
        "effect of the library of any strength: a wrong name": share_of(
            [any(n != r["family"] for n in r["names"]) for r in inside]
        ),
        "outside of the library: a name": share_of([bool(r["names"]) for r in outside]),
    }
    confusion = Counter(
        (
            r["hidden"],
            " + ".join(r["names"])
            or (f"tied({', '.join(sorted(r['tied']))})" if r["verdict"] == "tied" else r["verdict"]),
        )
        for r in rows
    )
    return {"cases": len(rows), "rates": rates, "confusion": {f"{truth} -> {answer}": n for (truth, answer), n in sorted(confusion.items())},
            "vehicles": dict(Counter(r["vehicle"] for r in rows)), "median_seconds": float(np.median([r["seconds"] for r in rows]))}  # fmt: skip


def _says(row: dict[str, Any]) -> bool:
    return row["verdict"] in ("named", "tied")


def _holds(row: dict[str, Any]) -> bool:
    return row["family"] in (row["names"] if row["verdict"] == "named" else row["tied"])


def main() -> None:
    arguments = command_line("gap_vehicle_runs", __doc__, CASES, first=FIRST)
    print(json.dumps(run(track, arguments.cases, arguments.out, arguments.first), indent=1))


if __name__ == "__main__":
    main()
