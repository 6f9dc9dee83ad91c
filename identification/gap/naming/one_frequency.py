"""Where a motion is imposed at one frequency, inertia and stiffness answer alike: a fit of both would say nothing of either.

    m x'' = -m w^2 x

    cos(dr/d ln m, dr/d ln k) = -1

The inertia then keeps the value that it had, and the stiffness is that at the frequency: only the small harmonics of the
motion tell the two apart, and any nonlinearity makes those up. Driven by a force, a resonance tells them by where it is.
"""

import numpy as np

from fmus.imposed import Imposed
from identification.gap.naming.fitted import Fit

ALIKE = 0.99  # cosine of two parameters' slopes
INERTIA = ("kg", "kg.m2")


def not_told_apart(found: Fit) -> list[str]:
    """The inertias of the base that runs of an imposed motion do not tell from another of its parameters."""
    if not isinstance(found.model.component, Imposed):
        return []
    base, table = found.model.base, found.model.component.table
    slopes = found.jacobian[:, : len(base)]
    slopes = slopes / (np.linalg.norm(slopes, axis=0) + 1e-300)
    cosines = np.abs(slopes.T @ slopes) - np.eye(len(base))
    return [n for i, n in enumerate(base) if table[n].unit in INERTIA and cosines[i].max() > ALIKE]
