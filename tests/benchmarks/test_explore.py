"""The benchmark of the explore page in small."""

import pytest

from benchmarks.explore import run
from fmus.support.progress import track
from tests.browser import needs_browser


@pytest.mark.study
@needs_browser
def test_numbers_names_and_coupling_hold_for_a_few_settings():
    found = run(track, settings=3, moves=100, at_once=3, vehicles=("sharp_1971",))
    assert found["eigenvalue_error"] < 1e-9 and found["settings_with_equal_names"] == 1.0
    assert (found["slider_moves"], found["swapped_names"]) == (100, 0)
    for live in (found["live"], found["live_full_rider"]):
        assert max(live["mode_error"].values()) < 1e-4
    # Real time is met on any machine; the target of 100 is stated with the machine in benchmarks/results.json
    assert found["live"]["rate"] > 1 and found["live_full_rider"]["rate"] > 1
