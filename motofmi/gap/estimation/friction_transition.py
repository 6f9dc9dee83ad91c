"""The transition of dry friction through zero rate, narrowed by continuation.

    F = F_c tanh(v / v_s),   v_s = a, a/2, a/4, ...   from 1 % down to 0.01 % of the largest rate

In a wide transition a body creeps where the real one sticks, and an excess of friction near standstill (Stribeck) takes
the place of the missing stick. In a narrow one, simulations from distant values take long, and fits end in local
minima. Therefore effects are searched with the wide one, and what is found is fitted with narrower ones, each from the
values of the one before, as long as chi-square decreases. A model of n independent blocks of residuals is preferred by
BIC with an unknown variance of the noise,

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
from fmus.support.errors import InputError
from fmus.support.parallel import parallel_map
from motofmi.gap.estimation.fit_result import Fit, PortableFit
from motofmi.gap.estimation.fitting import fit

NARROWER = 0.5  # ratio of the widths of two consecutive fits
WIDTH = "sliding_rate"  # the parameter that an experiment gives to effects with a transition


def has_transition(effects: Iterable[type[Effect]]) -> bool:
    """Whether one of the effects has a transition whose width the experiment gives."""
    return any(WIDTH in effect.given for effect in effects)


def worth_narrowing(best: Fit, forms: Sequence[Fit], blocks: int) -> list[Fit]:
    """Each form with the narrowest transition up to which chi-square decreases, the least criterion first; without
    those whose criterion is not less than that of `best`.

    blocks is the number of independent blocks of residuals. All fits have the same runs.
    """

    def narrowed(wide: Fit) -> tuple[float, PortableFit | None]:
        narrow = _narrowest(wide)
        return _rate(narrow), PortableFit.of(narrow)

    found = []
    for wide, (rate, portable) in zip(forms, parallel_map(narrowed, forms, "narrowing dry friction"), strict=True):
        if portable is not None and rate < _rate(wide):
            narrow = portable.on(_in_transition(wide, rate).model, wide.runs)
            found.append((_criterion(narrow, blocks, True), narrow))
    limit = _criterion(best, blocks, False)
    return [narrow for value, narrow in sorted(found, key=lambda pair: pair[0]) if value < limit]


def _narrowest(wide: Fit) -> Fit:
    """The fit with the narrowest transition up to which chi-square decreases."""
    found = wide
    while not time_is_up() and (rate := NARROWER * _rate(found)) >= _experiment(found).least_sliding_rate:
        narrower = _in_transition(found, rate)
        try:
            narrower = fit(narrower.model, narrower.runs, narrower.x)
        except InputError:  # it cannot be simulated
            break
        if narrower.chi2 >= found.chi2:
            break
        found = narrower
    return found


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
