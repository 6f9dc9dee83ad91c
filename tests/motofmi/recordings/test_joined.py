"""Short recordings in one."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motofmi.recordings.joined import with_short_joined
from motofmi.recordings.recording import Recording

STEP = 0.01


def recording(count: int, name: str = "run", step: float = STEP, begin: float = 0.0) -> Recording:
    """A sine [m] under a constant force [N], from a time on."""
    time = begin + step * np.arange(count)
    columns = {"displacement": np.sin(3 * (time - begin)), "force": np.full(count, float(count))}
    return Recording(name, time, columns, {"displacement": "m", "force": "N"}, (f"force is constant at {count} N",))


@given(st.lists(st.integers(20, 150), min_size=2, max_size=6), st.floats(-5, 5))
def test_every_sample_is_kept_between_gaps(counts, begin):
    runs = [recording(count, f"run_{i}", begin=begin) for i, count in enumerate(counts)]
    (joined,), (note,) = with_short_joined(runs, 200)
    assert len(joined.gaps) == len(counts) - 1 and all(run.name in note for run in runs)
    assert len(joined.stretches) == len(counts)
    assert np.ptp(np.diff(joined.time)) == pytest.approx(0, abs=1e-9)
    for run, stretch in zip(runs, joined.stretches, strict=True):
        for name in run.columns:
            np.testing.assert_allclose(joined[name][stretch], run[name], atol=1e-9)


def test_recordings_of_nearly_the_same_interval_begin_on_the_common_grid():
    """A spline of a slow sine gives the samples of an interval of 1.01 steps on the common grid exactly."""
    runs = [recording(100, "a"), recording(100, "b", 1.01 * STEP)]
    (joined,), _ = with_short_joined(runs, 200)
    first, second = joined.stretches
    step = 1.005 * STEP
    for stretch in (first, second):
        local = step * np.arange(stretch.stop - stretch.start)
        np.testing.assert_allclose(joined["displacement"][stretch], np.sin(3 * local), atol=1e-6)


@pytest.mark.parametrize(
    "other",
    [
        recording(300, "slow", 2 * STEP),
        replace(recording(300, "torque"), columns={"torque": np.ones(300)}, units={"torque": "N.m"}),
    ],
    ids=["another interval", "other columns"],
)
def test_recordings_that_do_not_suit_stay_apart(other):
    runs, notes = with_short_joined([recording(100), other], 200)
    assert [run.name for run in runs] == ["run", other.name] and notes == ()


def test_what_was_done_to_single_recordings_is_said():
    jitter = 2e-3 * np.random.default_rng(1).uniform(-1, 1, 100)
    late = replace(recording(100, "late"), time=STEP * np.arange(100) + jitter)
    (joined,), _ = with_short_joined([recording(100, "regular"), late], 200)
    assert any(warning.startswith("late: ") and "grid" in warning for warning in joined.warnings)


def test_long_recordings_stay_apart():
    runs = [recording(300, "a"), recording(400, "b")]
    kept, notes = with_short_joined(runs, 200)
    assert all(one is other for one, other in zip(kept, runs, strict=True)) and notes == ()


def test_warnings_name_their_recording_unless_a_constant_differs_from_one_to_the_next():
    runs = [
        replace(recording(n, f"run_{n}"), warnings=("3 samples missing", f"force is constant at {n} N"))
        for n in (50, 60)
    ]
    (joined,), _ = with_short_joined(runs, 200)
    assert joined.warnings == ("run_50: 3 samples missing", "run_60: 3 samples missing")
