r"""The standard errors by which the magnitude of an effect is compared with zero.

    s' = s min(1, z / sqrt(L)),   z^2 = m' V^-1 m,   L = chi2 without the effect - chi2 with it

m are the magnitudes of an effect and s their standard errors with errors of the model, V is their covariance without
these. m / s' is the square root of the likelihood ratio L, multiplied by the ratio of both standard errors.

The output of an overflow or a stop that is practically rigid hardly depends on its magnitude, so that m / s tends to
zero as the effect grows (Hauck, Donner 1977). The likelihood ratio does not: z^2 = L for an effect in whose magnitude
the output is linear.

Source: Chandler, Bate, Biometrika 94 (2007) 167-183 (vertical adjustment for clustered data); Hauck, Donner, J. Am.
Statist. Assoc. 72 (1977) 851-853.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fmus.effects import Effect
from motofmi.gap.estimation.candidate import has_states, magnitudes_of
from motofmi.gap.estimation.fit_result import Fit


def adjusted_errors(found: Fit, errors: np.ndarray, simpler: Sequence[Fit]) -> np.ndarray:
    """The standard errors (parameters,) by which magnitudes of effects are compared with zero.

    errors (parameters,) include errors of the model; simpler are fits of which some lack one effect of the fit. The
    errors of an effect that none of them lacks are returned as they are, and those of an effect with states of its
    own, since its free initial states can reduce chi-square without any magnitude.
    """
    adjusted, covariance = errors.copy(), replace(found, sandwich=None).covariance()
    for effect in found.model.effects:
        places, without = magnitudes_of(found, effect), _without(found, effect, simpler)
        if not places or without is None or has_states(effect):
            continue
        sizes = found.x[places]
        by_wald = float(sizes @ np.linalg.pinv(covariance[np.ix_(places, places)]) @ sizes)
        ratio = max(without.chi2 - found.chi2, 1e-300)
        adjusted[places] *= min(1.0, np.sqrt(by_wald / ratio))
    return adjusted


def _without(found: Fit, effect: type[Effect], simpler: Sequence[Fit]) -> Fit | None:
    """The fit with all other effects of a fit, the one with the least chi-square; None where there is none."""
    others = set(found.model.effects) - {effect}
    return min((f for f in simpler if set(f.model.effects) == others), key=lambda f: f.chi2, default=None)
