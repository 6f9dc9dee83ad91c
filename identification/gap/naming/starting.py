"""The base fitted from several starts: a resonance that is far from the first guess makes minima that are not the lowest.

Starts are spread by a Sobol sequence over a factor of two to each side of the component's own values. The search ends
with the first fit that is as good as the noise, or once the best has been reached twice after FEW starts.
"""

import itertools
from collections.abc import Sequence

import numpy as np
from scipy.stats import qmc

from fmus.parallel import spread
from identification.gap.models.model import AnyModel, AnyRun
from identification.gap.naming.candidate import adequate
from identification.gap.naming.fitted import Answer, Fit
from identification.gap.naming.fitting import attempt, fit

FEW, MOST = 8, 32
SPREAD = float(np.log(2.0))
SAME = 0.01  # of chi-square: two fits that ended at the same place


def fit_base(model: AnyModel, runs: Sequence[AnyRun]) -> Fit:
    """The best fit of a model without effects. Raises InputError where not even the first start can be simulated."""
    first = model.start()
    best, reached = fit(model, runs, first), 1
    if adequate(best) or not model.base:
        return best
    moves = np.zeros((MOST - 1, len(first)))
    moves[:, : len(model.base)] = qmc.scale(qmc.Sobol(len(model.base), scramble=False).random(2 * MOST)[2 : MOST + 1], -SPREAD, SPREAD)
    begun = spread(lambda move: Answer.of(attempt(model, runs, first + move)), list(moves[: FEW - 1]), "fitting the base")
    found = itertools.chain((answer.on(model, runs) if answer else None for answer in begun), (attempt(model, runs, first + move) for move in moves[FEW - 1 :]))
    for count, other in enumerate(found, 2):
        if other is not None and other.chi2 < (1 - SAME) * best.chi2:
            best, reached = other, 1
        elif other is not None and other.chi2 < (1 + SAME) * best.chi2:
            reached += 1
        if adequate(best) or (count >= FEW and reached > 1):
            break
    return best
