"""Effects that answer as a named one does, if only their bounds and what is known of the base would let them.

    dchi2 |(1 - W W^+) r|^2 / |(1 - B B^+) r|^2 < dBIC of a tie

r are the slopes by the other effect's size, B those of the base on the data alone, W these and the named effect's: the ratio is
the share of what the named effect gains that the other could not. At one port, with torque and angle, a linear rider has seven coefficients and
the base six parameters: whatever one linear effect adds, another makes up for with other values of the base. What parts
them is not in the data: the physical sign of a parameter, or an inertia that is known from elsewhere.
"""

from collections.abc import Sequence

import numpy as np

from fmus.effects import Effect
from fmus.errors import InputError
from fmus.parallel import spread
from identification.gap.naming.candidate import TIE, Candidate, one_each
from identification.gap.naming.fitted import Fit

INDEPENDENT = 1e-9  # of the largest singular value
ROUNDING = 1e-9  # of the squared length: what is less is in the base itself


def equivalent(found: Fit, named: Candidate, candidates: Sequence[Candidate]) -> list[str]:
    """The families among the candidates that only bounds and priors part from the named effect of a fit; none where it is not in it."""
    effect = named.effect
    if effect not in found.model.effects:
        return []
    own = [found.model.names.index(found.model.stand.parameter(effect, n)) for n in effect.sought()]
    slopes = found.jacobian[: found.count]
    whole, without = _basis(slopes), _basis(np.delete(slopes, own, axis=1))
    rivals = [c for c in one_each(candidates) if c.family != named.family and not c.effect.shapes()]
    outside = spread(lambda rival: _left(found, rival.effect, (whole, without)), rivals, "effects that would answer alike")
    return [c.family for c, (beside, alone) in zip(rivals, outside, strict=True) if alone > ROUNDING and named.delta_chi2 * beside < TIE * alone]


def _basis(slopes: np.ndarray) -> np.ndarray:
    """Orthonormal columns: without priors, what runs have in common and their deviations are not independent."""
    left, sizes, _ = np.linalg.svd(slopes / (np.linalg.norm(slopes, axis=0) + 1e-12), full_matrices=False)
    return left[:, sizes > INDEPENDENT * sizes[0]]


def _left(found: Fit, effect: type[Effect], bases: Sequence[np.ndarray]) -> list[float]:
    """The share of an effect's slopes by its size, at zero, that lies outside of each of these bases."""
    try:
        model = found.model.joined_by(effect, slopes_of_base=False)
        shared = len(found.model.names)
        more = np.array([max(row.min, 0.0) for row in model.rows[shared - len(model.base) :]])
        slopes = np.concatenate([model.reduced(run, np.concatenate([found.of_run(i), more]))[1][:, shared] for i, run in enumerate(found.runs)])
    except InputError:
        return [1.0] * len(bases)
    outside = [slopes - basis @ (basis.T @ slopes) for basis in bases]
    return [float(left @ left / max(slopes @ slopes, 1e-300)) for left in outside]
