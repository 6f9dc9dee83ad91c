"""Which effect is missing: none, named, tied or unknown.

    dchi2 = chi2(base) - chi2(base + effect)        dBIC = dchi2 - k ln n - 2 u     (u unknowns of single runs: initial states)

Every candidate is fitted with the base refitted. An effect must gain dBIC 12; those within dBIC 10 of the best, and
as adequate, are tied. Adequate is a reduced chi-square that noise alone gives. Where no single effect is adequate, pairs
compete, and the families that all near-best pairs share are named. Where no form of a family is adequate, but the family
closes nearly all of the excess and beats every other by dBIC 40, it is named with its form open. Runs that were held out choose
between forms that fit as well. What they refute is taken back, and the rest of the library competes again: what they bear then is
the answer, else `unknown`.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace

from fmus.effects import Effect
from fmus.errors import InputError
from identification.gap.models.model import AnyModel, AnyRun
from identification.gap.naming.candidate import (
    CLEAR,
    SIGNIFICANT,
    TIE,
    Candidate,
    adequate,
    best_of,
    by_chance,
    one_each,
    ranked,
)
from identification.gap.naming.competing import compete
from identification.gap.naming.fitted import Fit, memories, remembering
from identification.gap.naming.fitting import fit
from identification.gap.naming.held_out import HeldOut, to_close
from identification.gap.naming.pairs import SECOND, Pair, alone, pairs_of, plainest, sure
from identification.gap.naming.showing import HeldOutGap, before_and_after
from identification.gap.naming.starting import fit_base
from identification.gap.naming.unlisted import better_unlisted

EXPLAINED = 0.5  # share of the excess that any name closes, where what is left is more than noise leaves by chance
CLOSED = 0.95  # share of the fitted runs' excess that a family with an open form closes: what is outside of the library has come to 0.94
FAR_FROM_NOISE = 10.0  # reduced chi-square from which nothing fits well enough for a name by itself


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
    held_out: HeldOutGap = None  # before and after on the runs that were held out

    def on(self, held: Sequence[AnyRun]) -> HeldOutGap:
        """The gap before and after on runs that were held out. Raises InputError where they cannot be simulated."""
        return before_and_after(self.base, self.best, held)


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
    held = HeldOut(holdout)
    first = verdict = _checked(_decide(model, runs, library, held, so_far, second, known), held)
    left, refuted = library, list(verdict.refuted)
    while verdict.verdict == "unknown" and any(e.family in refuted for e in left):
        left = [e for e in left if e.family not in refuted]
        verdict = _checked(_decide(model, runs, left, held, so_far, second, known), held)
        refuted += verdict.refuted
    verdict = replace(verdict if verdict.verdict in ("named", "tied") else first, refuted=refuted)
    verdict = _unless_unlisted(verdict, library, held)
    with suppress(InputError):
        verdict.base, verdict.best = _quieter(verdict)
        verdict.held_out = verdict.on(holdout)
        return verdict
    # It was simulated on the way to it only: nothing may rest on that.
    verdict = replace(verdict, verdict="unknown", best=verdict.base, effects=[], tied=[], open_form=False)
    with suppress(InputError):
        verdict.held_out = verdict.on(holdout)
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


def _decide(model: AnyModel, runs: Sequence[AnyRun], library: Sequence[type[Effect]], held: HeldOut, so_far: Callable[[Verdict], None],
            second: tuple[float, float], known: list[Fit]) -> Verdict:  # fmt: skip
    base = fit_base(model, runs)
    so_far(Verdict("unknown", base, base))
    first = compete(base, library, known=known)
    best = best_of(first)
    if best is None or best.delta_bic < SIGNIFICANT:
        return Verdict("none" if adequate(base) else "unknown", base, base, candidates=first)
    so_far(Verdict("unknown", base, best.fit, candidates=first))
    law = None if adequate(best.fit) else better_unlisted(base, best.fit, library, failed=True)
    if law is not None and _leaves_nothing(law.fit) and not (held and held.refute(base, law.fit)):
        return Verdict("unknown", base, best.fit, candidates=first, unlisted=law)
    pairs = pairs_of(best, first, library, second, lambda leading: so_far(Verdict("unknown", base, leading.second.fit, candidates=first)), known)
    if pairs and sure(pairs):
        found = plainest(base, pairs[0], library) if len(sure(pairs)) == 2 else pairs[0]
        enough = alone(base, found, library, second)
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
    if best.fit.reduced - 1 < (1 - to_close(base, CLOSED)) * (base.reduced - 1) and not _rivals(best, first):
        return Verdict("named", base, best.fit, [best], [], first, open_form=True)
    return Verdict("unknown", base, best.fit, candidates=first)


def _rivals(best: Candidate, first: Sequence[Candidate]) -> list[Candidate]:
    """Those of other families of which an effect is not clear."""
    return [c for c in one_each(first) if c.family != best.family and best.delta_bic - c.delta_bic <= CLEAR]


def _of_pairs(base: Fit, found: Pair, pairs: Sequence[Pair], first: list[Candidate]) -> Verdict:
    """Both effects where the best pair stands alone; else the one that all share, with the possible seconds as tied."""
    families = sure(pairs)
    if len(families) == 2:
        return Verdict("named", base, found.second.fit, [*found.members], [], first)
    members = [c for pair in pairs for c in pair.members]
    certain = next(c for c in members if c.family in families)
    return Verdict("named", base, found.second.fit, [certain], [c for c in members if c.family not in families], first)


def _checked(found: Verdict, held: HeldOut) -> Verdict:
    """What held-out runs bear of a verdict: of a pair that they refute one effect alone, if that."""
    verdict = _borne_out(found, held)
    if not verdict.refuted or len(found.effects) < 2:
        return verdict
    alone = _borne_out(_of_one(found.base, found.candidates), held)
    return replace(alone, refuted=[*verdict.refuted, *alone.refuted])


def _borne_out(verdict: Verdict, held: HeldOut) -> Verdict:
    """The verdict without what held-out runs refute: members of a tie drop out, a name or a base that is as good as noise becomes `unknown`."""
    if not held or verdict.verdict == "unknown":
        return verdict
    if verdict.verdict == "none":
        return verdict if held.foretold(verdict.base) else replace(verdict, verdict="unknown")
    if verdict.verdict == "named":
        return _name_borne_out(verdict, held)
    borne = {c.family: _form_borne_out(verdict, c, held) for c in verdict.tied}
    left, wrong = [c for c in borne.values() if c], [family for family, c in borne.items() if not c]
    if len(left) > 1:
        return replace(verdict, tied=left, best=left[0].fit, refuted=wrong)
    if left:
        return replace(verdict, verdict="named", effects=left, tied=[], best=left[0].fit, open_form=left[0].effect.flexible, refuted=wrong)
    return replace(verdict, verdict="unknown", tied=[], refuted=wrong)


def _name_borne_out(verdict: Verdict, held: HeldOut) -> Verdict:
    """The same of a name; where its form alone is refuted, it may have another one, or an open one."""
    base, named = verdict.base, verdict.effects
    if not held.refute(base, verdict.best, verdict.open_form):
        return verdict
    rivals = _rivals(named[0], verdict.candidates)
    for open_form in (False, True) if len(named) == 1 and not verdict.tied else ():
        form = _form_borne_out(verdict, named[0], held, open_form)
        if form and not (open_form and any(not c.fitted or _form_borne_out(verdict, c, held, open_form) for c in rivals)):
            return replace(verdict, effects=[form], best=form.fit, open_form=open_form or form.effect.flexible)
    return replace(verdict, verdict="unknown", effects=[], tied=[], open_form=False, refuted=[" and ".join(c.family for c in named)])


def _form_borne_out(verdict: Verdict, found: Candidate, held: HeldOut, open_form: bool = False) -> Candidate | None:
    """Of the forms of a family that fit as well as the one that was found, the first that held-out runs bear."""
    others = (c for c in verdict.candidates if c.family == found.family and c.fitted and c is not found)
    near = (c for c in others if found.delta_bic - c.delta_bic < TIE and adequate(c.fit))
    return next((c for c in (found, *near) if not held.refute(verdict.base, c.fit, open_form)), None)


def _unless_unlisted(verdict: Verdict, library: Sequence[type[Effect]], held: HeldOut) -> Verdict:
    """The verdict, `unknown` where most is left unexplained, or where a law without a name explains more and the held-out runs bear it."""
    named = verdict.verdict in ("named", "tied")
    if verdict.unlisted or (not named and adequate(verdict.base)):  # it is known by now, or nothing is missing in the fitted runs
        return verdict
    law = better_unlisted(verdict.base, verdict.best, library, verdict.open_form)
    if law is not None and held and held.refute(verdict.base, law.fit, verdict.open_form):
        law = None
    if law is None and named and _explained(verdict, held):
        return verdict
    return replace(verdict, verdict="unknown", effects=[], tied=[], open_form=False, unlisted=law)


def _explained(verdict: Verdict, held: HeldOut) -> bool:
    """Whether what was named closes a good part of what the base misses, or all but what chance leaves; a form that is open, in the fitted runs."""
    base, best = verdict.base, verdict.best
    missed, left, freedom = base.chi2 - base.freedom, best.chi2 - best.freedom, best.freedom
    if held and not verdict.open_form:
        missed, left = missed + held.unexplained(base) * held.count, left + held.unexplained(best) * held.count
        freedom += held.count
    return left < max(by_chance(freedom), (1 - EXPLAINED) * missed)


def _leaves_nothing(found: Fit) -> bool:
    """Whether a fit is so good that no pair of effects could explain more."""
    return found.chi2 < found.freedom + by_chance(found.freedom)
