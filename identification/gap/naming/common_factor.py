"""Is a column's unit wrong? Then all that has force or mass in its unit comes out by the same factor from where it started.

    f = median_i |p_i / p_i0|,   at least two thirds of the p_i within a factor of 3 of f p_i0

Degrees that are called radians make f 57 or its inverse, kN that are called N or mm that are called m a thousand. A
component whose values say nothing of the one that was recorded comes out far from them as well, but hardly by one factor.
"""

from collections.abc import Mapping

import numpy as np

from fmus.component import Component

FAR = 30.0  # a component whose values are given is never off so far in all of them
ALIKE, SHARE = 3.0, 2 / 3


def common_factor(component: Component, found: Mapping[str, float]) -> float:
    """The factor by which fitted values, by name, are from the component's own in common; 1 where that is less than FAR."""
    mechanical = [n for n in found if component.values[n] and any(word in component.table[n].unit for word in ("N", "kg"))]
    ratios = np.array([abs(found[n] / component.values[n]) for n in mechanical])
    ratios = ratios[ratios > 0]
    if len(ratios) < 2:
        return 1.0
    middle = float(np.exp(np.median(np.log(ratios))))
    alike = np.mean(np.abs(np.log(ratios / middle)) < np.log(ALIKE))
    return middle if max(middle, 1 / middle) > FAR and alike >= SHARE else 1.0
