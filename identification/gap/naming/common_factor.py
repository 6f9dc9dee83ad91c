"""Is a column's unit wrong? Then all that has force or mass in its unit comes out by the same factor from where it started.

    f = median_i |p_i / p_i0|,   at least two thirds of the p_i within a factor of 2 of f p_i0,   f within 1.5 of a unit's factor

Degrees that are called radians make f 57 or its inverse, kN that are called N or mm that are called m a thousand. A
component whose values say nothing of the one that was recorded comes out far from them as well, but hardly by such a factor.
"""

from collections.abc import Mapping

import numpy as np

from fmus.component import Component

UNITS = (180 / np.pi, 1e3, 1e6)
NEAR = 1.5  # times, by which a component's values may be off
ALIKE, SHARE = 2.0, 2 / 3


def forceful(component: Component) -> list[str]:
    """The parameters with force or mass in their unit, without those that are 0: without a known force only their ratios show."""
    rows = component.rows("parameter")
    return [n for n, row in rows.items() if component.values[n] and any(word in row.unit for word in ("N", "kg"))]


def common_factor(component: Component, found: Mapping[str, float]) -> float:
    """The factor by which fitted values, by name, are from the component's own in common; 1 where that is no unit's."""
    ratios = np.array([abs(found[n] / component.values[n]) for n in forceful(component) if n in found])
    ratios = ratios[ratios > 0]
    if len(ratios) < 2:
        return 1.0
    middle = float(np.exp(np.median(np.log(ratios))))
    alike = np.mean(np.abs(np.log(ratios / middle)) < np.log(ALIKE))
    from_a_unit = min(abs(abs(np.log(middle)) - np.log(unit)) for unit in UNITS)
    return middle if from_a_unit < np.log(NEAR) and alike >= SHARE else 1.0
