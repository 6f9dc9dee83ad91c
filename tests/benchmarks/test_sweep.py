"""The small version of the study of sweeps in benchmarks."""

import pytest

from benchmarks.sweep import SPEEDS, bare_eigenvalues, direct, modes_study


@pytest.mark.study
def test_a_named_spectrum_costs_little_more_than_its_eigenvalues():
    study = modes_study(40, 2)
    bare = bare_eigenvalues(study) * 40 * 2 * len(SPEEDS)
    # The study holds 2 with chunks of 80 runs; smaller ones beside other work may miss it by half.
    assert min(direct(study) for _ in range(3)) < 3 * bare
