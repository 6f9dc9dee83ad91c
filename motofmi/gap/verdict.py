"""The contents of `verdict.json`: every key is always present, every parameter has value, standard error and unit."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from fmus.effects import Effect
from fmus.effects.added_terms import added_terms
from motofmi.gap.alternatives import alternatives, reason, with_errors
from motofmi.gap.compared import closed_alone, compared
from motofmi.gap.comparison.outcome import WEAKER
from motofmi.gap.estimation.candidate import Candidate, adequate, reduced_by_noise
from motofmi.gap.estimation.fit_result import parameters_of, parameters_of_effect, undetermined
from motofmi.gap.localisation.harmonic_places import cells as of_harmonics
from motofmi.gap.localisation.locating import Cells, locate
from motofmi.gap.selection.remainder import complete, explained, remainder
from motofmi.gap.selection.result import Verdict
from motofmi.gap.selection.ties import equivalent
from motofmi.gap.validation.before_after import floor, misfit_of


def as_result(verdict: Verdict, unit: str, noise_source: str = "orders", cells: Cells = of_harmonics) -> dict[str, Any]:
    """The verdict under the keys of the file; model, FMU and report are null until they are written.

    unit is that of the output, noise_source the source of its noise; cells gives the cells of a run in which misfit is
    located.
    """
    best = verdict.best
    chances, left, alone = _probabilities(verdict), gap(verdict, unit), closed_alone(verdict)
    said = [*_limitations(verdict), *_validation_limitations(verdict, left)]
    return {
        "verdict": verdict.verdict,
        "effects": [_effect(verdict, c, chances) for c in verdict.effects] if verdict.verdict == "named" else [],
        "tied": [c.family for c in verdict.tied] if verdict.verdict == "tied" else [],
        "closest": _closest(verdict) if verdict.verdict == "unknown" else None,
        "alternatives": alternatives(verdict),
        "reason": reason(verdict, said),
        "candidates": [_candidate(c, chances, alone) for c in _distinct(verdict.candidates)],
        "compared": compared(verdict),
        "where": [
            {
                "run": p.run,
                "axis": p.axis,
                "order": p.order,
                "from": p.start,
                "to": p.end,
                "unit": p.unit,
                "excess": p.excess,
                "p_value": p.p_value,
            }
            for p in locate(verdict.base, cells, verdict.criteria)
        ],
        "gap": left,
        "base": with_errors({n: p for n, p in parameters_of(best).items() if n in best.model.base}),
        "complete": complete(verdict),
        "explained": explained(verdict),
        "remainder": remainder(verdict, unit),
        "disagreement": (verdict.comparison.outcome.disagreement or None) if verdict.comparison else None,
        "noise_source": noise_source,
        "next_experiment": None,
        "ended": verdict.ended or None,
        "limitations": said,
        "criteria": asdict(verdict.criteria),
        "model": None,
        "fmu": None,
        "report": None,
    }  # fmt: skip


def _limitations(verdict: Verdict) -> list[str]:
    """The assumptions of the verdict, and the questions that the data do not decide."""
    sentences = list(verdict.comparison.outcome.sentences) if verdict.comparison else []
    for candidate in verdict.effects:
        if names := unidentified(verdict, candidate.effect):
            sentences.append(
                f"{candidate.family}: {' and '.join(names)} {'are' if names[1:] else 'is'} not identifiable from these "
                f"data (within {verdict.criteria.value_errors:g} standard errors of zero)."
            )
    if verdict.verdict == "named" and len(verdict.effects) == 1:
        name = verdict.effects[0].family
        if same := equivalent(verdict.best, verdict.effects[0], verdict.candidates, verdict.criteria):
            sentences.append(
                f"In these recordings {' or '.join(same)} is not distinguishable from {name}: they differ only in the "
                "sign that each must have and in the prior knowledge of the base."
            )
        if verdict.tied:
            sentences.append(
                f"A second effect is missing besides {name}: one of "
                f"{', '.join(dict.fromkeys(c.family for c in verdict.tied))}."
            )
    if verdict.verdict == "tied" and not verdict.comparison:
        tied = list(dict.fromkeys(c.family for c in verdict.tied))
        beside = {e.family for c in verdict.tied for e in c.fit.model.effects} - set(tied)
        sentences += [WEAKER.format(name, " or ".join(tied)) for name in sorted(beside)]
    if verdict.outside_library and not verdict.comparison:
        law, name = (
            verdict.outside_library,
            " and ".join(dict.fromkeys(e.family for e in verdict.best.model.effects)) or "all of them",
        )
        sentences.append(f"An effect outside the library explains the data better than {name} (delta chi-square "
                         f"{law.delta_chi2:.4g}): "
                         f"{law.effect.sentence()}")  # fmt: skip
    if verdict.withheld and verdict.verdict in ("unknown", "none"):
        sentences.append(verdict.withheld)
    if verdict.replaced_forms:
        sentences.append("The validation run rejects a form that fits as well, which was replaced: "
                         f"{', '.join(verdict.replaced_forms)}.")  # fmt: skip
    if verdict.rejected:
        sentences.append(f"The validation run rejects what fits as well or better: {', '.join(verdict.rejected)}.")
    return sentences


def _validation_limitations(verdict: Verdict, left: dict[str, Any]) -> list[str]:
    """Sentences on misfit that the verdict leaves, mostly on validation runs; left is its gap."""
    missed, predicted = left["holdout_after"], verdict.criteria.predicted_reduced_chi2
    if verdict.comparison or (verdict.ended and verdict.verdict == "unknown"):
        return []
    if verdict.unspecified_form:
        return _unspecified_form(verdict, left)
    if missed is None or missed < predicted:
        return []
    if verdict.verdict == "named":
        return ["The fitted runs leave some values too uncertain to predict the validation run (reduced chi-square "
                f"{missed:.2g} with all values fixed); "
                "within their standard errors they explain it. Fit more runs."]  # fmt: skip
    if verdict.verdict == "unknown" and adequate(verdict.best, verdict.criteria):
        return ["The model is adequate for the fitted runs but not for the validation run (reduced chi-square "
                f"{missed:.2g}): the missing effect is not "
                "identifiable from the fitted runs alone. Fit the validation run too."]  # fmt: skip
    return []


def _unspecified_form(verdict: Verdict, left: dict[str, Any]) -> list[str]:
    """The sentence on a form that is not one of the library, with the runs that it does not explain."""
    missed, family = left["holdout_after"], verdict.effects[0].family
    said = "the form is unspecified, and the parameters are those of the nearest form."
    if left["after"] >= reduced_by_noise(verdict.best, verdict.criteria):
        on_validation = f", {missed:.2g} on the validation run" if missed is not None else ""
        return [
            f"No form of {family} in the library is adequate (reduced chi-square {left['after']:.2g}{on_validation}): "
            f"{said}"
        ]
    if missed is not None and missed > verdict.criteria.predicted_reduced_chi2:
        return [f"The form of {family} is adequate for the fitted runs (reduced chi-square {left['after']:.2g}), "
                f"but not for the validation run ({missed:.2g}): {said}"]  # fmt: skip
    return []


def gap(verdict: Verdict, unit: str) -> dict[str, Any]:
    """The misfit before and after, on fitted and on validation runs, as reduced chi-square and as rms."""
    before, after, validated = misfit_of(verdict.base), misfit_of(verdict.best), verdict.validation_gap
    return {
        "before": before.chi2,
        "after": after.chi2,
        "holdout_before": validated[0].chi2 if validated else None,
        "holdout_after": validated[1].chi2 if validated else None,
        "noise_floor": 1.0,
        "rms": {
            "before": before.rms,
            "after": after.rms,
            "holdout_before": validated[0].rms if validated else None,
            "holdout_after": validated[1].rms if validated else None,
            "noise_floor": floor(validated[1].fit.runs if validated else verdict.base.runs),
            "unit": unit,
        },
    }


def _probabilities(verdict: Verdict) -> dict[int, float]:
    """The probability of each candidate against the others, against none and effects outside the library.

    From the BIC with equal prior odds, one form per family.
    """
    first: dict[str, Candidate] = {}
    for c in verdict.candidates:
        first.setdefault(c.family, c)
    for c in verdict.effects:
        if c.family in first:
            first[c.family] = c
    members = list(first.values())
    unnamed = [0.0, *([verdict.outside_library.delta_bic] if verdict.outside_library else [])]
    exponents = np.array([*unnamed, *(c.delta_bic for c in members)]) / 2
    weights = np.exp(exponents - exponents.max())
    chances = weights[len(unnamed) :] / weights.sum()
    result = {id(c): float(p) for c, p in zip(members, chances, strict=True)}
    for c in verdict.effects[1:]:
        result[id(c)] = float(1 / (1 + np.exp(-min(c.delta_bic, 600) / 2)))
    # The table of candidates has the named effects as single ones, with the probability that they have together.
    for c in verdict.effects:
        alone = next((other for other in verdict.candidates if other.effect is c.effect), c)
        result[id(alone)] = result.get(id(c), 1.0)
    return result


def _distinct(candidates: Sequence[Candidate]) -> list[Candidate]:
    """The best of every form, in order."""
    seen: dict[tuple[str, str], Candidate] = {}
    for c in candidates:
        seen.setdefault((c.family, c.effect.form), c)
    return list(seen.values())


def _effect(verdict: Verdict, candidate: Candidate, chances: dict[int, float]) -> dict[str, Any]:
    """The effect with its parameters from the last fit."""
    effect = candidate.effect
    open_ = verdict.unspecified_form and candidate is verdict.effects[0]
    unknown = unidentified(verdict, effect)
    own = {n: found for n, found in parameters_of_effect(verdict.best, effect).items() if n not in unknown}
    return {"name": effect.family, "form": "open" if open_ else effect.form, "element": effect.element or None,
            "sentence": effect.sentence(), "equations": added_terms(effect),
            "probability": chances.get(id(candidate), 1.0), "delta_chi2": candidate.delta_chi2,
            "delta_bic": candidate.delta_bic, "parameters": with_errors(own)}  # fmt: skip


def _candidate(
    candidate: Candidate, chances: dict[int, float], alone: Mapping[tuple[str, str], float]
) -> dict[str, Any]:
    """A row of the table of candidates; validation is None where the effect was not evaluated on validation runs."""
    return {
        "name": candidate.family,
        "form": candidate.effect.form,
        "element": candidate.effect.element or None,
        "sentence": candidate.effect.sentence(),
        "delta_chi2": candidate.delta_chi2,
        "delta_bic": candidate.delta_bic,
        "probability": chances.get(id(candidate), 0.0),
        "validation": alone.get((candidate.family, candidate.effect.form)),
        "fitted": candidate.fitted,
    }


def unidentified(verdict: Verdict, effect: type[Effect]) -> list[str]:
    """The parameters of an effect that the data do not distinguish from zero: no values of them.

    The list is empty where the effect is not in the best fit, or has a prior, with which every value is known.
    """
    if effect not in verdict.best.model.effects or effect.prior is not None:
        return []
    return undetermined(parameters_of_effect(verdict.best, effect), verdict.criteria.value_errors)


def _closest(verdict: Verdict) -> dict[str, Any] | None:
    """The best candidate of an unknown verdict; None where no candidate has a positive delta BIC."""
    if not verdict.candidates or verdict.candidates[0].delta_bic < 0:
        return None
    best = verdict.candidates[0]
    return {"name": best.family, "delta_bic": best.delta_bic}
