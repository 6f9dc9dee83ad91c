"""False names on recordings of real machines in which there is nothing to name.

    python -m benchmarks.gap_permutation --data measured --trials 210 --out permutation

Null hypothesis: the data are the simulated base, plus the base's real residuals in permuted blocks with random signs,
on fitted and on validation runs (`benchmarks/_null_comparison.py`). A name, or a tie, is then false. The comparison on
blocks must name nothing in at least 99 of 100 draws. The rates are those of the comparison alone, with a base and
effects that are refitted by linearisation; the search by chi-square, which precedes it, is not part of this study.

The recordings, and where they are from, are those of `benchmarks/_recordings.py`.
"""

import argparse
import json
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._null_comparison import Null, decided, null_of
from benchmarks._recordings import DATA, SOURCES, Source, folder_of_data, missing
from benchmarks._resumed import resumed
from benchmarks.gap_blind import wilson
from fmus.support.progress import track
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.base_fit import fitted_base
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.selection.any_component import with_unknown_offsets
from motofmi.gap.selection.noise_rounds import with_noise_of
from motofmi.gap.selection.staged_selection import in_shorter_segments
from motofmi.gap.validation.before_after import on_validation_runs
from motofmi.workflows.gap.given import Given
from motofmi.workflows.gap.input_output import InputOutput

TRIALS, SEED = 210, 1
# The recordings of the study; others take too long for many draws.
STUDIED = ("EMPS, displacement imposed", "EMPS, force in", "Silverbox", "filmed pendulum", "four swings", "magnetorheological damper")


@lru_cache(maxsize=1)
def prepared(folder: Path, name: str) -> Null:
    """The null hypothesis of a recording: its base fitted as the workflow does, and the effects at its elements."""
    kind, criteria = InputOutput(_given(folder, SOURCES[name])), Criteria()
    experiment = with_unknown_offsets(kind.experiment, kind.runs)
    based = fitted_base(experiment, kind.runs, {}, (), criteria)
    found, library = based.fit, based.candidates
    base = fit(found.model, [in_shorter_segments(run) for run in found.runs], found.x)
    held = [prepare_sampled_run(recording, found.model.experiment) for recording in kind.validation]
    held = [in_shorter_segments(run) for run in with_noise_of(base.runs[0], held)]
    return null_of(base, on_validation_runs(base, held, criteria).fit, library)


def _given(folder: Path, source: Source) -> Given:
    """The files of a source, read."""
    with tempfile.TemporaryDirectory() as made:
        fitted, validation = source.files(folder, Path(made))
        given = Given(fitted, validation, component=source.component, impose=source.impose)
        InputOutput(given)  # reads the files
        return given


def run(
    progress: Callable[..., Iterable],
    trials: int = TRIALS,
    seed: int = SEED,
    out: str | Path | None = None,
    data: str | Path | None = None,
    sources: Sequence[str] = STUDIED,
) -> dict[str, Any]:
    """The rates of false names; trials that the folder `out` holds already are not run again."""
    folder = folder_of_data(data)
    reasons = {name: missing(folder, SOURCES[name]) for name in sources}
    present = [name for name, reason in reasons.items() if not reason]
    skipped = {name: reason for name, reason in reasons.items() if reason}

    def one(number: int) -> dict[str, Any]:
        source, begun = present[number * len(present) // trials], time.process_time()
        null = prepared(Path(str(folder)), source)
        strict, loose = decided(null, np.random.default_rng([seed, number]), Criteria())
        return {"source": source, "blocks": [len(strict.best.fitted), len(strict.best.validation)],
                **{f"verdict{which}": each.verdict for which, each in (("", strict), (" without tolerance", loose))},
                "names": sorted({e.family for m in loose.members for e in m.effects}), "share": loose.share and loose.share.share,
                "sentences": loose.sentences, "cpu_seconds": time.process_time() - begun}  # fmt: skip

    return summary(resumed(trials if present else 0, out, one, seed=seed, sources=sources), skipped)


def summary(rows: Sequence[dict[str, Any]], skipped: dict[str, str]) -> dict[str, Any]:
    """False names with Wilson's intervals, altogether and by recording."""

    def false(rows: Sequence[dict[str, Any]], key: str) -> dict[str, float] | None:
        return wilson(sum(r[key] in ("named", "tied") for r in rows), len(rows))

    return {
        "trials": len(rows), "false_names": false(rows, "verdict"), "without_tolerance": false(rows, "verdict without tolerance"),
        "by_source": {name: {"false_names": false(of, "verdict"), "without_tolerance": false(of, "verdict without tolerance"),
                             "verdicts": dict(Counter(r["verdict"] for r in of))}
                      for name in dict.fromkeys(r["source"] for r in rows) for of in [[r for r in rows if r["source"] == name]]},
        "skipped": skipped, "cpu_seconds": sum(r["cpu_seconds"] for r in rows),
    }  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.gap_permutation", description=__doc__)
    parser.add_argument("--data", metavar="DIR", help=f"folder of recordings (default: environment variable {DATA})")
    parser.add_argument("--trials", type=int, default=TRIALS)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--out", help="folder of the study, which goes on where it ended")
    arguments = parser.parse_args()
    print(json.dumps(run(track, arguments.trials, arguments.seed, arguments.out, arguments.data), indent=1))


if __name__ == "__main__":
    main()
