"""The transition of dry friction through zero rate, narrowed by continuation.

    F = F_c tanh(v / v_s),   v_s = a, 0.7 a, 0.7^2 a, ...   from 1 % down to 0.01 % of the largest rate

In a wide transition a body creeps where the real one sticks, and an excess of friction near standstill (Stribeck) takes
the place of the missing stick. In a narrow one, simulations from distant values take long, and fits end in local
minima. Therefore effects are searched with the wide one, and what is found is fitted with narrower ones, each from the
values of the one before and with steps that resolve it, until chi-square has not decreased twice; then with widths
between the best one and its neighbours. A model of n independent blocks of residuals is preferred by BIC with an
unknown variance of the noise,

    n ln(chi2) + k ln n

where a narrower transition counts as one of the k parameters.

Source: Allgower, Georg, Introduction to Numerical Continuation Methods (2003), ch. 1; Schwarz, Ann. Statist. 6 (1978).
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fmus.effects import Effect
from fmus.support.deadline import time_is_up
from fmus.support.parallel import parallel_map
from motofmi.gap.estimation.fit_result import Fit, PortableFit
from motofmi.gap.estimation.fitting import fit_or_none
from motofmi.gap.models.segmented import WIDTH

NARROWER = 0.7  # ratio of the widths of two consecutive fits
FURTHER = 2  # fits without a decrease of chi-square after which no narrower transition is tried


def has_transition(effects: Iterable[type[Effect]]) -> bool:
    """Whether one of the effects has a transition whose width the experiment gives."""
    return any(WIDTH in effect.given for effect in effects)


def worth_narrowing(best: Fit, forms: Sequence[Fit], blocks: int) -> list[Fit]:
    """Each form with the transition of the best width, the least criterion first; without
    those whose criterion is not less than that of `best`.

    blocks is the number of independent blocks of residuals. All fits have the same runs.
    """

    def narrowed(wide: Fit) -> tuple[float, PortableFit | None]:
        narrow = in_best_width(wide)
        return _rate(narrow), PortableFit.of(narrow)

    found = []
    for wide, (rate, portable) in zip(forms, parallel_map(narrowed, forms, "narrowing dry friction"), strict=True):
        if portable is not None and rate < _rate(wide):
            narrow = portable.on(_in_transition(wide, rate).model, wide.runs)
            found.append((_criterion(narrow, blocks, True), narrow))
    limit = _criterion(best, blocks, False)
    return [narrow for value, narrow in sorted(found, key=lambda pair: pair[0]) if value < limit]


def in_best_width(wide: Fit) -> Fit:
    """The fit with that width of the transition, up to the wide one, which has the least chi-square."""
    found, last, further = wide, wide, 0
    while further < FURTHER and not time_is_up():
        rate = NARROWER * _rate(last)
        if rate < _experiment(wide).least_sliding_rate:
            break
        last = _fitted(last, rate)
        found, further = (last, 0) if last.chi2 < found.chi2 else (found, further + 1)
    if found is wide or time_is_up():
        return found
    between = [_fitted(found, ratio * _rate(found)) for ratio in (NARROWER**0.5, NARROWER**-0.5)]
    return min(found, *between, key=lambda each: each.chi2)


def _fitted(last: Fit, rate: float) -> Fit:
    """A fit again with the sliding rate [rad/s or m/s]; with an infinite chi-square where it cannot be simulated."""
    start = _in_transition(last, rate)
    return fit_or_none(start.model, start.runs, start.x) or replace(start, chi2=np.inf)


def _in_transition(found: Fit, rate: float) -> Fit:
    """The values of a fit in a model with the sliding rate [rad/s or m/s]."""
    model: Any = found.model
    return replace(found, model=model.with_experiment(_experiment(found).with_sliding_rate(rate)))


def _criterion(found: Fit, blocks: int, narrower: bool) -> float:
    """n ln(chi2) + k ln n [1] on n blocks."""
    return blocks * float(np.log(found.chi2)) + (len(found.model.names) + narrower) * float(np.log(blocks))


def _rate(found: Fit) -> float:
    """The sliding rate [rad/s or m/s] of a fit."""
    return float(_experiment(found).sliding_rate)


def _experiment(found: Fit) -> Any:
    return found.model.experiment
