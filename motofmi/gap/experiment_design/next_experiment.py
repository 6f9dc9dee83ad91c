"""The next experiment: the runs that would resolve a verdict, and the delta chi-square expected between the rivals.

Every proposed run is simulated with every rival as fitted (see `discrimination`). The contributions of separate runs
add up, so runs are combined, the most informative first, until every two rivals differ by a reliable delta chi-square.
Where that takes only a few seconds, a rival is refitted to the data predicted for a chosen run, since its linear
approximation may be poor.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from fmus.support.deadline import time_is_up
from fmus.support.errors import InputError
from fmus.support.progress import track
from motofmi.frequency_response.excitation import sweep
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import Candidate, one_each
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.experiment_design.discrimination import Prediction, predict_run, separation
from motofmi.gap.experiment_design.planned_run import Channels, planned
from motofmi.gap.models.harmonic_model import HarmonicModel
from motofmi.gap.preprocessing.steer_test_run import SteerTestRun
from motofmi.gap.selection.result import Verdict

DURATION = 120.0  # s, least duration of a proposed sweep: verdicts on shorter ones scatter


class Proposal(Protocol):
    """A possible experiment: its kind, an instruction, its settings (SI), and the prediction of each rival."""

    experiment: str
    sentence: str
    settings: dict[str, float]

    def predict(self, rival: Fit) -> Prediction:
        """The data that a fitted model predicts for the experiment."""

    def left(self, truth: Fit, rival: Fit, enough: float) -> float:
        """The delta chi-square of a rival refitted to the data predicted by the assumed truth; infinite
        where no refit is made.

        The fit may end once the result exceeds `enough`.
        """


@dataclass
class Sweep:
    """A further sweep with the sensors of an existing run."""

    experiment: str
    sentence: str
    settings: dict[str, float]
    run: SteerTestRun

    @classmethod
    def like(cls, found: Fit, experiment: str, sentence: str, larger: float = 1.0, downwards: bool = False,
             further: Mapping[str, float] | None = None) -> "Sweep":  # fmt: skip
        """A sweep over the frequencies of the first run, at `larger` times its amplitude, in either direction,
        with further sensors."""
        made: SteerTestRun = found.runs[0]
        frequencies = [c.frequency for c in made.reduction.columns if c.order == 1]
        low, high = float(min(frequencies)), float(max(frequencies))
        start, end = (high, low) if downwards else (low, high)
        amplitude = larger * float(np.abs(made.motion_at(made.recording.time)[0]).max())
        settings = {"from": start, "to": end, "amplitude": amplitude, "duration": max(made.duration, DURATION)}
        model: Any = found.model
        channels = Channels.of(made, model.experiment.columns["imposed"])
        channels = replace(channels, further={**channels.further, **(further or {})})
        run = planned(sweep(start, end, settings["duration"], amplitude), channels, model.experiment.columns,
                      lambda run: model.outputs(run, found.shared, slopes=False)[0])  # fmt: skip
        return cls(experiment, sentence, settings, run)

    def predict(self, rival: Fit) -> Prediction:
        return predict_run(rival, self.run)

    def left(self, truth: Fit, rival: Fit, enough: float) -> float:
        return np.inf


def further_sweeps(found: Fit) -> list[Proposal]:
    """Possible sweeps of the same rig; none where the model is not that of an imposed sweep."""
    if not isinstance(found.model, HarmonicModel):
        return []
    return [
        Sweep.like(found, "down_sweep", "Sweep from the highest frequency down: it separates drift over time from "
                                        "dependence on frequency.", 1.0, True),
        Sweep.like(found, "larger_sweep", "Sweep down at 1.6 times the amplitude: the shares of nonlinear effects "
                                          "change.", 1.6, True),
        Sweep.like(found, "smaller_sweep", "Sweep at half the amplitude: friction and play weigh more, hardening "
                                           "less.", 0.5),
    ]  # fmt: skip


def next_experiment(
    verdict: Verdict, propose: Callable[[Fit], Sequence[Proposal]] = further_sweeps
) -> dict[str, Any] | None:
    """The runs that would resolve a tie or confirm a weak verdict, with the delta chi-square expected from them.

    `propose` gives the possible experiments for a fit; it is called only where there are rivals. None where the verdict
    needs no further experiment, no proposed one is informative enough, or a deadline has passed.
    """
    rivals = _rivals(verdict)
    proposals = propose(verdict.base) if len(rivals) > 1 and not time_is_up() else []
    if not proposals:
        return None
    fits = [fit for _, fit in rivals]
    tables = [_separations(p, fits) for p in track(proposals, "predicting further runs")]
    chosen = _chosen(proposals, tables, fits, max(len(verdict.tied), 2), verdict.criteria)
    if not chosen or time_is_up():
        return None
    total = np.sum([tables[i] for i in chosen], axis=0)
    names = [name for name, _ in rivals]
    return {
        "experiment": " and ".join(proposals[i].experiment for i in chosen),
        "sentence": " ".join(proposals[i].sentence for i in chosen),
        "expected_delta_chi2": _least(total),
        "runs": [_run(proposals[i], tables[i]) for i in chosen],
        "rivals": [{"truth": a, "rival": b, "delta_chi2": float(total[i, j])}
                   for i, a in enumerate(names) for j, b in enumerate(names) if i != j],
        "alternatives": [_run(p, t) for p, t in zip(proposals, tables, strict=True)],
    }  # fmt: skip


def _chosen(
    proposals: Sequence[Proposal], tables: list[np.ndarray], fits: Sequence[Fit], first: int, criteria: Criteria
) -> list[int]:
    """The indices of runs that distinguish the `first` rivals, then all of them; their tables are updated
    with refitted rivals."""
    chosen: list[int] = []
    total, enough, worth = np.zeros_like(tables[0]), criteria.reliable_delta_chi2, criteria.further_run_delta_chi2
    for count in (first, len(fits)):
        of, further = np.s_[:count, :count], set(range(len(tables))).difference(chosen)
        while _least(total[of]) < enough and further:
            best = max(further, key=lambda i: _score((total + tables[i])[of], enough))
            further.remove(best)
            if _use(total[of], tables[best][of], enough) > worth:
                tables[best] = np.minimum(tables[best], _fitted_again(proposals[best], fits, enough))
            if _use(total[of], tables[best][of], enough) > worth:
                chosen.append(best)
                total = total + tables[best]
    return chosen


def _run(proposal: Proposal, table: np.ndarray) -> dict[str, Any]:
    return {
        "experiment": proposal.experiment,
        "sentence": proposal.sentence,
        "settings": proposal.settings,
        "expected_delta_chi2": _least(table),
    }


def _rivals(verdict: Verdict) -> list[tuple[str, Fit]]:
    """The models among which the next experiment should decide, with their names.

    After a tie they are its members and the families near them; after a weak name that effect, the base, and the next
    family; after `unknown` the best fit and the law outside the library, or the two best families.
    """
    fitted = [c for c in one_each(verdict.candidates) if c.effect in c.fit.model.effects]
    if verdict.verdict == "tied":
        tied, best = {c.family for c in verdict.tied}, max(c.delta_bic for c in verdict.tied)
        near = [
            c for c in fitted if c.family not in tied and best - c.delta_bic < verdict.criteria.clear_lead_delta_bic
        ]  # further runs may favour it
        return [(c.family, c.fit) for c in (*verdict.tied, *near)]
    if (
        verdict.verdict == "named"
        and len(verdict.effects) == 1
        and verdict.effects[0].delta_bic < verdict.criteria.weak_name_delta_bic
    ):
        return [
            (verdict.effects[0].family, verdict.effects[0].fit),
            ("none", verdict.base),
            *_others(fitted, verdict.effects[0].family),
        ]
    if verdict.outside_library:
        return [
            (" and ".join(e.family for e in verdict.best.model.effects) or "none", verdict.best),
            (verdict.outside_library.family, verdict.outside_library.fit),
        ]
    if verdict.verdict == "unknown" and verdict.best.reduced < verdict.criteria.far_from_noise:
        return [(c.family, c.fit) for c in fitted[:2]]
    return []


def _others(fitted: Sequence[Candidate], family: str) -> list[tuple[str, Fit]]:
    return [(c.family, c.fit) for c in fitted if c.family != family][:1]


def _separations(proposal: Proposal, rivals: Sequence[Fit]) -> np.ndarray:
    """Expected delta chi-square (k, k) of the rival of a column where that of a row is the truth; after a deadline
    0."""
    if time_is_up():
        return np.zeros((len(rivals), len(rivals)))
    try:
        predictions = [proposal.predict(rival) for rival in rivals]
    except InputError:  # the planned run cannot be simulated
        return np.zeros((len(rivals), len(rivals)))
    table = np.zeros((len(rivals), len(rivals)))
    for i, truth in enumerate(predictions):
        for j, rival in enumerate(predictions):
            if i != j:
                table[i, j] = separation(rivals[j], rival.predicted - truth.predicted, rival.slopes)
    return table


def _fitted_again(proposal: Proposal, rivals: Sequence[Fit], enough: float) -> np.ndarray:
    """The same (k, k) with refitted rivals, where the proposal refits."""
    return np.array(
        [[0.0 if truth is rival else proposal.left(truth, rival, enough) for rival in rivals] for truth in rivals]
    )


def _use(total: np.ndarray, table: np.ndarray, enough: float) -> float:
    """The largest useful gain of a further run between two rivals."""
    return float(np.max(np.minimum(total + table, enough) - np.minimum(total, enough)))


def _least(table: np.ndarray) -> float:
    """The smallest delta chi-square between two rivals."""
    return float(np.min(table[~np.eye(len(table), dtype=bool)]))


def _score(table: np.ndarray, enough: float) -> float:
    """The mean delta chi-square between rivals, each limited to what is enough."""
    return float(np.mean(np.minimum(table[~np.eye(len(table), dtype=bool)], enough)))
