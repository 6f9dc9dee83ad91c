"""The confirmation of a verdict by chi-square: validation runs reject effects, forms and the base, and add none."""

from collections.abc import Sequence
from dataclasses import replace

from motofmi.gap.estimation.candidate import Candidate, adequate
from motofmi.gap.selection.by_chi_square import of_one, rivals
from motofmi.gap.selection.result import Verdict
from motofmi.gap.validation.validation_run import ValidationRuns


def with_validation(found: Verdict, validation: ValidationRuns) -> Verdict:
    """The verdict after validation: where a pair is rejected, one effect may be confirmed alone."""
    verdict = _confirmed(found, validation)
    if not verdict.rejected or len(found.effects) < 2:
        return verdict
    alone = _confirmed(of_one(found.base, found.candidates, validation.criteria), validation)
    return replace(alone, rejected=[*verdict.rejected, *alone.rejected])


def _confirmed(verdict: Verdict, validation: ValidationRuns) -> Verdict:
    """The verdict without the effects that validation runs reject.

    A tied effect is removed; where a named effect or the base is rejected the verdict is `unknown`.
    """
    if not validation or verdict.verdict == "unknown":
        return verdict
    if verdict.verdict == "none":
        return verdict if validation.predicted_by(verdict.base) else replace(verdict, verdict="unknown")
    if verdict.verdict == "named":
        return _confirmed_name(verdict, validation)
    confirmed = {c.family: _confirmed_form(verdict, c, validation) for c in verdict.tied}
    left, wrong = [c for c in confirmed.values() if c], [family for family, c in confirmed.items() if not c]
    replaced = _replaced([c for c in verdict.tied if confirmed[c.family]], left)
    if len(left) > 1:
        return replace(verdict, tied=left, best=left[0].fit, rejected=wrong, replaced_forms=replaced)
    if left:
        return replace(
            verdict,
            verdict="named",
            effects=[*left, *_beside(left[0], verdict.candidates)],
            tied=[],
            best=left[0].fit,
            unspecified_form=left[0].effect.flexible,
            rejected=wrong,
            replaced_forms=replaced,
        )
    return replace(verdict, verdict="unknown", tied=[], rejected=wrong)


def _confirmed_name(verdict: Verdict, validation: ValidationRuns) -> Verdict:
    """A named verdict after validation.

    Where only the form is rejected, another form or an unspecified one may be confirmed.
    """
    base, named = verdict.base, verdict.effects
    if not validation.reject(base, verdict.best, verdict.unspecified_form):
        return verdict
    others = rivals(named[0], verdict.candidates, validation.criteria)
    for unspecified_form in (False, True) if len(named) == 1 and not verdict.tied else ():
        form = _confirmed_form(verdict, named[0], validation, unspecified_form)
        if form and not (
            unspecified_form
            and any(not c.fitted or _confirmed_form(verdict, c, validation, unspecified_form) for c in others)
        ):
            return replace(
                verdict,
                effects=[form],
                best=form.fit,
                unspecified_form=unspecified_form or form.effect.flexible,
                replaced_forms=_replaced([named[0]], [form]),
            )
    return replace(verdict.as_unknown(), rejected=[" and ".join(c.family for c in named)])


def _beside(found: Candidate, candidates: Sequence[Candidate]) -> list[Candidate]:
    """The other effects of the fit of a candidate, as candidates with that fit."""
    others = [c for c in candidates if c.family != found.family and c.effect in found.fit.model.effects]
    return [replace(c, fit=found.fit) for c in others]


def _replaced(before: Sequence[Candidate], after: Sequence[Candidate]) -> list[str]:
    """The forms that were replaced by another one of their family."""
    return [
        f"{old.family}.{old.effect.form} by {new.effect.form}"
        for old, new in zip(before, after, strict=True)
        if old.effect is not new.effect
    ]


def _confirmed_form(
    verdict: Verdict, found: Candidate, validation: ValidationRuns, unspecified_form: bool = False
) -> Candidate | None:
    """The first form that validation runs do not reject, of those of the family that fit as well; None without one."""
    others = (c for c in verdict.candidates if c.family == found.family and c.fitted and c is not found)
    near = (
        c
        for c in others
        if found.delta_bic - c.delta_bic < validation.criteria.tie_delta_bic and adequate(c.fit, validation.criteria)
    )
    return next((c for c in (found, *near) if not validation.reject(verdict.base, c.fit, unspecified_form)), None)
