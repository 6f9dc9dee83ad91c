"""The benchmark of blind cases: it draws, finds, keeps what it has found, and counts as a book of statistics does."""

import json

import pytest
from scipy.stats import binomtest

pytest.importorskip("numba", reason="the simulator of the hidden effects is compiled by numba")
from benchmarks.gap_blind import run, wilson


def test_one_quiet_case_is_found_quiet_and_not_run_again(tmp_path):
    first = run(lambda items, _: items, cases=1, seed=1, out=tmp_path, kinds=["none"])
    assert first["confusion"] == {"none -> none": 1}
    kept = (tmp_path / "cases.jsonl").read_text()
    assert json.loads(kept)["truth"]["families"] == []
    assert run(lambda items, _: items, cases=1, seed=1, out=tmp_path, kinds=["none"]) == first
    assert (tmp_path / "cases.jsonl").read_text() == kept


@pytest.mark.parametrize(("successes", "trials"), [(0, 300), (1, 300), (97, 100), (20, 20)])
def test_wilsons_interval_is_scipys(successes, trials):
    interval = binomtest(successes, trials).proportion_ci(method="wilson")
    found = wilson(successes, trials)
    # 1.96 for the normal quantile 1.95996
    assert (found["from"], found["to"]) == pytest.approx((interval.low, interval.high), abs=1e-5)
