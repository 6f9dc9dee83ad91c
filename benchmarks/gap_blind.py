"""Blind cases of the gap workflow: how often it alarms for nothing, names right, names wrong, and what it leaves unknown.

    python -m benchmarks.gap_blind --cases 500 --seed 1 --out blind

Three cases in five hide nothing (bursts, doubled noise and riders who change by 6 % among them); the others hide single
effects, forms that the library lacks, effects that are outside of it, members of a tie, and pairs. Recordings and truth
are written by a simulator that shares no code with the finder, which sees a folder with recordings and rig.json,
nothing else. A row per case goes to the study in the --out folder, so that a run can be taken up again. `unknown` and
`tied` never count as a right name. Rates come with Wilson's 95 % interval.
"""

import argparse
import json
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import binomtest

from benchmarks._resumed import resumed
from fmus.support.progress import track
from motofmi.gap.experiment_design.next_experiment import next_experiment
from motofmi.gap.experiments.experiment import ImposedMotionExperiment
from motofmi.gap.models.harmonic_model import HarmonicModel
from motofmi.gap.preprocessing.steer_test_run import SteerTestRun, prepare_steer_test_run
from motofmi.gap.selection.model_selection import select_model
from motofmi.gap.verdict import as_result
from motofmi.recordings.reading import read_recording
from motofmi.recordings.rig_file import read_rig
from motofmi.workflows.gap.rig import rig_effects, rig_experiment, with_bare_bar
from motofmi.workflows.gap.rig_proposals import rig_proposals
from tests.simulators.blind_cases import Laboratory, draw

NAMEABLE, CLEAR = 40.0, 100.0  # delta chi-square


def run(
    progress: Callable[..., Iterable],
    cases: int = 50,
    seed: int = 1,
    out: str | Path | None = None,
    kinds: Sequence[str] = (),
) -> dict[str, Any]:
    """The summary over the cases; those that the folder `out` holds already are not run again."""

    def one(number: int) -> dict[str, Any]:
        truth = draw(number, seed, kinds[number % len(kinds)] if kinds else None)
        with tempfile.TemporaryDirectory() as open_folder:
            laboratory = Laboratory(truth, number, seed)
            laboratory.deliver(Path(open_folder))
            begun = time.perf_counter()
            found = find(Path(open_folder), laboratory.more)
        return {"truth": laboratory.secret(), "seconds": time.perf_counter() - begun, **found}

    return summary(resumed(cases, out, one, seed=seed, kinds=kinds))


def find(folder: Path, laboratory: Callable[[Path, dict[str, Any]], Path]) -> dict[str, Any]:
    """What the workflow says of a folder with recordings; a tie is taken to the laboratory with the proposed run."""
    experiment, library = rig_experiment(read_rig(folder)), rig_effects()
    fitted = prepared([p for p in (folder / "sweep_up.csv", folder / "stepped.csv") if p.exists()], experiment)
    held = prepared([folder / "holdout.csv"], experiment)
    verdict = select_model(HarmonicModel(experiment), fitted, library, held)
    result = as_result(verdict, "N.m")
    proposed = next_experiment(verdict, rig_proposals)
    found = _short(result) | {"next_experiment": proposed}
    if result["verdict"] == "tied" and proposed is not None:
        more = {run["experiment"]: prepared([laboratory(folder, run)], experiment) for run in proposed["runs"]}
        known = with_bare_bar(experiment, more.pop("bare_bar")) if "bare_bar" in more else experiment
        again = select_model(HarmonicModel(known), [*fitted, *chain.from_iterable(more.values())], library, held)
        found["settled"] = _short(as_result(again, "N.m"))
    return found


def prepared(paths: Iterable[Path], experiment: ImposedMotionExperiment) -> list[SteerTestRun]:
    """The runs in files of a rig test."""
    columns = experiment.columns
    return [
        prepare_steer_test_run(
            read_recording(path), columns["imposed"], columns["measured"], columns["command"], tuple(experiment.further)
        )
        for path in paths
    ]


def _short(result: dict[str, Any]) -> dict[str, Any]:
    keys = ("verdict", "effects", "tied", "closest", "candidates", "gap")
    return {key: result[key] for key in keys}


