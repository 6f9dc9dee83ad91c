"""Whether the magnitudes of a fitted model's effects are distinguishable from zero.

An effect with states of its own, such as a further body, reduces the misfit even without a magnitude: the initial states
of every segment are free. Such a model is a disturbance of the base, and no effect.
"""

import numpy as np

from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.fit_result import Fit


def vanishing_magnitude(found: Fit, errors: np.ndarray, criteria: Criteria) -> tuple[str, float, float] | None:
    """Name, value and standard error of the first magnitude of an effect that has none distinguishable from zero.

    errors (parameters,) are the standard errors of the fitted values. None where every effect has a magnitude.
    """
    names, x = found.model.names, found.x
    for effect in found.model.effects:
        magnitudes = [
            names.index(found.model.experiment.parameter(effect, n))
            for n in effect.free_parameters()
            if n not in effect.nonlinear_parameters()
        ]
        if magnitudes and all(abs(x[i]) < criteria.value_errors * errors[i] for i in magnitudes):
            i = magnitudes[0]
            return names[i], float(x[i]), float(errors[i])
    return None
