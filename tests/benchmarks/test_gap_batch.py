"""The benchmark of a batch of recordings in small."""

import pytest

from benchmarks.gap_batch import run
from fmus.support.progress import track

pytest.importorskip("zarr", reason="the extra motofmi[scale] is not installed")


@pytest.mark.study
def test_a_killed_batch_has_a_verdict_or_a_reason_for_every_file():
    found = run(track, files=6, broken=2)
    assert (found["verdicts"], len(found["reasons"])) == (4, 2)
    assert all(f"{name}.csv" in reason for name, reason in found["reasons"].items())
    assert found["by_hidden"] == {"friction -> coulomb_friction": 1, "nothing -> none": 3}
    assert found["computed_again"] == 0
