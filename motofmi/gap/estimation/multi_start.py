"""The base fitted from several starts, since a resonance far from its initial value causes local minima.

Starts are distributed over a factor of two to each side of the component's values, by Richtmyer's sequence: the
fractional parts of the multiples of square roots of primes. The search ends with the first adequate fit, or once the
best minimum has been reached twice after FEW starts.

Source: Niederreiter, Random Number Generation and Quasi-Monte Carlo Methods (1992), ch. 3.
"""

import itertools
from collections.abc import Sequence

import numpy as np
from sympy import prime

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
    moves = np.zeros((MOST - 1, len(first)))
    moves[:, : len(model.base)] = SPREAD * (2 * _points(MOST - 1, len(model.base)) - 1)
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


def _points(count: int, dimensions: int) -> np.ndarray:
    """Points (count, dimensions) in the unit cube."""
    roots = np.sqrt([prime(i) for i in range(1, dimensions + 1)])
    return np.outer(np.arange(1, count + 1), roots) % 1.0
