"""The benchmark of blind cases: it draws, finds, keeps what it has found, and counts as a book of statistics does."""

import json

import pandas as pd
import pytest

pytest.importorskip("zarr", reason="the extra motofmi[scale] is not installed")
pytest.importorskip("numba", reason="the simulator of the hidden effects is compiled by numba")
from benchmarks.gap_blind import run, wilson


@pytest.mark.study
def test_one_quiet_case_is_found_quiet_and_not_run_again(tmp_path):
    first = run(lambda items, _: items, cases=1, seed=1, out=tmp_path, kinds=["none"])
    assert first["confusion"] == {"none -> none": 1}
    table = tmp_path / "runs.parquet"
    assert json.loads(pd.read_parquet(table)["row"][0])["truth"]["families"] == []
    kept = table.stat()
    assert run(lambda items, _: items, cases=1, seed=1, out=tmp_path, kinds=["none"]) == first
    assert table.stat() == kept


@pytest.mark.parametrize(("successes", "trials", "low", "high"),
                         [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0000, 0.1611), (1, 29, 0.0061, 0.1718)])  # fmt: skip
def test_intervals_are_those_that_newcombe_prints(successes, trials, low, high):
    """Newcombe, Stat. Med. 17 (1998) 857-872, Table I, score method; printed to four digits."""
    found = wilson(successes, trials)
    assert (found["from"], found["to"]) == pytest.approx((low, high), abs=6e-5)
