"""The places under a false-discovery rate, compared with the adjusted p-values of SciPy."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import false_discovery_control

from motofmi.gap.localisation.locating import Place, discovered


@given(st.lists(st.floats(0.0, 1.0), max_size=30), st.floats(0.001, 1.0))
def test_the_places_are_those_whose_adjusted_p_value_is_within_the_rate(p_values, rate):
    places = [Place("run", "time", float(i), i + 1.0, "s", 0.0, p) for i, p in enumerate(p_values)]
    adjusted = false_discovery_control(p_values) if p_values else np.zeros(0)
    clear = np.abs(adjusted - rate) > 1e-12 * rate  # at the rate itself, rounding decides
    found = {place.start for place in discovered(places, rate)}
    assert all((i in found) == (p <= rate) for i, p in enumerate(adjusted) if clear[i])


def test_places_are_sorted_by_their_significance():
    places = [Place("run", "time", 0.0, 1.0, "s", 0.5, p) for p in (0.004, 0.001, 0.5)]
    assert [p.p_value for p in discovered(places, 0.01)] == [0.001, 0.004]
