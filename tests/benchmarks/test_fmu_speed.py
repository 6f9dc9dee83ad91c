"""The small version of the study of speed in benchmarks: fewer steps, and room for a machine that does other things."""

import pytest

from benchmarks.fmu_speed import measured
from fmus.export.compilers import host_compiler
from rider_fmu import riders
from vehicle_fmu import motorcycles


@pytest.mark.study
@pytest.mark.skipif(host_compiler() is None, reason="no C compiler on this machine")
@pytest.mark.parametrize("load", [lambda: riders.load("mean_2011"), lambda: motorcycles.load("sharp_1971")])
def test_a_step_costs_little_more_than_its_arithmetic_and_far_less_than_in_python(load, tmp_path):
    found = measured(load(), tmp_path, steps=30_000, rounds=5)
    # The study holds 1.5, 100 and 4; the best of five short rounds next to other work may miss them by a third.
    assert found["compiled_over_bare"] < 2
    assert found["pythonfmu_over_compiled_in_c"] > 66
    assert found["pythonfmu_over_compiled_through_ctypes"] > 3
    assert found["archive_bytes"]["compiled"] < 300_000
