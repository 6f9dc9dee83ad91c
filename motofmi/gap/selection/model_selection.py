"""Model selection: which effect is missing, as none, named, tied or unknown.

    dchi2 = chi2(base) - chi2(base + effect),   dBIC = dchi2 - k ln n - 2 u

k are the parameters of the effect, n the data, u the unknowns of single runs (initial states). Every candidate is
fitted together with the base. A fit is adequate if its residuals are consistent with the noise. The first effect must
have a delta BIC above a threshold; adequate effects whose delta BIC is near the best one are tied. Where no single
effect is adequate, pairs are searched, and the families that all near-best pairs contain are named. Where no form of a
family is adequate, but the family closes nearly all of the excess and leads all others clearly, it is named with an
unspecified form. Validation runs select between forms that fit equally well, and confirm or reject named effects. After
a rejection the search is repeated without the rejected families; if no effect is confirmed, the verdict is `unknown`.
All thresholds are fields of `Criteria`.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial

from fmus.effects import Effect
from fmus.support.errors import InputError
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import adequate, best_of, by_chance, ranked
from motofmi.gap.estimation.fit_result import Fit, initial_guesses, with_initial_guesses
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.multi_start import fit_base
from motofmi.gap.estimation.stages import Stage, running
from motofmi.gap.models.any_model import AnyModel, AnyRun
from motofmi.gap.selection.by_chi_square import of_one, of_pairs
from motofmi.gap.selection.candidate_search import search_candidates
from motofmi.gap.selection.confirmation import with_validation
from motofmi.gap.selection.pairs import Pair, in_simplest_forms, pairs_of, shared_families, single_effects_instead
from motofmi.gap.selection.result import Verdict
from motofmi.gap.selection.unspecified_law import better_outside_library
from motofmi.gap.validation.before_after import before_and_after
from motofmi.gap.validation.validation_run import ValidationRuns


def select_model(
    model: AnyModel,
    runs: Sequence[AnyRun],
    library: Sequence[type[Effect]],
    validation: Sequence[AnyRun] = (),
    on_progress: Callable[[Verdict], None] = lambda verdict: None,
    known: list[Fit] | None = None,
    criteria: Criteria = Criteria(),
) -> Verdict:
    """The verdict on runs, with a model of the base and the effects of a library.

    Validation runs can only reject effects. The final fits use the noise that is estimated from the best fit.
    on_progress is called with an intermediate verdict after the fit of the base, after the single effects, and after
    each effect to which second ones were added. known are fits that serve as starts, see `search_candidates`. Raises
    InputError where the base cannot be fitted, and TimeUpError after a deadline.
    """
    known = known if known is not None else []
    validation_runs, rejected = ValidationRuns(validation, criteria), list[str]()

    def validated(found: Verdict) -> Verdict:
        verdict = with_validation(found, validation_runs)
        return replace(verdict, rejected=[*rejected, *verdict.rejected])

    def report(found: Verdict) -> None:
        on_progress(replace(found, conclude=lambda: _concluded(validated(found), validation_runs)))

    def selected(library: Sequence[type[Effect]]) -> Verdict:
        found = _select(model, runs, library, validation_runs, report, known)
        with running(Stage.VALIDATION):
            return validated(found)

    first = verdict = selected(library)
    left, rejected = library, verdict.rejected
    while verdict.verdict == "unknown" and any(e.family in rejected for e in left):
        left = [e for e in left if e.family not in rejected]
        verdict = selected(left)
        rejected = verdict.rejected
    verdict = replace(verdict if verdict.verdict in ("named", "tied") else first, rejected=rejected)
    with running(Stage.OUTSIDE):
        on_progress(replace(verdict, conclude=lambda: _concluded(verdict, validation_runs)))
        checked = _unless_outside_library(verdict, library, validation_runs)
    return _concluded(checked, validation_runs)


def _concluded(verdict: Verdict, validation: ValidationRuns) -> Verdict:
    """The verdict with the noise that is estimated from the best fit, and with its misfit on validation runs."""
    runs, criteria = validation.runs, validation.criteria
    with suppress(InputError):
        base, best = _refitted_with_remaining_noise(verdict)
        return replace(verdict, base=base, best=best, validation_gap=before_and_after(base, best, runs, criteria))
    name = " and ".join(effect.family for effect in verdict.best.model.effects)
    withheld = (
        f"{name} is not named: the best fit cannot be simulated again with the noise that it leaves." if name else ""
    )
    verdict = replace(verdict.as_unknown(withheld), best=verdict.base)
    with suppress(InputError):
        verdict.validation_gap = before_and_after(verdict.base, verdict.base, runs, criteria)
    return verdict


def _refitted_with_remaining_noise(verdict: Verdict) -> tuple[Fit, Fit]:
    """The base and the best fit, fitted again with the noise that is estimated from the best fit.

    Raises InputError where the best fit cannot be simulated again, or has a larger chi-square than the base.
    """
    base, best = verdict.base, verdict.best
    with_noise = best.runs_with_remaining_noise()
    again = fit(best.model, with_noise, best.x)
    if best is base:
        return again, again
    base = fit(base.model, with_initial_guesses(with_noise, initial_guesses(base.runs)), base.x)
    if again.chi2 > base.chi2:
        raise InputError(f"{best.model.component.name}: the chi-square of the best fit is above that of the base")
    return base, again


def _select(
    model: AnyModel,
    runs: Sequence[AnyRun],
    library: Sequence[type[Effect]],
    validation: ValidationRuns,
    on_progress: Callable[[Verdict], None],
    known: list[Fit],
) -> Verdict:
    """The verdict from base, single effects and pairs before validation."""
    criteria = validation.criteria
    verdict_of = partial(Verdict, criteria=criteria)
    with running(Stage.BASE):
        base = fit_base(model, runs, criteria)
        on_progress(verdict_of("unknown", base, base))
    with running(Stage.SINGLE_EFFECTS):
        first = search_candidates(base, library, known=known, criteria=criteria)
        best = best_of(first, criteria)
        on_progress(verdict_of("unknown", base, best.fit if best else base, candidates=first))
    if best is None or best.delta_bic < criteria.first_effect_delta_bic:
        if adequate(base, criteria):
            return verdict_of("none", base, base, candidates=first)
        most = f"; {best.family} gains {best.delta_bic:.3g}" if best else ""
        return verdict_of(
            "unknown", base, base, candidates=first,
            withheld=f"No effect of the library gains a delta BIC of {criteria.first_effect_delta_bic:g}{most}.",
        )  # fmt: skip
    single = of_one(base, first, criteria)
    on_progress(single)
    with running(Stage.PAIRS):
        law = None
        if not adequate(best.fit, criteria):
            law = better_outside_library(base, best.fit, library, criteria, failed=True)
        explained = law is not None and _consistent_with_noise(law.fit, criteria)
        if law is not None and explained and not (validation and validation.reject(base, law.fit)):
            return verdict_of("unknown", base, best.fit, candidates=first, outside_library=law)

        def with_second(leading: Pair) -> None:
            on_progress(replace(single, best=leading.second.fit) if single.verdict == "unknown" else single)

        pairs = pairs_of(best, first, library, criteria, with_second, known)
        if pairs and shared_families(pairs):
            certain = len(shared_families(pairs)) == 2
            found = in_simplest_forms(base, pairs[0], library, criteria) if certain else pairs[0]
            enough = single_effects_instead(base, found, library, criteria)
            if not enough:
                return of_pairs(base, found, pairs, first, criteria)
            first = ranked([*enough, *(c for c in first if c.effect not in [e.effect for e in enough])])
    return of_one(base, first, criteria)


def _unless_outside_library(verdict: Verdict, library: Sequence[type[Effect]], validation: ValidationRuns) -> Verdict:
    """The verdict, or `unknown` where most of the misfit remains or an effect outside the library explains more.

    The effect outside the library must not be rejected by validation runs.
    """
    named = verdict.verdict in ("named", "tied")
    compared, complete = verdict.outside_library is not None, adequate(verdict.base, validation.criteria)
    if compared or (complete and not named):
        return verdict
    law = better_outside_library(verdict.base, verdict.best, library, validation.criteria, verdict.unspecified_form)
    if law is not None and validation and validation.reject(verdict.base, law.fit, verdict.unspecified_form):
        law = None
    if law is None and named and _explained(verdict, validation):
        return verdict
    return replace(verdict.as_unknown(_leaves_much(verdict) if named and law is None else ""), outside_library=law)


def _leaves_much(verdict: Verdict) -> str:
    """The sentence on effects that leave most of a clear misfit."""
    names, least, are = verdict.names, verdict.criteria.explained_share, "are" if len(verdict.effects) > 1 else "is"
    return (
        f"{names} {are} not named: less than {least:.0%} of the excess over the noise is closed, on all runs together."
    )


def _explained(verdict: Verdict, validation: ValidationRuns) -> bool:
    """Whether the named effects close a sufficient share of the excess, or what remains is due to chance.

    With an unspecified form only the fitted runs are used.
    """
    base, best = verdict.base, verdict.best
    missed, left, freedom = base.chi2 - base.freedom, best.chi2 - best.freedom, best.freedom
    if validation and not verdict.unspecified_form:
        missed += validation.least_excess(base) * validation.count
        left += validation.least_excess(best) * validation.count
        freedom += validation.count
    return left < max(by_chance(freedom, validation.criteria), (1 - validation.criteria.explained_share) * missed)


def _consistent_with_noise(found: Fit, criteria: Criteria) -> bool:
    """Whether chi-square is within chance of its mean, so that no pair of effects could explain more."""
    return found.chi2 < found.freedom + by_chance(found.freedom, criteria)