def summary(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Confusion matrix, rates, sizes and what is left on held-out runs."""
    hidden = {
        kind: [r for r in rows if r["truth"]["kind"] == kind]
        for kind in ("none", "single", "unlike", "outside", "trio", "pair")
    }
    alone = hidden["single"] + hidden["trio"]
    ties = [r for r in rows if r["verdict"] == "tied"]
    pairs = [r for r in hidden["pair"] if min(_gains(r)) >= CLEAR]
    rates = {
        "false alarms": share_of([r["verdict"] != "none" for r in hidden["none"]]),
        "right name or a set with it, from delta chi-square 40": share_of([_holds(r) for r in alone if _gain(r) >= NAMEABLE]),
        "right name alone, from delta chi-square 40": share_of([_named(r) == r["truth"]["families"] for r in alone if _gain(r) >= NAMEABLE]),
        "wrong name, from delta chi-square 100": share_of([_wrong(r) for r in alone if _gain(r) >= CLEAR]),
        "unlike form: family right": share_of([_holds(r) for r in hidden["unlike"] if _gain(r) >= CLEAR]),
        "unlike form: wrong name": share_of([_wrong(r) for r in hidden["unlike"] if _gain(r) >= CLEAR]),
        "outside the library: unknown, of those that are seen": share_of([r["verdict"] == "unknown" for r in hidden["outside"] if r["verdict"] != "none"]),
        "outside the library: a name": share_of([bool(_named(r) or r["tied"]) for r in hidden["outside"]]),
        "ties hold the truth": share_of([bool(set(r["truth"]["families"]) & set(r["tied"])) for r in ties if r["truth"]["kind"] in ("single", "trio")]),
        "proposed run settles": share_of([_named(r["settled"]) == r["truth"]["families"] for r in ties if "settled" in r and r["truth"]["kind"] in ("single", "trio")]),
        "pairs: both": share_of([set(_named(r)) == set(r["truth"]["families"]) for r in pairs]),
        "pairs: at least one, none wrong": share_of([bool(_named(r)) and set(_named(r)) <= set(r["truth"]["families"]) for r in pairs]),
    }  # fmt: skip
    confusion = Counter(
        (" + ".join(r["truth"]["families"]) or "none", " + ".join(_named(r)) or r["verdict"]) for r in rows
    )
    held = [
        r["gap"]["holdout_after"]
        for r in rows
        if r["verdict"] in ("named", "none") and r["truth"]["kind"] in ("none", "single", "pair", "trio")
    ]
    return {
        "cases": len(rows), "rates": rates, "mean_size_of_tied_sets": float(np.mean([len(r["tied"]) for r in ties])) if ties else 0.0,
        "confusion": {f"{truth} -> {answer}": n for (truth, answer), n in sorted(confusion.items())},
        "effect_sizes": _sizes(alone),
        "holdout_reduced_chi2": {"median": float(np.median(held)), "share_0.9_to_1.1": float(np.mean(np.abs(np.array(held) - 1) < 0.1))} if held else None,
        "median_seconds": float(np.median([r["seconds"] for r in rows])) if rows else 0.0,
    }  # fmt: skip


# The library's name of the size that the simulator calls so, in the form that both have.
SIZES = {"Tc": ("coulomb", "friction_torque"), "k3": ("cubic", "cubic_stiffness"), "k2": ("square", "square_stiffness"), "g": ("gap", "half_gap"),
         "c2": ("quadratic", "coefficient"), "c3": ("cubic", "cubic_coefficient"), "ra": ("bilinear", "ratio"), "rd": ("both", "ratio"),
         "kr": ("delayed_angle", "gain"), "td": ("delay", "delay"), "C": ("spring", "compliance"), "Ih": ("head", "inertia"),
         "km": ("maxwell", "series_stiffness"), "Tw": ("coulomb", "friction_torque"), "g3": ("cubic", "cubic_gain"), "Icc": ("inertia", "inertia"),
         "ks": ("linear", "stiffness"), "cs": ("linear", "damping")}  # fmt: skip


def _sizes(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Of effects named right in the form that was hidden: sizes within 5 % or two standard errors, and 95 % intervals
    that cover."""
    near, covered = [], []
    for row in rows:
        if _named(row) != row["truth"]["families"]:
            continue
        name = next((n for n in row["truth"]["hidden"] if n in SIZES), None)
        effect = row["effects"][0]
        if name is None or effect["form"] != SIZES[name][0]:
            continue
        found, true = effect["parameters"].get(SIZES[name][1]), abs(row["truth"]["hidden"][name])
        if found is None:  # a value within two standard errors of zero is not given
            continue
        error = abs(abs(found["value"]) - true)
        near.append(error < max(0.05 * true, 2 * found["standard_error"]))
        covered.append(error < 1.96 * found["standard_error"])
    return {"within_5_percent_or_2_errors": share_of(near), "covered_by_95_percent_interval": share_of(covered)}


def _named(row: dict[str, Any]) -> list[str]:
    return [e["name"] for e in row["effects"]]


def _holds(row: dict[str, Any]) -> bool:
    """Whether the truth is the name, or in the tied set."""
    return _named(row) == row["truth"]["families"] or bool(set(row["truth"]["families"]) & set(row["tied"]))


def _wrong(row: dict[str, Any]) -> bool:
    return bool(set(_named(row)) - set(row["truth"]["families"]))


def _gains(row: dict[str, Any]) -> list[float]:
    return [
        max((c["delta_chi2"] for c in row["candidates"] if c["name"] == family), default=0.0)
        for family in row["truth"]["families"]
    ]


def _gain(row: dict[str, Any]) -> float:
    """The delta chi-square of the truth: the most that any effect gains, since a truth whose fit did not converge gains
    as much all the same."""
    return max((c["delta_chi2"] for c in row["candidates"]), default=0.0)


def share_of(outcomes: Sequence[bool]) -> dict[str, float] | None:
    """The share of outcomes that are true, with Wilson's interval; None of nothing."""
    return wilson(sum(outcomes), len(outcomes))


def wilson(successes: int, trials: int) -> dict[str, float] | None:
    """The rate with Wilson's 95 % interval; None without trials."""
    if not trials:
        return None
    interval = binomtest(successes, trials).proportion_ci(method="wilson")
    return {"rate": successes / trials, "from": float(interval.low), "to": float(interval.high), "trials": trials}


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.gap_blind", description=__doc__)
    parser.add_argument("--cases", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--kinds", nargs="*", default=[], help="only these, in turn: none single unlike outside trio pair"
    )
    parser.add_argument("--out", default="gap_blind", metavar="DIR", help="folder of the study, which goes on where it ended")
    arguments = parser.parse_args()
    print(json.dumps(run(track, arguments.cases, arguments.seed, arguments.out, arguments.kinds), indent=1))


if __name__ == "__main__":
    main()
