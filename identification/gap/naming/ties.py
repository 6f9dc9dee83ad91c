"""Effects that answer as a named one does, if only their bounds and what is known of the base would let them.

    |(1 - B B^+) r| << |r|,   B = slopes of the fit by everything that it has, on the data alone

r are the slopes by the other effect's size. At one port, with torque and angle, a linear rider has seven coefficients and
the base six parameters: whatever one linear effect adds, another makes up for with other values of the base. What parts
them is not in the data: the physical sign of a parameter, or an inertia that is known from elsewhere.
"""

from collections.abc import Sequence

import numpy as np

from fmus.effects import Effect
from fmus.errors import InputError
from identification.gap.naming.competing import Candidate, one_each
from identification.gap.naming.fitting import Fit

SAME = 1e-2  # of what of an effect's slopes lies outside of the base's
ROUNDING = 1e-9  # of the squared length: what is less is in the base itself


def equivalent(found: Fit, named: type[Effect], candidates: Sequence[Candidate]) -> list[str]:
    """The families among the candidates that only bounds and priors part from the named effect of a fit."""
    own = [found.model.names.index(found.model.stand.parameter(named, n)) for n in named.parameters() if n not in named.given]
    slopes = found.jacobian[: found.count]
    whole, without = _basis(slopes), _basis(np.delete(slopes, own, axis=1))
    rivals = [c for c in one_each(candidates) if c.family != named.family and not c.effect.shapes()]
    outside = {c.family: (_left(found, c.effect, whole), _left(found, c.effect, without)) for c in rivals}
    return [family for family, (beside, alone) in outside.items() if alone > ROUNDING and beside < SAME * alone]


def _basis(slopes: np.ndarray) -> np.ndarray:
    return np.linalg.qr(slopes / (np.linalg.norm(slopes, axis=0) + 1e-12))[0]


def _left(found: Fit, effect: type[Effect], basis: np.ndarray) -> float:
    """The share of an effect's slopes by its size, at zero, that lies outside of a fit's own."""
    try:
        model = found.model.joined_by(effect, slopes_of_base=False)
        shared = len(found.model.names)
        more = np.array([max(row.min, 0.0) for row in model.rows[shared - len(model.base) :]])
        slopes = np.concatenate([model.reduced(run, np.concatenate([found.of_run(i), more]))[1][:, shared] for i, run in enumerate(found.runs)])
    except InputError:
        return 1.0
    left = slopes - basis @ (basis.T @ slopes)
    return float(left @ left / max(slopes @ slopes, 1e-300))
