"""Candidates: effects on top of a fit, with their gain, and their order.

dchi2 = chi2(fit) - chi2(fit + effect)      dBIC = dchi2 - k ln n - 2 u     (u unknowns of single runs: initial states)
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from fmus.declaration.units import is_inertia
from fmus.effects import Effect
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.fit_result import Fit, parameters_of, places_of, standard_errors, undetermined
from motofmi.gap.estimation.screening import Signature


@dataclass(frozen=True)
class Candidate:
    """An effect on top of a fit: fitted, or with the gain estimated by screening, and then `fit` is
    the fit without it."""

    effect: type[Effect]
    fit: Fit
    delta_chi2: float
    delta_bic: float

    @classmethod
    def promised(cls, found: Fit, signature: Signature) -> "Candidate":
        """The screened gain of an effect that was not fitted."""
        return cls(
            signature.effect,
            found,
            max(signature.gain, 0.0),
            signature.gain - len(signature.start) * np.log(found.count),
        )

    @classmethod
    def gained(cls, found: Fit, effect: type[Effect], fitted: Fit) -> "Candidate":
        """The gain of a fitted effect."""
        gain = found.chi2 - fitted.chi2
        return cls(effect, fitted, gain, gain - (fitted.penalty - found.penalty))

    def __repr__(self) -> str:
        how = "fitted" if self.fitted else "screened"
        return (
            f"Candidate({self.family} ({self.effect.form}), {how}, delta chi-square {self.delta_chi2:.4g}, "
            f"delta BIC {self.delta_bic:.4g})"
        )

    @property
    def family(self) -> str:
        """The family of the effect."""
        return self.effect.family

    @property
    def fitted(self) -> bool:
        """Whether the effect was fitted, not only screened."""
        return self.effect in self.fit.model.effects


def adequate(found: Fit, criteria: Criteria) -> bool:
    """Whether what a fit leaves is consistent with the noise; never with fewer data than unknowns."""
    return found.freedom > 0 and found.reduced < reduced_by_noise(found, criteria)


def reduced_by_noise(found: Fit, criteria: Criteria) -> float:
    """The largest reduced chi-square that is consistent with the noise."""
    return max(criteria.adequate_reduced_chi2, 1 + criteria.scatter_deviations * float(np.sqrt(2 / found.freedom)))


def undetermined_magnitude(found: Fit, errors: np.ndarray, criteria: Criteria) -> tuple[str, float, float] | None:
    """The first magnitude of an effect that is not distinguishable from zero, as name, value and standard error; None
    where all are.

    errors (parameters,) are the standard errors of x. Of several magnitudes at one element only one needs to be, but an
    effect must act at each of its elements. An effect that changes a stiffness or damping of the base is not
    distinguishable from zero where this parameter is not, as a spring without stiffness whose force saturates. A
    further body takes the place of the base where no inertia of the base is distinguishable from zero beside it.
    """
    parameters, names = parameters_of(found, errors), found.model.names
    for effect in found.model.effects:
        at_each = [places_of(found, effect, magnitudes) for magnitudes in effect.magnitudes_by_element()]
        for places in (*at_each, _changed_by(found, effect), _inertias_beside(found, effect)):
            values = {names[i]: parameters[names[i]] for i in places}
            if places and len(undetermined(values, criteria.value_errors)) == len(places):
                return names[places[0]], *values[names[places[0]]][:2]
    return None


def magnitudes_at_bounds(found: Fit) -> dict[str, float]:
    """The magnitudes of effects that were fitted to one of their bounds, by name: the effect does not fit well.

    A share of 1 is the whole effect, as a hard limit.
    """
    names, table = found.model.names, found.model.component.table
    values = {names[i]: float(found.x[i]) for effect in found.model.effects for i in magnitudes_of(found, effect)}
    return {
        n: value
        for n, value in values.items()
        if (value >= table[n].max or value <= table[n].min < 0) and (table[n].min, table[n].max) != (0, 1)
    }


def has_determined_magnitudes(found: Fit, criteria: Criteria) -> bool:
    """Whether the data determine the magnitude of every effect.

    Beside a right effect another may vanish, and an effect with states of its own reduces the misfit by their initial
    values alone.
    """
    return undetermined_magnitude(found, standard_errors(found.covariance()), criteria) is None


def magnitudes_of(found: Fit, effect: type[Effect]) -> list[int]:
    """The indices in x of the parameters in which the term that an effect adds is linear."""
    return places_of(found, effect, effect.magnitudes())


def _changed_by(found: Fit, effect: type[Effect]) -> list[int]:
    """The indices in x of the fitted stiffness and damping of its element by which the term of an effect is
    multiplied."""
    element = found.model.experiment.component.elements.get(effect.element)  # where a motion is imposed, of what moves
    names = {word: getattr(element, word, "") for word in ("stiffness", "damping") if word not in effect.declared}
    fitted = {word: found.model.names.index(name) for word, name in names.items() if name in found.model.base}
    return [place for word, place in fitted.items() if word in effect.reads()]


def _inertias_beside(found: Fit, effect: type[Effect]) -> list[int]:
    """The indices in x of the inertias of the base beside an effect that adds one."""
    table, model = found.model.component.table, found.model
    adds = any(is_inertia(effect.declared[n].unit) for n in effect.magnitudes())
    return [model.names.index(n) for n in model.base if is_inertia(table[n].unit)] if adds else []


def by_chance(freedom: float, criteria: Criteria) -> float:
    """By how much chi-square may differ from its mean by chance."""
    return float(criteria.chance_deviations * np.sqrt(2 * freedom))


def noise_is_known(found: Fit) -> bool:
    """Whether the noise is known from other sources than a flexible model, which leaves less than any single law."""
    return all(getattr(run, "noise_source", "") != "flexible_model" for run in found.runs)


def ranked(candidates: Iterable[Candidate]) -> list[Candidate]:
    """The candidates with fitted ones first, then by delta BIC."""
    return sorted(candidates, key=lambda c: (not c.fitted, -c.delta_bic))


def best_of(candidates: Sequence[Candidate], criteria: Criteria) -> Candidate | None:
    """The best fitted candidate; among tied forms of its family that are not flexible, the one with
    the fewest parameters."""
    fitted = [c for c in candidates if c.fitted]
    if not fitted:
        return None
    best = fitted[0]
    plain = [
        c
        for c in fitted
        if c.family == best.family and not c.effect.flexible and best.delta_bic - c.delta_bic < criteria.tie_delta_bic
    ]
    return min(plain, key=lambda c: len(c.effect.free_parameters()), default=best)


def one_each(candidates: Sequence[Candidate]) -> list[Candidate]:
    """The best of every family, in order."""
    seen: dict[str, Candidate] = {}
    for c in candidates:
        seen.setdefault(c.family, c)
    return list(seen.values())
