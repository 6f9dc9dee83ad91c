"""Effects with the same response as a named one, if their bounds and the priors of the base are ignored.

    dchi2 |(1 - W W^+) r|^2 / |(1 - B B^+) r|^2 < dBIC of a tie

r are the derivatives of the data by the other effect's magnitude, B those by the parameters of the base, W those by the
base and the named effect. The ratio is the share of the named effect's gain that the other effect cannot reach. At one
port, with torque and angle, a linear rider has seven coefficients and the base has six parameters. Therefore one linear
effect can be replaced by another with other values of the base. Only knowledge besides the data distinguishes them: the
physical sign of a parameter, or an inertia known from another measurement.

An effect whose derivatives lie in those of the base, where the named effect is absent, is part of the base and cannot
replace another: the gain of an input that has a free coefficient, for instance.
"""

from collections.abc import Sequence

import numpy as np

from fmus.effects import Effect
from fmus.support.errors import InputError
from fmus.support.parallel import parallel_map
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import Candidate, one_each
from motofmi.gap.estimation.fit_result import Fit, places_of

INDEPENDENT = 1e-9  # singular value over the largest one [1] below which derivatives are linearly dependent
ROUNDING = 1e-9  # share of the squared derivatives outside those of the base [1] that is due to rounding


def equivalent(
    found: Fit, named: Candidate, candidates: Sequence[Candidate], criteria: Criteria = Criteria()
) -> list[str]:
    """The families that only bounds and priors distinguish from the named effect of a fit.

    The list is empty where the effect is not in the fit, or has a prior itself.
    """
    effect = named.effect
    if effect not in found.model.effects or effect.prior is not None:  # a prior is knowledge besides the data
        return []
    own = places_of(found, effect, effect.free_parameters())
    slopes = found.jacobian[: found.count]
    whole, without = _basis(slopes), _basis(np.delete(slopes, own, axis=1))
    rivals = [c for c in one_each(candidates) if c.family != named.family and not c.effect.nonlinear_parameters()]
    outside = parallel_map(
        lambda effect: _share_outside(found, effect, (whole, without)),
        [c.effect for c in rivals],
        "effects with the same response",
    )
    return [
        c.family
        for c, (beside, alone) in zip(rivals, outside, strict=True)
        if alone > ROUNDING
        and named.delta_chi2 * beside < criteria.tie_delta_bic * alone
        and not _within_base(found, c.effect, own)
    ]


def _basis(slopes: np.ndarray) -> np.ndarray:
    """An orthonormal basis of columns that may be linearly dependent.

    Without priors, common parameters and deviations of single runs are.
    """
    basis, sizes, _ = np.linalg.svd(slopes / (np.linalg.norm(slopes, axis=0) + 1e-12), full_matrices=False)
    return basis[:, sizes > INDEPENDENT * sizes.max(initial=0.0)]


def _share_outside(found: Fit, effect: type[Effect], bases: Sequence[np.ndarray]) -> list[float]:
    """The share of an effect's squared derivatives by its magnitude, at zero, that lies outside each of these bases.

    It is 1 where the effect cannot be simulated.
    """
    try:
        slopes = _slopes_with(found, effect, slopes_of_base=False)[:, -len(effect.free_parameters())]
    except InputError:
        return [1.0] * len(bases)
    return [_outside(slopes, basis) for basis in bases]


def _within_base(found: Fit, effect: type[Effect], own: Sequence[int]) -> bool:
    """Whether an effect's derivatives lie in those of the base where the effect with the parameters `own` is absent."""
    try:
        slopes = _slopes_with(found, effect, absent=own[0])
    except InputError:
        return False
    base = np.delete(slopes[:, : len(found.model.names)], own, axis=1)
    return _outside(slopes[:, -len(effect.free_parameters())], _basis(base)) <= ROUNDING


def _slopes_with(
    found: Fit, effect: type[Effect], absent: int | None = None, slopes_of_base: bool = True
) -> np.ndarray:
    """The derivatives of the data by the parameters of a fit and of a further effect, whose magnitude is zero.

    The parameter `absent` is set to zero. Raises InputError where the effect cannot be simulated.
    """
    model = found.model.with_added_effects(effect, slopes_of_base=slopes_of_base)
    shared = len(found.model.names)
    zero = np.array([max(row.min, 0.0) for row in model.rows[shared - len(model.base) :]])
    vectors = [np.concatenate([found.of_run(i), zero]) for i in range(len(found.runs))]
    for vector in vectors:
        vector[[] if absent is None else [absent]] = 0.0
    return np.concatenate([model.slopes(run, x) for run, x in zip(found.runs, vectors, strict=True)])


def _outside(slopes: np.ndarray, basis: np.ndarray) -> float:
    """The share of squared derivatives outside an orthonormal basis."""
    left = slopes - basis @ (basis.T @ slopes)
    return float(left @ left / max(slopes @ slopes, 1e-300))
