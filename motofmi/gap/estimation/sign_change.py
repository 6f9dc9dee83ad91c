"""The sign of a parameter of the base that the fit moved to zero, as a stiffness that gravity makes negative.

A fit finds the logarithm of a parameter, which therefore keeps its sign. Where the declared bounds allow both signs and
the value is not distinguishable from zero, the fit is continued with the other sign.
"""

from dataclasses import replace

import numpy as np

from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.fit_result import Fit, initial_guesses, with_initial_guesses
from motofmi.gap.estimation.fitting import fit_or_none, with_sensitive_base
from motofmi.gap.estimation.initial_fit import stable_segments
from motofmi.gap.experiments.input_output import InputOutputExperiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel


def with_fitted_signs(found: Fit, criteria: Criteria) -> Fit:
    """The fit with the sign of every base parameter that fits better.

    The fit's runs must have noise of the size of its residuals. Parameters that are distinguishable from zero keep
    their sign, and so do all without a clear gain (delta chi-square of `Criteria.first_effect_delta_bic`).
    """
    for name in undetermined_signs(found, criteria):
        experiment: InputOutputExperiment = found.model.experiment
        turned = experiment.component.with_values(**{name: -experiment.component.values[name]})
        model = FreeInitialStateModel(replace(experiment, component=turned))
        start = with_sensitive_base(found)
        runs = [
            stable_segments(model, start, run) for run in with_initial_guesses(found.runs, initial_guesses(found.runs))
        ]
        other = fit_or_none(model, runs, start)
        if other is not None and other.chi2 < found.chi2 - criteria.first_effect_delta_bic:
            found = other
    return found


def undetermined_signs(found: Fit, criteria: Criteria) -> list[str]:
    """The base parameters whose bounds allow both signs and whose values are not distinguishable from zero."""
    table, base = found.model.component.table, found.model.base
    relative = np.sqrt(np.maximum(np.diag(found.covariance())[: len(base)], 0.0))  # of a logarithm
    insensitive = np.linalg.norm(found.jacobian[:, : len(base)], axis=0) < 1e-9
    return [
        n
        for n, error, none in zip(base, relative, insensitive, strict=True)
        if table[n].min < 0 < table[n].max and (none or error * criteria.value_errors > 1)
    ]
