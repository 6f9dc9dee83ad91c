"""Which effect is missing: none, named, tied or unknown.

    dchi2 = chi2(base) - chi2(base + effect)        dBIC = dchi2 - k ln n - 2 u     (u unknowns of single runs: initial states)

Every candidate is fitted with the base refitted. An effect must gain dBIC 12; those within dBIC 10 of the best, and
as adequate, are tied. Adequate is a reduced chi-square that noise alone gives. Where no single effect is adequate, pairs
compete, and the families that all near-best pairs share are named. Where no form of a family is adequate, but the family
closes most of the excess and beats every other by dBIC 40, it is named with its form open. What runs that were held out
refute is taken back, and the rest of the library competes again: what those runs bear then is the answer, else `unknown`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fmus.effects import Effect
from fmus.errors import InputError
from identification.gap.models.model import AnyModel, AnyRun
from identification.gap.naming.competing import (
    CLEAR,
    SIGNIFICANT,
    TIE,
    Candidate,
    adequate,
    best_of,
    compete,
    one_each,
    ranked,
)
from identification.gap.naming.fitting import Fit, fit, memories, remembering
from identification.gap.naming.pairs import SECOND, Pair, alone, pairs_of, plainest, sure
from identification.gap.naming.showing import FORETOLD, Closeness, on_holdout, surprise
from identification.gap.naming.starting import fit_base
from identification.gap.naming.unlisted import better_unlisted

EXPLAINED = 0.5  # share of the excess that any name closes, where what is left is more than noise leaves by chance:
BY_CHANCE = 2.5  # standard deviations of a reduced chi-square
CLOSED = 0.85  # share of the excess that a family with an open form closes, on fitted runs and on held-out ones
CLOSED_OF_FLEXIBLE = 0.5  # the same where the noise is what a flexible model leaves, which no form of one law reaches
MISSED = 0.2  # reduced chi-square above 1 by which a held-out run refutes a name, beyond a share of what the base misses
SHARE_MISSED = 0.005  # that share
FAR_FROM_NOISE = 10.0  # reduced chi-square from which nothing fits well enough for a name by itself
SCATTER = 4.5  # standard deviations of a reduced chi-square, as for fitted runs
SURPRISED = 3.0  # the same of held-out runs where the values may move by their errors


@dataclass
class Verdict:
    """What was found. `best` is the fit that it rests on; candidates are those of every round, the best first."""

    verdict: str
    base: Fit
    best: Fit
    effects: list[Candidate] = field(default_factory=list)
    tied: list[Candidate] = field(default_factory=list)
    candidates: list[Candidate] = field(default_factory=list)
    open_form: bool = False
    refuted: list[str] = field(default_factory=list)  # what fits best, but not the held-out runs
    unlisted: Candidate | None = None  # a law without a name that explains more than any name


def decide(model: AnyModel, runs: Sequence[AnyRun], library: Sequence[type[Effect]], holdout: Sequence[AnyRun] = (),
           so_far: Callable[[Verdict], None] = lambda verdict: None, second: tuple[float, float] = SECOND,
           known: list[Fit] | None = None) -> Verdict:  # fmt: skip
    """The verdict on runs, with a model of the base and the effects of a library; held-out runs can only take names back.

    Its fits rest on the noise that the best of them leaves. so_far is told, as unknown, what is known after the base, after
    the effects, and after each effect that was tried with a second one. second is the
    dBIC that a second effect must gain, and its share of the first one's gain; known are fits from which to begin, see `compete`.
    Raises InputError where the base cannot be fitted.
    """
    known = known if known is not None else []
    first = verdict = _checked(_decide(model, runs, library, so_far, second, known), holdout)
    left, refuted = library, list(verdict.refuted)
    while verdict.verdict == "unknown" and any(e.family in refuted for e in left):
        left = [e for e in left if e.family not in refuted]
        verdict = _checked(_decide(model, runs, left, so_far, second, known), holdout)
        refuted += verdict.refuted
    verdict = replace(verdict if verdict.verdict in ("named", "tied") else first, refuted=refuted)
    try:
        verdict = _unless_unlisted(verdict, library, holdout)
        verdict.base, verdict.best = _quieter(verdict)
        if holdout:
            on_holdout(verdict.best, holdout)
    except InputError:  # it was simulated on the way to it only: nothing may rest on that
        return replace(verdict, verdict="unknown", best=verdict.base, effects=[], tied=[], open_form=False)
    return verdict


def _quieter(verdict: Verdict) -> tuple[Fit, Fit]:
    """Base and best fitted to runs with the noise that the best leaves. Raises InputError where it cannot be simulated."""
    base, best = verdict.base, verdict.best
    quiet = [best.model.with_noise_beside(run, best.of_run(i)) for i, run in enumerate(best.runs)]
    again = fit(best.model, quiet, best.x)
    if best is base:
        return again, again
    base = fit(base.model, remembering(quiet, memories(base.runs)), base.x)
    if again.chi2 > base.chi2:
        raise InputError(f"{best.model.component.name}: the simulation lost its way")
    return base, again


def _decide(model: AnyModel, runs: Sequence[AnyRun], library: Sequence[type[Effect]], so_far: Callable[[Verdict], None],
            second: tuple[float, float], known: list[Fit]) -> Verdict:  # fmt: skip
    base = fit_base(model, runs)
    so_far(Verdict("unknown", base, base))
    first = compete(base, library, known=known)
    best = best_of(first)
    if best is None or best.delta_bic < SIGNIFICANT:
        return Verdict("none" if adequate(base) else "unknown", base, base, candidates=first)
    so_far(Verdict("unknown", base, best.fit, candidates=first))
    pairs = pairs_of(best, first, library, second, lambda leading: so_far(Verdict("unknown", base, leading.second.fit, candidates=first)), known)
    if pairs and sure(pairs):
        found = plainest(base, pairs[0], library) if len(sure(pairs)) == 2 else pairs[0]
        enough = alone(base, found, second)
        if not enough:
            return _of_pairs(base, found, pairs, first)
        first = ranked([*enough, *(c for c in first if c.effect not in [e.effect for e in enough])])
    return _of_one(base, first)


def _of_one(base: Fit, first: list[Candidate]) -> Verdict:
    """The verdict where one effect is missing."""
    best = best_of(first)
    if best is None:
        return Verdict("unknown", base, base, candidates=first)
    if adequate(best.fit):
        tied = [c for c in one_each(first) if c.fitted and best.delta_bic - c.delta_bic < TIE and adequate(c.fit)]
        if len(tied) > 1:
            return Verdict("tied", base, best.fit, [], tied, first)
        return Verdict("named", base, best.fit, [best], [], first, best.effect.flexible)
    closed = best.fit.reduced - 1 < (1 - _closed(base)) * (base.reduced - 1)
    if closed and _leads(best, first):
        return Verdict("named", base, best.fit, [best], [], first, open_form=True)
    return Verdict("unknown", base, best.fit, candidates=first)


def _leads(best: Candidate, first: Sequence[Candidate]) -> bool:
    """Whether an effect is clear of every other family."""
    return all(best.delta_bic - c.delta_bic > CLEAR for c in one_each(first) if c.family != best.family)


def _of_pairs(base: Fit, found: Pair, pairs: Sequence[Pair], first: list[Candidate]) -> Verdict:
    """Both effects where the best pair stands alone; else the one that all share, with the possible seconds as tied."""
    families = sure(pairs)
    if len(families) == 2:
        return Verdict("named", base, found.second.fit, [*found.members], [], first)
    members = [c for pair in pairs for c in pair.members]
    certain = next(c for c in members if c.family in families)
    return Verdict("named", base, found.second.fit, [certain], [c for c in members if c.family not in families], first)


def _checked(found: Verdict, holdout: Sequence[AnyRun]) -> Verdict:
    """What held-out runs bear of a verdict: of a pair that they refute one effect alone, if that."""
    verdict = _borne_out(found, holdout)
    if not verdict.refuted or len(found.effects) < 2:
        return verdict
    alone = _borne_out(_of_one(found.base, found.candidates), holdout)
    return replace(alone, refuted=[*verdict.refuted, *alone.refuted])


def _borne_out(verdict: Verdict, holdout: Sequence[AnyRun]) -> Verdict:
    """The verdict without what held-out runs refute: members of a tie drop out, a name or a base that is as good as noise becomes `unknown`."""
    if not holdout or verdict.verdict == "unknown":
        return verdict
    if verdict.verdict == "none":
        return verdict if _foretold(verdict.base, holdout) else replace(verdict, verdict="unknown")
    before = on_holdout(verdict.base, holdout)
    if verdict.verdict == "named":
        if not _refuted(before, verdict.best, holdout, verdict.open_form):
            return verdict
        if len(verdict.effects) == 1 and _leads(verdict.effects[0], verdict.candidates) and not _refuted(before, verdict.best, holdout, open_form=True):
            return replace(verdict, open_form=True)  # the family is right, its form is not where the held-out run goes further
        return replace(verdict, verdict="unknown", effects=[], tied=[], open_form=False, refuted=[" and ".join(c.family for c in verdict.effects)])
    wrong = [c.family for c in verdict.tied if _refuted(before, c.fit, holdout)]
    left = [c for c in verdict.tied if c.family not in wrong]
    if len(left) > 1:
        return replace(verdict, tied=left, best=left[0].fit, refuted=wrong)
    if left:
        return replace(verdict, verdict="named", effects=left, tied=[], best=left[0].fit, open_form=left[0].effect.flexible, refuted=wrong)
    return replace(verdict, verdict="unknown", tied=[], refuted=wrong)


def _unless_unlisted(verdict: Verdict, library: Sequence[type[Effect]], holdout: Sequence[AnyRun]) -> Verdict:
    """The verdict, `unknown` where most is left unexplained, or where a law without a name explains more and the held-out runs bear it."""
    if verdict.verdict not in ("named", "tied"):
        return verdict
    law = better_unlisted(verdict.base, verdict.best, library)
    if law is not None and holdout and _refuted(on_holdout(verdict.base, holdout), law.fit, holdout):
        law = None
    if law is None and _explained(verdict, holdout):
        return verdict
    return replace(verdict, verdict="unknown", effects=[], tied=[], open_form=False, unlisted=law)


def _explained(verdict: Verdict, holdout: Sequence[AnyRun]) -> bool:
    """Whether what was named closes a good part of what the base misses, or all but what chance leaves; a form that is open, in the fitted runs."""
    base, best = verdict.base, verdict.best
    missed, left, freedom = base.chi2 - base.freedom, best.chi2 - best.freedom, best.freedom
    if holdout and not verdict.open_form:
        before, after = on_holdout(base, holdout), on_holdout(best, holdout)
        count = after.fit.count
        missed, left, freedom = missed + (before.chi2 - 1) * count, left + (after.chi2 - 1) * count, freedom + count
    return left < max(BY_CHANCE * np.sqrt(2 * freedom), (1 - EXPLAINED) * missed)


def _foretold(base: Fit, holdout: Sequence[AnyRun]) -> bool:
    """Whether a base explains held-out runs, be it with other values than fitted, within their errors."""
    try:
        held = on_holdout(base, holdout)
        return held.chi2 < FORETOLD or surprise(base, held) < FORETOLD
    except InputError:  # not even simulated
        return False


def _refuted(before: Closeness, found: Fit, holdout: Sequence[AnyRun], open_form: bool = False) -> bool:
    """Whether held-out runs are missed by more than noise, and by more than a name may leave of what the base misses.

    An effect that closes most of what the base misses there is not refuted by what the errors of its values explain.
    """
    try:
        after = on_holdout(found, holdout)
        scatter = np.sqrt(2 / after.fit.count)  # few data scatter by more
        allowed = max((1 - _closed(found) if open_form else SHARE_MISSED) * (before.chi2 - 1), MISSED, SCATTER * scatter)
        if after.chi2 - 1 <= allowed:
            return False
        closes = after.chi2 - 1 < (1 - CLOSED) * (before.chi2 - 1)
        return not closes or surprise(found, after) - 1 > SURPRISED * scatter
    except InputError:  # not even simulated
        return True


def _closed(found: Fit) -> float:
    """The share of the excess that a family with an open form must close."""
    flexible = any(getattr(run, "noise_source", "") == "flexible_model" for run in found.runs)
    return CLOSED_OF_FLEXIBLE if flexible else CLOSED
