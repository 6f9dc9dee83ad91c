"""The base fitted from several starts, since a resonance far from its initial value causes local minima.

Starts are distributed by a Sobol sequence over a factor of two to each side of the component's values. The search ends
with the first adequate fit, or once the best minimum has been reached twice after FEW starts.
"""

import itertools
from collections.abc import Sequence

import numpy as np

from fmus.support.deadline import time_is_up
from fmus.support.parallel import parallel_map
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import adequate
from motofmi.gap.estimation.fit_result import Fit, PortableFit
from motofmi.gap.estimation.fitting import fit, fit_or_none
from motofmi.gap.models.any_model import AnyModel, AnyRun

FEW, MOST = 8, 32  # starts
SPREAD = float(np.log(2.0))  # of the logarithms of the parameters
SAME = 0.01  # relative difference of chi-square within which two fits have reached the same minimum


def fit_base(model: AnyModel, runs: Sequence[AnyRun], criteria: Criteria = Criteria()) -> Fit:
    """The best fit of a model without effects. Raises InputError where not even the first start can be simulated."""
    first = model.start()
    best, reached = fit(model, runs, first), 1
    if adequate(best, criteria) or not model.base or time_is_up():
        return best
    from scipy.stats import qmc  # noqa: PLC0415 - imported on use: it takes 0.5 s

    moves = np.zeros((MOST - 1, len(first)))
    moves[:, : len(model.base)] = qmc.scale(
        qmc.Sobol(len(model.base), scramble=False).random(2 * MOST)[2 : MOST + 1], -SPREAD, SPREAD
    )
    begun = parallel_map(
        lambda move: PortableFit.of(fit_or_none(model, runs, first + move)), list(moves[: FEW - 1]), "fitting the base"
    )
    found = itertools.chain(
        (portable.on(model, runs) if portable else None for portable in begun),
        (fit_or_none(model, runs, first + move) for move in moves[FEW - 1 :] if not time_is_up()),
    )
    for count, other in enumerate(found, 2):
        if other is not None and other.chi2 < (1 - SAME) * best.chi2:
            best, reached = other, 1
        elif other is not None and other.chi2 < (1 + SAME) * best.chi2:
            reached += 1
        if adequate(best, criteria) or (count >= FEW and reached > 1):
            break
    return best
