"""Which effect is missing: none, named, tied or unknown.

    dchi2 = chi2(base) - chi2(base + effect)        dBIC = dchi2 - k ln n

Every candidate is fitted with the base refitted. An effect must gain dBIC 12; those within dBIC 10 of the best, and
as adequate, are tied. Adequate is a reduced chi-square that noise alone gives. Where no form of a family is adequate,
but the family closes over half of the excess and beats every other by dBIC 40, it is named with its form open.
A second effect must gain dBIC 15 and half a per cent of what the first gained.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from fmus.effects import Effect
from fmus.errors import InputError
from identification.gap.competing import CLEAR, SIGNIFICANT, TIE, Candidate, adequate, best_of, compete, one_each
from identification.gap.fitting import Fit, fit
from identification.gap.model import AnyModel, AnyRun
from identification.gap.screening import Signature, screen
from identification.gap.starting import fit_base

SECOND = 15.0  # dBIC of a second one
SHARE = 0.005  # of the first one's gain: below it, small errors of the model of a large effect look like another


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


def decide(model: AnyModel, runs: Sequence[AnyRun], library: Sequence[type[Effect]]) -> Verdict:
    """The verdict on runs, with a model of the base and the effects of a library. Raises InputError where the base cannot be fitted.

    Its fits rest on the noise that the best of them leaves.
    """
    verdict = _decide(model, runs, library)
    best = verdict.best
    quiet = [best.model.with_noise_beside(run, best.of_run(i)) for i, run in enumerate(runs)]
    if best is verdict.base:
        verdict.base = verdict.best = fit(best.model, quiet, best.x)
    else:
        verdict.base, verdict.best = (fit(f.model, quiet, f.x) for f in (verdict.base, best))
    return verdict


def _decide(model: AnyModel, runs: Sequence[AnyRun], library: Sequence[type[Effect]]) -> Verdict:
    base = fit_base(model, runs)
    first = compete(base, library)
    best = best_of(first)
    if best is None or best.delta_bic < SIGNIFICANT:
        return Verdict("none" if adequate(base) else "unknown", base, base, candidates=first)
    second = _second(best, library)
    found = Verdict("named", base, best.fit, [best], candidates=first)
    if second is not None:
        members = [c for c in second[1] if second[0].delta_bic - c.delta_bic < TIE and c.family != second[0].family]
        if adequate(second[0].fit):
            pair = _plainest(base, best, second[0], library)
            return Verdict("named", base, pair[1].fit, list(pair), members, first)
    if adequate(best.fit):
        found.tied = [c for c in one_each(first) if best.delta_bic - c.delta_bic < TIE and adequate(c.fit)]
        if len(found.tied) > 1:
            found.verdict, found.effects = "tied", []
        else:
            found.tied = []
            found.open_form = best.effect.flexible
        return found
    others = [c for c in one_each(first) if c.family != best.family]
    excess, left = base.reduced - 1, best.fit.reduced - 1
    if left < 0.5 * excess and all(best.delta_bic - c.delta_bic > CLEAR for c in others):
        found.open_form = True
        return found
    return Verdict("unknown", base, best.fit, candidates=first)


def _plainest(base: Fit, first: Candidate, second: Candidate, library: Sequence[type[Effect]]) -> tuple[Candidate, Candidate]:
    """The two effects in the forms that fit best together: alone, the first one's form makes up for the second."""
    best, pair = second.fit, (first.effect, second.effect)
    for place in (0, 1):
        for form in [e for e in library if e.family == pair[place].family and e is not pair[place] and not e.flexible]:
            tried = (form, pair[1]) if place == 0 else (pair[0], form)
            model = base.model.joined_by(*tried)
            shared = best.x[: len(base.model.names)]
            signature = screen(base, [form], keep=1)
            if not signature:
                continue
            kept = [best.x[best.model.names.index(model.stand.parameter(e, n))] if e in pair else s
                    for e in tried for n, s in zip([n for n in e.parameters() if n not in e.given], _start(signature[0], e), strict=True)]  # fmt: skip
            try:
                found = fit(model, base.runs, np.concatenate([shared, kept]))
            except InputError:
                continue
            if _bic(found) < _bic(best) + TIE * (len(model.names) < len(best.model.names)):
                best, pair = found, tried
    gains = [(base.chi2 - first.fit.chi2), first.fit.chi2 - best.chi2]
    return tuple(Candidate(e, best, g, g - np.log(base.count) * sum(n not in e.given for n in e.parameters()))  # type: ignore[return-value]
                 for e, g in zip(pair, gains, strict=True))


def _start(signature: Signature, effect: type[Effect]) -> np.ndarray:
    """Where an effect's parameters start: the signature's, or wherever they are (the caller reads those)."""
    return signature.start if effect is signature.effect else np.zeros(sum(n not in effect.given for n in effect.parameters()))


def _bic(found: Fit) -> float:
    return found.chi2 + len(found.model.names) * float(np.log(found.count))


def _second(best: Candidate, library: Sequence[type[Effect]]) -> tuple[Candidate, list[Candidate]] | None:
    """A second effect on top of the first, with its rivals, if there is one."""
    rivals = compete(best.fit, library, leaders=4)
    found = best_of(rivals)
    threshold = max(SECOND, SHARE * best.delta_chi2)
    if found is None or found.delta_bic < threshold:
        return None
    return found, one_each(rivals)

