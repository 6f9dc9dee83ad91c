"""Implicit formulas with one inner point, by which a simulation goes from one node to the next.

    x_m   = a x_k + b x_k+1 + h (p f_k + q f_k+1)          at t_k + c h
    x_k+1 = x_k + h / n (u f_k + v f_m + w f_k+1)

Both are collocation formulas in which the inner stage is eliminated, and A-stable. That of Hermite and Simpson (Lobatto
IIIA) has order 4, but |R(z)| -> 1 for large |z|: a fast motion that has ended in the component goes on in the
simulation. That of Radau IIA has order 3 and R(z) -> 0: an overdamped mass follows its force at once.

Source: Hairer, Wanner, Solving Ordinary Differential Equations II, 2nd ed. (1996), ch. IV.5; Betts, Practical Methods
for Optimal Control, 2nd ed. (2010), ch. 4.6.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motofmi.gap.models.time_varying_matrices import Entries

# Decay of a rate during a simulation step, above which the formula of Radau is used. There |R| of the other one is 0.3,
# and it approaches 1.
STIFF = 10.0


@dataclass(frozen=True)
class ImplicitFormula:
    """The coefficients: c [1], (a, b, p, q) of the inner point, and (u, v, w) and n of the step."""

    place: float
    inner: tuple[float, float, float, float]
    step: tuple[int, int, int]
    divisor: int


HERMITE_SIMPSON = ImplicitFormula(1 / 2, (1 / 2, 1 / 2, 1 / 8, -1 / 8), (1, 4, 1), 6)
RADAU = ImplicitFormula(1 / 3, (4 / 9, 5 / 9, 0.0, -2 / 9), (0, 3, 1), 4)


def formula_for(slopes: Entries, rates: Sequence[int], step: float) -> ImplicitFormula:
    """The formula for a component with these slopes of its states' derivatives at rest, and a simulation step [s].

    rates are the indices of the states that are rates of other states. A fast decay of another state, as of a delay,
    does not count: it follows its input.
    """
    decay = max((-float(np.max(slopes.get((i, i), 0.0))) for i in rates), default=0.0)
    return RADAU if decay * step > STIFF else HERMITE_SIMPSON
