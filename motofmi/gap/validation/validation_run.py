"""Validation runs: whether a fit predicts them, and whether they reject the effects that were named.

    excess                chi2 / data - 1
                          values fixed as fitted
    excess after refit    (chi2(fitted and validation runs) - chi2(fitted runs)) / data - 1
                          values free within their errors

With fixed values, a parameter with a large standard error causes misfit by that error alone. Therefore the excess does
not reject an effect that explains all runs together and either closes most of the base's excess or has evidence from
the validation runs alone.
"""

from collections.abc import Sequence
from contextlib import suppress
from functools import cache

import numpy as np

from fmus.support.errors import InputError
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import noise_is_known
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.models.any_model import AnyRun
from motofmi.gap.validation.before_after import Misfit, on_validation_runs, reduced_chi2_after_refit


class ValidationRuns:
    """Runs that were not used for estimation. The misfit of each fit is computed once."""

    def __init__(self, runs: Sequence[AnyRun], criteria: Criteria = Criteria()):
        self.runs, self.criteria = list(runs), criteria
        self.count = sum(len(run.data) for run in self.runs)
        self._misfit, self.excess_after_refit = cache(self._misfit_of), cache(self._excess_after_refit)

    def __bool__(self) -> bool:
        return bool(self.runs)

    def excess(self, found: Fit) -> float:
        """The excess of a fit with fixed values; infinite where it cannot be simulated."""
        misfit = self._misfit(found)
        return np.inf if misfit is None else misfit.chi2 - 1

    def predicted_by(self, base: Fit) -> bool:
        """Whether a base predicts the validation runs with its fitted values, or after a refit within
        their standard errors."""
        least = self.criteria.predicted_reduced_chi2 - 1
        return self.excess(base) < least or self.excess_after_refit(base) < least

    def least_excess(self, found: Fit) -> float:
        """The smaller of the two excesses of a fit."""
        fixed = self.excess(found)
        return fixed if fixed < self.criteria.validation_excess else min(fixed, self.excess_after_refit(found))

    def reject(self, base: Fit, found: Fit, unspecified_form: bool = False) -> bool:
        """Whether the excess is above the noise, and above the share of the base's excess that a named effect may
        leave."""
        of = self.criteria
        before, after, noise = (
            self.excess(base),
            self.excess(found),
            float(np.sqrt(2 / self.count)),
        )  # few data scatter by more
        share = (
            1 - required_share(found, of.validation_closed_share, of)
            if unspecified_form
            else of.validation_excess_share
        )
        if after <= max(
            share * before if np.isfinite(before) else 0.0, of.validation_excess, of.scatter_deviations * noise
        ):
            return False
        allowed = share * self.excess_after_refit(base) if unspecified_form else 0.0
        if after >= before or self.excess_after_refit(found) > max(allowed, of.validation_refit_deviations * noise):
            return True
        return after >= (1 - of.validation_closed_share) * before and not self.support(base, found)

    def support(self, base: Fit, found: Fit) -> bool:
        """Whether these runs alone are evidence for an effect."""
        return (
            self.excess_after_refit(base) - self.excess_after_refit(found)
        ) * self.count > self.criteria.validation_evidence_chi2

    def _excess_after_refit(self, found: Fit) -> float:
        """The excess with the values free within their errors; infinite where the fit cannot be simulated."""
        with suppress(InputError):
            if misfit := self._misfit(found):
                return reduced_chi2_after_refit(found, misfit) - 1
        return np.inf

    def _misfit_of(self, found: Fit) -> Misfit | None:
        with suppress(InputError):
            return on_validation_runs(found, self.runs, self.criteria)
        return None


def required_share(found: Fit, usual: float, criteria: Criteria) -> float:
    """The share of the excess that a family with an unspecified form must close."""
    return usual if noise_is_known(found) else criteria.unspecified_form_closed_share_flexible_noise
