"""The study of couplings and masters, small."""

import pytest

from benchmarks import coupling
from fmus.cosimulation.coupling import COUPLINGS


@pytest.mark.study
def test_the_study_reports_rates_and_errors_of_every_coupling():
    found = coupling.run(lambda items, *_: items, count=2000, samples=200, rounds=1, devices=(2, 4))
    assert set(found["ours"]) == set(COUPLINGS)
    accurate = found["ours"]["interface_jacobian"]["0.001"]
    assert accurate["trajectory_error"] < 1e-9 < found["ours"]["jacobi"]["0.001"]["trajectory_error"]
    assert (
        found["ours"]["gauss_seidel"]["0.01"].get("diverges")
        or found["ours"]["gauss_seidel"]["0.01"]["trajectory_error"] > 0.1
    )
    assert found["most_accurate_over_bare"] > 0
    assert found["peers"]["fmpy loop"]["0.001"]["trajectory_error"] > 1e3 * accurate["trajectory_error"]
