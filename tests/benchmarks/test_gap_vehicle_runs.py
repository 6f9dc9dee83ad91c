"""The benchmark of blind runs of vehicles: it draws, finds, keeps what it has found, and counts."""

import pytest

pytest.importorskip("numba", reason="the simulator of the hidden effects is compiled by numba")
from benchmarks.gap_vehicle_runs import run, summary


@pytest.mark.slow
@pytest.mark.study
def test_one_quiet_case_is_found_quiet_and_not_run_again(tmp_path):
    first = run(lambda items, _: items, cases=1, out=tmp_path, first=4)
    assert first["confusion"] == {"none -> none": 1}
    assert run(lambda items, _: items, cases=1, out=tmp_path, first=4) == first


def test_tied_sets_and_names_are_counted_apart():
    row = {
        "hidden": "damper",
        "family": "steer_damping",
        "vehicle": "motorcycle",
        "names": [],
        "tied": [],
        "seconds": 1.0,
        "delta_chi2": 50.0,
    }
    rows = [row | {"verdict": "named", "names": ["steer_damping"]}, row | {"verdict": "tied", "tied": ["steer_damping", "added_inertia"]},
            row | {"verdict": "named", "names": ["aerodynamics"]}]  # fmt: skip
    rates = summary(rows)["rates"]
    assert rates["effect of the library, delta chi-square from 40: its name, or a tied set with it"][
        "rate"
    ] == pytest.approx(2 / 3)
    assert rates["effect of the library of any strength: a wrong name"]["rate"] == pytest.approx(1 / 3)
