"""Detection of a wrong unit: all fitted parameters with force or mass in their unit then share one
factor to their start.

    f = median_i |p_i / p_i0|,   at least `unit_share` of the p_i within `unit_scatter` of f p_i0,
    f within `unit_factor` of a unit's

Degrees labelled as radians cause a factor of 57 or 1/57, kN labelled as N or mm labelled as m a factor of 1000. The
values of a component that is unrelated to the recorded one differ from its parameters as well, but rarely by such a
common factor.
"""

from collections.abc import Mapping

import numpy as np

from fmus.declaration.component import Component
from fmus.declaration.units import BASE, unit
from motofmi.gap.criteria import Criteria

UNITS = (180 / np.pi, 1e3, 1e6)  # degrees per radian, k or m, M


def parameters_with_force_or_mass(component: Component) -> list[str]:
    """The parameters with force or mass in their unit that are not 0: without a known force only their
    ratios are identifiable."""
    rows = component.rows("parameter")
    mass = BASE.index("kg")
    return [n for n, row in rows.items() if component.values[n] and unit(row.unit).exponents[mass]]


def common_factor(component: Component, found: Mapping[str, float], criteria: Criteria) -> float:
    """The common factor of fitted values, by name, over the component's; 1 where it is not that of a unit."""
    names = [n for n in parameters_with_force_or_mass(component) if n in found]
    ratios = np.array([abs(found[n] / component.values[n]) for n in names])
    ratios = ratios[ratios > 0]
    if len(ratios) < 2:
        return 1.0
    middle = float(np.exp(np.median(np.log(ratios))))
    alike = np.mean(np.abs(np.log(ratios / middle)) < np.log(criteria.unit_scatter))
    from_a_unit = min(abs(abs(np.log(middle)) - np.log(unit)) for unit in UNITS)
    return middle if from_a_unit < np.log(criteria.unit_factor) and alike >= criteria.unit_share else 1.0
