"""A recording that is reduced to a lower rate while it is read, whatever its time stamps are."""

import numpy as np
import pytest

from fmus.support.errors import InputError
from motofmi.recordings.reading import read_recording

ANGLE = {"angle": "rad"}


def written(path, time, unit="s"):
    """A file with an angle of 0.2 rad at 1.5 Hz, of stamps (n,) [s] in a unit of time."""
    angle = 0.2 * np.sin(2 * np.pi * 1.5 * time)
    stamps = {"s": time, "ms": 1e3 * time, "min": time / 60}[unit]
    rows = "\n".join(f"{t:.9g},{a:.9g}" for t, a in zip(stamps, angle, strict=True))
    path.write_text(f"time [{unit}],angle [rad]\n{rows}\n")
    return path


@pytest.mark.parametrize("unit", ["ms", "min"])
def test_the_rate_is_in_hertz_whatever_the_unit_of_the_time_is(tmp_path, unit):
    time = np.arange(0, 10, 0.001)
    files = (written(tmp_path / f"{u}.csv", time, u) for u in ("s", unit))
    in_seconds, other = (read_recording(file, rate=100, quantities=ANGLE) for file in files)
    assert other.rate == pytest.approx(100, rel=1e-6)
    assert any(w.startswith("reduced from 1000 Hz to 100 Hz") for w in other.warnings)
    np.testing.assert_allclose(other["angle"], in_seconds["angle"], atol=1e-7)  # nine digits are written


def test_between_samples_that_are_within_the_reduced_interval_nothing_is_missing(tmp_path):
    """A controller that samples every 2 ms and pauses for 12 ms after each 9 samples."""
    time = np.cumsum(np.tile([0.002] * 8 + [0.012], 300))
    run = read_recording(written(tmp_path / "paused.csv", time), rate=50, quantities=ANGLE)
    # Linear interpolation over 12 ms is off by at most (2 pi 1.5 Hz 12 ms)^2 / 8 = 0.16 %.
    np.testing.assert_allclose(run["angle"], 0.2 * np.sin(2 * np.pi * 1.5 * run.time), atol=1e-3)
    assert np.ptp(np.diff(run.time)) < 0.1 / run.rate and not run.gaps


def test_stamps_of_bursts_are_refused_with_what_to_do(tmp_path):
    """Samples at 260 Hz that arrive by 13 about every 50 ms."""
    arrived = np.arange(0, 10, 0.05) + 0.01 * np.random.default_rng(1).uniform(size=200)
    time = np.repeat(arrived, 13) + np.tile(0.001 * np.arange(13), 200)
    file = written(tmp_path / "bursts.csv", time)
    with pytest.raises(InputError, match=r"no 0.4 s without a missing sample.*leave out the column of the time"):
        read_recording(file, rate=50, quantities=ANGLE)
    (tmp_path / "rig.json").write_text('{"sampling": {"value": 260, "unit": "Hz"}}')
    run = read_recording(file, {"time": "unused"}, quantities=ANGLE)
    assert run.rate == pytest.approx(260) and len(run.time) == len(time) and run.unread == ()
