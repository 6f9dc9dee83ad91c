"""Studies of many cases: each is run once, whatever ends in between."""

import pytest

from benchmarks._resumed import resumed
from fmus.support.errors import InputError

pytest.importorskip("zarr", reason="the extra motofmi[scale] is not installed")


@pytest.mark.slow
def test_a_case_is_run_once_and_another_study_is_refused(tmp_path):
    runs = tmp_path / "runs"
    runs.mkdir()

    def one(number):
        (runs / f"{number} {len(list(runs.glob(f'{number} *')))}").touch()
        return {"square": number**2}

    out = tmp_path / "out"
    expected = [{"case": k, "square": k**2} for k in range(3)]
    assert resumed(3, out, one, seed=1) == resumed(3, out, one, seed=1) == expected
    assert sorted(path.name for path in runs.iterdir()) == ["0 0", "1 0", "2 0"]
    with pytest.raises(InputError, match="holds another study"):
        resumed(3, out, one, seed=2)


@pytest.mark.slow
def test_a_case_that_fails_is_an_error_at_the_end(tmp_path):
    def one(number):
        return {"inverse": 1 / number}

    with pytest.raises(RuntimeError, match=r"1 of 2 cases .* failed: case 0: ZeroDivisionError"):
        resumed(2, tmp_path / "out", one)
