r"""The standard errors by which the magnitude of an effect is compared with zero.

    s' = s min(1, z / sqrt(L)),   z^2 = m' V^-1 m,   L = chi2 without the effect - chi2 with it

m are the magnitudes of an effect and s their standard errors with errors of the model, V is their covariance without
these. m / s' is the square root of the likelihood ratio L, multiplied by the ratio of both standard errors. The fit
without the effect starts from the values of the fit with it, since L counts a better minimum of the base otherwise.

The output of an overflow or a stop that is practically rigid hardly depends on its magnitude, so that m / s tends to
zero as the effect grows (Hauck, Donner 1977). The likelihood ratio does not: z^2 = L for an effect in whose magnitude
the output is linear.

Source: Chandler, Bate, Biometrika 94 (2007) 167-183 (vertical adjustment for clustered data); Hauck, Donner, J. Am.
Statist. Assoc. 72 (1977) 851-853.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from fmus.effects import Effect
from fmus.support.errors import InputError
from motofmi.gap.estimation.candidate import magnitudes_of
from motofmi.gap.estimation.effect_fit import as_found
from motofmi.gap.estimation.fit_result import Fit, places_of, standard_errors
from motofmi.gap.estimation.fitting import fit


def adjusted_errors(found: Fit, errors: np.ndarray, simpler: Sequence[Fit], least: float) -> np.ndarray:
    """The standard errors (parameters,) by which magnitudes of effects are compared with zero.

    errors (parameters,) include errors of the model; simpler are fits of which some lack one effect of the fit. The
    errors of an effect are adjusted where its magnitudes are less than `least` standard errors even without errors of
    the model, and another of its parameters is more, as the threshold of an overflow: the data determine the effect
    then. They are returned as they are where no fit lacks the effect, and for an effect with states of its own, since
    its free initial states can reduce chi-square without any magnitude.
    """
    adjusted, covariance = errors.copy(), replace(found, sandwich=None).covariance()
    shared = found.x[: len(errors)]
    determined = np.abs(shared) >= least * errors
    rigid = np.abs(shared) < least * standard_errors(covariance)[: len(errors)]
    for effect in found.model.effects:
        places, others = magnitudes_of(found, effect), places_of(found, effect, effect.free_parameters())
        sizes, without = found.x[places], _without(found, effect, simpler)
        if effect.has_states() or without is None or not np.all(np.isfinite(errors[places])):
            continue  # an infinite error has no factor that makes it finite
        if not rigid[places].all() or not determined[others].any():
            continue
        by_wald = float(sizes @ np.linalg.pinv(covariance[np.ix_(places, places)]) @ sizes)
        least_factor = _factor(by_wald, without.chi2 - found.chi2)  # a refit only decreases the ratio
        if np.any(np.abs(sizes) >= least * least_factor * errors[places]):
            adjusted[places] *= _factor(by_wald, _refitted(found, without) - found.chi2)
    return adjusted


def _factor(by_wald: float, ratio: float) -> float:
    """The factor on standard errors, from z^2 and the likelihood ratio."""
    return min(1.0, float(np.sqrt(by_wald / max(ratio, 1e-300))))


def _without(found: Fit, effect: type[Effect], simpler: Sequence[Fit]) -> Fit | None:
    """The fit with all other effects of a fit, the one with the least chi-square; None where there is none."""
    others = set(found.model.effects) - {effect}
    return min((f for f in simpler if set(f.model.effects) == others), key=lambda f: f.chi2, default=None)


def _refitted(found: Fit, without: Fit) -> float:
    """The chi-square of a fit without an effect, or of one that starts from the values of the fit with it if less."""
    with suppress(InputError):  # it cannot be simulated from there
        start = as_found(without.model, found, without.x)
        return min(without.chi2, fit(without.model, found.runs, start).chi2)
    return without.chi2
