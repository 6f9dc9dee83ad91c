"""A delayed signal as states: the Pade approximation [5/6] of exp(-s tau) in Legendre polynomials over the last tau
seconds.

    tau m' = A m + B u,   u(t - tau) = sum m_i
    A_ij = (2 i + 1) (-1 if i < j else (-1)^(i - j + 1)),   B_i = (2 i + 1) (-1)^i,   i, j = 0 to 5

The phase error is below 1 degree up to omega tau = 5.

Source: Voelker, Kajic, Eliasmith, Legendre Memory Units, NeurIPS 2019, eqs 1, 2.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from fmus.declaration.component import Scope
from fmus.declaration.variables import Variable

ORDER = 6


def delay_states(
    key: str, row: Variable, source: str, delay: str
) -> tuple[dict[str, Variable], dict[str, Callable], Callable]:
    """The delay of the variable `source` by the parameter `delay` [s]: states, their rates, and the delayed value.

    The states are named after `key`; the rates are additions to `der(state)`; the delayed value is a function of the
    scope.
    """
    names = [f"{key}_{i}" for i in range(ORDER)]
    states = {
        n: Variable("state", row.unit, f"{row.description}, delayed: Legendre coefficient {i}", name=n)
        for i, n in enumerate(names)
    }

    def rate_of(i: int) -> Callable[[Scope, Any], Any]:
        def rate(scope: Scope, m: Any) -> Any:
            sums = (-1) ** i * scope[source]
            for j, other in enumerate(names):
                sums = sums + (-1 if i < j else (-1) ** (i - j + 1)) * scope[other]
            return (2 * i + 1) / scope[delay] * sums

        return rate

    return (
        {n: replace(s, nominal=row.nominal) for n, s in states.items()},
        {f"der({n})": rate_of(i) for i, n in enumerate(names)},
        lambda scope: sum((scope[n] for n in names[1:]), scope[names[0]]),
    )
