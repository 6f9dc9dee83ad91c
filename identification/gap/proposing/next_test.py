"""The test that would settle a verdict: which runs, and by how much they would tell the rivals apart.

Every proposal is simulated with every rival as fitted; see `expected`. What the separate runs bring adds up at least,
so runs are joined, the most useful first, until each rival would stand out by a delta chi-square of ENOUGH. Where that
takes a few seconds only, a rival is fitted again to what a chosen run would give: it may bend further than its slopes say.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from fmus.errors import InputError
from fmus.progress import track
from identification.excitation import sweep
from identification.gap.data.runs import Run
from identification.gap.models.model import Model
from identification.gap.naming.candidate import CLEAR, Candidate, one_each
from identification.gap.naming.decide import FAR_FROM_NOISE, Verdict
from identification.gap.naming.fitted import Fit
from identification.gap.proposing.expected import Foresight, separation, through
from identification.gap.proposing.planned import Channels, planned

ENOUGH = 40.0  # delta chi-square from which naming is reliable
WEAK = 40.0  # dBIC below which a name rests on little
LEAST = 10.0  # delta chi-square that a further run must bring between any two of the rivals
DURATION = 120.0  # s of a proposed sweep at least: shorter ones need luck


class Proposal(Protocol):
    """A test that could be made: its kind, what to do, its settings (SI), and what each rival foresees of it."""

    experiment: str
    sentence: str
    settings: dict[str, float]

    def foresee(self, rival: Fit) -> Foresight:
        """What a fitted model would give in the test."""

    def left(self, truth: Fit, rival: Fit) -> float:
        """The delta chi-square of a rival that is fitted again to what the truth would give; infinite where that is not tried."""


@dataclass
class Sweep:
    """A further sweep, in the channels of a run that was made."""

    experiment: str
    sentence: str
    settings: dict[str, float]
    run: Run

    @classmethod
    def like(cls, found: Fit, experiment: str, sentence: str, larger: float = 1.0, downwards: bool = False,
             further: Mapping[str, float] | None = None) -> "Sweep":  # fmt: skip
        """A sweep over the frequencies of the first run, at `larger` times its amplitude, either way, with further sensors."""
        made: Run = found.runs[0]
        frequencies = [c.frequency for c in made.reduction.columns if c.order == 1]
        low, high = float(min(frequencies)), float(max(frequencies))
        start, end = (high, low) if downwards else (low, high)
        amplitude = larger * float(np.abs(made.moved(made.recording.time)[0]).max())
        settings = {"from": start, "to": end, "amplitude": amplitude, "duration": max(made.duration, DURATION)}
        model: Any = found.model
        channels = Channels.of(made, model.stand.columns["imposed"])
        channels = replace(channels, further={**channels.further, **(further or {})})
        run = planned(sweep(start, end, settings["duration"], amplitude), channels, model.stand.columns,
                      lambda run: model.outputs(run, found.shared, slopes=False)[0])  # fmt: skip
        return cls(experiment, sentence, settings, run)

    def foresee(self, rival: Fit) -> Foresight:
        return through(rival, self.run)

    def left(self, truth: Fit, rival: Fit) -> float:
        return np.inf


def further_sweeps(found: Fit) -> list[Proposal]:
    """Sweeps that the rig could make next, from what it has made; none where the model is not that of an imposed sweep."""
    if not isinstance(found.model, Model):
        return []
    return [
        Sweep.like(found, "down_sweep", "Sweep from the highest frequency down: what changes with time then parts from what changes with frequency.", 1.0, True),
        Sweep.like(found, "larger_sweep", "Sweep down at 1.6 times the amplitude: what is not linear changes its share.", 1.6, True),
        Sweep.like(found, "smaller_sweep", "Sweep at half the amplitude: friction and play gain, hardening loses.", 0.5),
    ]  # fmt: skip


def next_experiment(verdict: Verdict, propose: Callable[[Fit], Sequence[Proposal]] = further_sweeps) -> dict[str, Any] | None:
    """The runs that would settle a tie or strengthen a weak verdict, with the delta chi-square that they would bring.

    `propose` says what could be done after what a fit rests on; it is asked where there are rivals only. None where the
    verdict stands, or nothing that is proposed would help.
    """
    rivals = _rivals(verdict)
    proposals = propose(verdict.base) if len(rivals) > 1 else []
    if not proposals:
        return None
    fits = [fit for _, fit in rivals]
    tables = [_told_apart(p, fits) for p in track(proposals, "foreseeing further runs")]
    chosen = _chosen(proposals, tables, fits, max(len(verdict.tied), 2))
    if not chosen:
        return None
    total = np.sum([tables[i] for i in chosen], axis=0)
    names = [name for name, _ in rivals]
    return {
        "experiment": " and ".join(proposals[i].experiment for i in chosen),
        "sentence": " ".join(proposals[i].sentence for i in chosen),
        "expected_delta_chi2": _least(total),
        "runs": [_run(proposals[i], tables[i]) for i in chosen],
        "rivals": [{"truth": a, "rival": b, "delta_chi2": float(total[i, j])} for i, a in enumerate(names) for j, b in enumerate(names) if i != j],
        "alternatives": [_run(p, t) for p, t in zip(proposals, tables, strict=True)],
    }  # fmt: skip


def _chosen(proposals: Sequence[Proposal], tables: list[np.ndarray], fits: Sequence[Fit], first: int) -> list[int]:
    """The runs that tell so many first rivals apart, then all of them; the tables of these hold what rivals that are fitted again leave."""
    chosen: list[int] = []
    total = np.zeros_like(tables[0])
    for count in (first, len(fits)):
        of, further = np.s_[:count, :count], set(range(len(tables))).difference(chosen)
        while _least(total[of]) < ENOUGH and further:
            best = max(further, key=lambda i: _score((total + tables[i])[of]))
            further.remove(best)
            if _use(total[of], tables[best][of]) > LEAST:
                tables[best] = np.minimum(tables[best], _fitted_again(proposals[best], fits))
            if _use(total[of], tables[best][of]) > LEAST:
                chosen.append(best)
                total = total + tables[best]
    return chosen


def _run(proposal: Proposal, table: np.ndarray) -> dict[str, Any]:
    return {"experiment": proposal.experiment, "sentence": proposal.sentence, "settings": proposal.settings, "expected_delta_chi2": _least(table)}


def _rivals(verdict: Verdict) -> list[tuple[str, Fit]]:
    """What could be true: the members of a tie and what is near; a weak name, the next family, and nothing; of an unknown, what it is taken
    for and the law that explains more, or the nearest ones."""
    fitted = [c for c in one_each(verdict.candidates) if c.effect in c.fit.model.effects]
    if verdict.verdict == "tied":
        tied, best = {c.family for c in verdict.tied}, max(c.delta_bic for c in verdict.tied)
        near = [c for c in fitted if c.family not in tied and best - c.delta_bic < CLEAR]  # further runs may bring it back
        return [(c.family, c.fit) for c in (*verdict.tied, *near)]
    if verdict.verdict == "named" and len(verdict.effects) == 1 and verdict.effects[0].delta_bic < WEAK:
        return [(verdict.effects[0].family, verdict.effects[0].fit), ("none", verdict.base), *_others(fitted, verdict.effects[0].family)]
    if verdict.unlisted:
        return [(" and ".join(e.family for e in verdict.best.model.effects) or "none", verdict.best), (verdict.unlisted.family, verdict.unlisted.fit)]
    if verdict.verdict == "unknown" and verdict.best.reduced < FAR_FROM_NOISE:
        return [(c.family, c.fit) for c in fitted[:2]]
    return []


def _others(fitted: Sequence[Candidate], family: str) -> list[tuple[str, Fit]]:
    return [(c.family, c.fit) for c in fitted if c.family != family][:1]


def _told_apart(proposal: Proposal, rivals: Sequence[Fit]) -> np.ndarray:
    """Delta chi-square (k, k): what the rival of a column would gain where that of a row is the truth."""
    try:
        foreseen = [proposal.foresee(rival) for rival in rivals]
    except InputError:  # it cannot be simulated so far from what was fitted
        return np.zeros((len(rivals), len(rivals)))
    table = np.zeros((len(rivals), len(rivals)))
    for i, truth in enumerate(foreseen):
        for j, rival in enumerate(foreseen):
            if i != j:
                table[i, j] = separation(rivals[j], rival.predicted - truth.predicted, rival.slopes)
    return table


def _fitted_again(proposal: Proposal, rivals: Sequence[Fit]) -> np.ndarray:
    """The same as `_told_apart` (k, k), with rivals fitted again where the proposal does so."""
    return np.array([[0.0 if truth is rival else proposal.left(truth, rival) for rival in rivals] for truth in rivals])


def _use(total: np.ndarray, table: np.ndarray) -> float:
    """What a further run brings between those two of the rivals to whom it matters most."""
    return float(np.max(np.minimum(total + table, ENOUGH) - np.minimum(total, ENOUGH)))


def _least(table: np.ndarray) -> float:
    """The delta chi-square of the two that are told apart worst."""
    return float(np.min(table[~np.eye(len(table), dtype=bool)]))


def _score(table: np.ndarray) -> float:
    """Over all that could be true, what the nearest rival would gain, as far as more is of use."""
    return float(np.mean(np.minimum(table[~np.eye(len(table), dtype=bool)], ENOUGH)))
