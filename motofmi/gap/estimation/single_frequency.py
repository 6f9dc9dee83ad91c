"""Inertia and stiffness are not identifiable separately where a motion is imposed at a single frequency.

    m x'' = -m w^2 x

    cos(dr/d ln m, dr/d ln k) = -1

The inertia then keeps its initial value, and the stiffness is the effective one at that frequency: only the small
harmonics of the motion distinguish the two, and any nonlinearity causes harmonics as well. Under a driving force the
resonance identifies both.
"""

import numpy as np

from fmus.composition.imposed_motion import ImposedMotion
from fmus.declaration.units import is_inertia
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.fit_result import Fit


def inseparable_inertias(found: Fit, criteria: Criteria) -> list[str]:
    """The inertias of the base that are not identifiable beside another parameter in runs of an imposed motion."""
    if not isinstance(found.model.component, ImposedMotion):
        return []
    base, table = found.model.base, found.model.component.table
    slopes = found.jacobian[:, : len(base)]
    slopes = slopes / (np.linalg.norm(slopes, axis=0) + 1e-300)
    cosines = np.abs(slopes.T @ slopes) - np.eye(len(base))
    return [
        n for i, n in enumerate(base) if is_inertia(table[n].unit) and cosines[i].max() > criteria.inseparable_cosine
    ]
