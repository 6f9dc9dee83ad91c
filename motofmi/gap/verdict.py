"""The verdict as `verdict.json` says it: every key always there, every parameter with value, error and unit."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from identification.gap.naming.candidate import Candidate, adequate
from identification.gap.naming.decide import Verdict
from identification.gap.naming.fitted import parameters_of
from identification.gap.naming.showing import FORETOLD, closeness, floor
from identification.gap.naming.ties import equivalent
from identification.gap.reporting.harmonic_places import cells as of_harmonics
from identification.gap.reporting.locating import Cells, locate


def as_result(verdict: Verdict, unit: str, noise_source: str = "orders", cells: Cells = of_harmonics) -> dict[str, Any]:
    """The verdict under the keys of the file; what is written beside it (model, FMU, report) is null yet.

    cells says what the places of misfit are.
    """
    best = verdict.best
    chances, left = _probabilities(verdict), gap(verdict, unit)
    return {
        "verdict": verdict.verdict,
        "effects": [_effect(verdict, c, chances) for c in verdict.effects] if verdict.verdict == "named" else [],
        "tied": [c.family for c in verdict.tied] if verdict.verdict == "tied" else [],
        "closest": _closest(verdict) if verdict.verdict == "unknown" else None,
        "candidates": [{"name": c.family, "form": c.effect.form, "sentence": c.effect.sentence(), "delta_chi2": c.delta_chi2,
                        "delta_bic": c.delta_bic, "probability": chances.get(id(c), 0.0), "fitted": c.fitted} for c in _distinct(verdict.candidates)],
        "where": [{"run": p.run, "axis": p.axis, "order": p.order, "from": p.start, "to": p.end, "unit": p.unit, "excess": p.excess, "p_value": p.p_value}
                  for p in locate(verdict.base, cells)],
        "gap": left,
        "base": {n: {"value": v, "standard_error": e, "unit": u} for n, (v, e, u) in parameters_of(best).items() if n in best.model.base},
        "noise_source": noise_source,
        "next_experiment": None,
        "limitations": [*_limitations(verdict), *_foretold(verdict, left)],
        "model": None,
        "fmu": None,
        "report": None,
    }  # fmt: skip


def _limitations(verdict: Verdict) -> list[str]:
    """What the verdict rests on besides the data, and what it leaves open."""
    sentences = []
    if verdict.verdict == "named" and len(verdict.effects) == 1:
        name = verdict.effects[0].family
        if same := equivalent(verdict.best, verdict.effects[0], verdict.candidates):
            sentences.append(f"By torque and angle alone {' or '.join(same)} would answer as {name} does: only the sign that "
                             "each must have, and what is known of the base beside these runs, tell them apart.")  # fmt: skip
        if verdict.tied:
            sentences.append(f"Something else is missing besides {name}: one of {', '.join(dict.fromkeys(c.family for c in verdict.tied))}.")
    if verdict.unlisted:
        law, name = verdict.unlisted, " and ".join(dict.fromkeys(e.family for e in verdict.best.model.effects)) or "any that has one"
        sentences.append(f"A law that has no name in the library explains the data better than {name} (delta chi-square {law.delta_chi2:.4g}): "
                         f"{law.effect.sentence()}")  # fmt: skip
    if verdict.refuted:
        sentences.append(f"The held-out run refutes what fits as well or better: {', '.join(verdict.refuted)}.")
    return sentences


def _foretold(verdict: Verdict, left: dict[str, Any]) -> list[str]:
    """What it means where more is missed than the verdict seems to say, most often of a held-out run; left is its gap."""
    missed = left["holdout_after"]
    if verdict.open_form and (not adequate(verdict.best) or (missed or 0.0) > FORETOLD):
        held_out = f", {missed:.2g} of the held-out run" if missed is not None else ""
        return [f"No form of {verdict.effects[0].family} in the library fits as noise lets it (reduced chi-square {left['after']:.2g}{held_out}): its "
                "parameters are those of the nearest form."]  # fmt: skip
    if missed is None or missed < FORETOLD or verdict.open_form:
        return []
    if verdict.verdict == "named":
        return [f"The fitted runs leave some values too uncertain to foretell the held-out run (reduced chi-square {missed:.2g} with all of them frozen); "
                "within their errors they explain it. Fit more runs."]  # fmt: skip
    if verdict.verdict == "unknown" and adequate(verdict.best):
        return [f"The fitted runs are explained, the held-out run is not (reduced chi-square {missed:.2g}): what is missing does not show in the fitted "
                "ones alone. Fit that run too."]  # fmt: skip
    return []


def gap(verdict: Verdict, unit: str) -> dict[str, Any]:
    """Before, after and on the held-out runs, as reduced chi-square and as rms."""
    before, after, held = closeness(verdict.base), closeness(verdict.best), verdict.held_out
    return {
        "before": before.chi2, "after": after.chi2,
        "holdout_before": held[0].chi2 if held else None, "holdout_after": held[1].chi2 if held else None, "noise_floor": 1.0,
        "rms": {"before": before.rms, "after": after.rms, "holdout_before": held[0].rms if held else None,
                "holdout_after": held[1].rms if held else None, "noise_floor": floor(held[1].fit.runs if held else verdict.base.runs), "unit": unit},
    }  # fmt: skip


def _probabilities(verdict: Verdict) -> dict[int, float]:
    """Of each candidate against the others, against none and a law without a name, from the BIC, one form per family, equal odds before."""
    first: dict[str, Candidate] = {}
    for c in verdict.candidates:
        first.setdefault(c.family, c)
    for c in verdict.effects:
        if c.family in first:
            first[c.family] = c
    members = list(first.values())
    unnamed = [0.0, *([verdict.unlisted.delta_bic] if verdict.unlisted else [])]
    exponents = np.array([*unnamed, *(c.delta_bic for c in members)]) / 2
    weights = np.exp(exponents - exponents.max())
    chances = weights[len(unnamed) :] / weights.sum()
    result = {id(c): float(p) for c, p in zip(members, chances, strict=True)}
    for c in verdict.effects[1:]:
        result[id(c)] = float(1 / (1 + np.exp(-min(c.delta_bic, 600) / 2)))
    for c in verdict.effects:  # the table of candidates has them as they do alone, and they may be sure all the same
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
    """The effect with its parameters as the last fit has them."""
    known = parameters_of(verdict.best)
    stand = verdict.best.model.stand
    effect = candidate.effect
    open_ = verdict.open_form and candidate is verdict.effects[0]
    own = {n: known[stand.parameter(effect, n)] for n in effect.sought()}
    return {"name": effect.family, "form": "open" if open_ else effect.form, "sentence": effect.sentence(), "probability": chances.get(id(candidate), 1.0),
            "delta_chi2": candidate.delta_chi2, "delta_bic": candidate.delta_bic,
            "parameters": {n: {"value": v, "standard_error": e, "unit": u} for n, (v, e, u) in own.items()}}  # fmt: skip


def _closest(verdict: Verdict) -> dict[str, Any] | None:
    if not verdict.candidates or verdict.candidates[0].delta_bic < 0:
        return None
    best = verdict.candidates[0]
    return {"name": best.family, "delta_bic": best.delta_bic}
