"""Stamps as loggers write them: the rate and the samples that are behind them."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from fmus.support.errors import InputError
from motofmi.frequency_response.estimators import estimate
from motofmi.recordings.quality import sampling_warnings
from motofmi.recordings.recording import Recording
from motofmi.recordings.resampling import uniform
from motofmi.recordings.time_stamps import ENOUGH, complete, interval

N = 4000


def sine(times):
    return np.sin(2 * np.pi * 3.0 * times) + 0.5 * np.cos(2 * np.pi * 11.0 * times)


def recording(stamps, values):
    return Recording("run", stamps, {"steer_angle": values}, {"steer_angle": "rad"})


@pytest.mark.slow
@given(rate=st.floats(20, 2000), decimals=st.integers(2, 6), first=st.floats(0, 1e4))
def test_rounded_stamps_tell_the_rate(rate, decimals, first):
    longer = (
        10.0**decimals / rate
    ) % 1  # share of the steps; where long or short ones are few they may as well be gaps
    assume(10.0**-decimals < 0.4 / rate or N * min(longer, 1 - longer) > 2 * ENOUGH)
    stamps = np.round(first + np.arange(N) / rate, decimals)
    assert complete(stamps)
    assert 1 / interval(stamps) == pytest.approx(
        rate, rel=2 * 10.0**-decimals * rate / N + 1e-9
    )  # both ends are rounded


def test_gaps_do_not_move_the_rate():
    stamps = np.delete(np.round(np.arange(N) / 256, 3), [*range(500, 700), 2000])
    assert 1 / interval(stamps) == pytest.approx(256, rel=1e-4)  # three edges of gaps are rounded
    assert not complete(stamps)


def test_stamps_that_are_rounded_are_replaced_and_the_samples_stay():
    times = np.arange(N) / 256
    made, notes = uniform(recording(np.round(times, 3), sine(times)))
    assert np.array_equal(made["steer_angle"], sine(times))
    assert made.time == pytest.approx(times, abs=5.1e-4) and np.ptp(np.diff(made.time)) < 1e-9
    assert "rounded or late by up to 0.5 ms" in notes[0]


def test_jitter_of_the_first_and_the_last_stamp_does_not_stretch_the_recording():
    times, late = np.arange(N) / 256, np.random.default_rng(1).uniform(-4e-4, 4e-4, N)
    late[[0, -1]] = 4e-4, -4e-4
    made, _ = uniform(recording(times + late, sine(times)))
    # 4 standard errors of the slope of a line by least squares, sqrt(12 / N^3) of the jitter, at both ends.
    assert made.time - made.time[0] == pytest.approx(times, abs=4 * 12**0.5 / N**0.5 * 4e-4 / 3**0.5)


def test_missing_samples_are_bridged_and_the_others_stay():
    times, gone = np.arange(N) / 256, [700, 701, 2500, *range(3000, 3010)]
    kept = np.delete(np.arange(N), gone)
    made, notes = uniform(recording(np.round(times[kept], 3), sine(times[kept])))
    assert len(made.time) == N and "13 missing samples" in notes[0]
    assert np.array_equal(made["steer_angle"][kept], sine(times[kept]))
    # A spline over three intervals at 23 samples a period: (w h)^4 / 384, and what its neighbours add
    assert made["steer_angle"][gone[:3]] == pytest.approx(sine(times[gone[:3]]), abs=3e-3)
    assert made["steer_angle"][3004] == pytest.approx(
        np.interp(times[3004], times[[2999, 3010]], sine(times[[2999, 3010]]))
    )
    assert made.gaps[0] == pytest.approx(times[[2999, 3010]], abs=5.1e-4) and len(made.gaps) == 1
    assert np.array_equal(np.flatnonzero(made.broken), np.arange(3000, 3010))


def test_several_samples_to_a_stamp():
    times = np.arange(N) / 256
    made, notes = uniform(recording(np.floor(100 * times) / 100, sine(times)))
    assert np.array_equal(made["steer_angle"], sine(times)) and notes
    assert made.rate == pytest.approx(256, rel=1e-3)


def test_stamps_with_three_significant_digits():
    times = np.arange(1200) / 30
    stamps = np.array([float(f"{t:.3g}") for t in times])  # from 10 s on they step by 0.1 s
    made, _ = uniform(recording(stamps, sine(times)))
    assert np.array_equal(made["steer_angle"], sine(times)) and made.rate == pytest.approx(30, rel=2e-3)
    assert len(sampling_warnings(stamps)) == 1 and "coarse" in sampling_warnings(stamps)[0]


def test_stamps_that_mostly_repeat_and_are_of_no_grid_are_refused():
    stamps = np.repeat(np.cumsum([0.0, 0.1, 0.1, 5.0, *[0.1] * 96]), 3)
    assert sampling_warnings(stamps) == ["200 duplicate time stamps, first at 0 s"]
    with pytest.raises(InputError, match="most time stamps are duplicates"):
        uniform(recording(stamps, sine(stamps)))


@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_samples_that_were_taken_late_are_resampled(noise):
    """The stamps are correct: samples left on the uniform grid would be up to 0.4 ms off, an error of 0.02 of the
    amplitude."""
    rng = np.random.default_rng(1)
    times = (np.arange(N) + 0.1 * rng.uniform(-1, 1, N)) / 256
    made, notes = uniform(recording(times, sine(times) + noise * rng.standard_normal(N)))
    assert "were interpolated onto it" in notes[0]
    left = made["steer_angle"] - sine(made.time)
    assert np.std(left) < 1.1 * noise + 1e-4  # of a cubic spline through 23 samples a period


def test_an_irregular_clock_is_no_missing_sample():
    """Steps of 3.0 to 4.4 ms, as a loop without a clock writes them: the stamps move away from every regular grid."""
    rng = np.random.default_rng(2)
    times = np.cumsum(rng.uniform(3.0e-3, 4.4e-3, N))
    made, notes = uniform(recording(times, sine(times)))
    assert "time stamps jitter (steps of 3.01 to 4.39 ms" in notes[0] and "missing" not in notes[0]
    assert made.gaps == made.bridged == () and abs(len(made.time) - N) <= 1
    # A cubic spline at 20 samples a period: (w h)^4 / 384 of half an amplitude, and more at the ends
    assert made["steer_angle"][5:-5] == pytest.approx(sine(made.time)[5:-5], abs=2e-3)
    assert uniform(recording(np.delete(times, range(2000, 2050)), np.zeros(N - 50)))[0].gaps[0] == pytest.approx(
        times[[1999, 2050]]
    )


def test_late_stamps_of_a_clock_are_no_missing_samples():
    """Up to 0.4 of the interval early or late: steps of 0.2 to 1.8 intervals, each sample in its own place."""
    rng = np.random.default_rng(3)
    times = (np.arange(N) + rng.uniform(-0.4, 0.4, N)) / 256
    made, notes = uniform(recording(times, sine(times)))
    assert len(made.time) == N and made.bridged == () and "missing" not in notes[0]


def test_exact_stamps_are_left_alone():
    times = np.arange(N) / 128
    run = recording(times, sine(times))
    assert uniform(run) == (run, ())


@pytest.mark.slow
def test_a_frequency_response_does_not_know_how_its_stamps_were_rounded():
    """The torque of an inertia of 0.2: its apparent value moved by 5 % when the rate was 2.4 % off."""
    rng, times = np.random.default_rng(3), np.arange(0, 60, 1 / 256)
    phases = rng.uniform(0, 2 * np.pi, 200)
    w = 2 * np.pi * np.linspace(0.5, 12, 200)
    waves = np.cos(np.outer(times, w) + phases)
    columns = {"steer_angle": waves.sum(axis=1), "steer_torque": -0.2 * (waves * w**2).sum(axis=1)}
    units = {"steer_angle": "rad", "steer_torque": "N.m"}
    exact, rounded = (estimate(Recording("run", t, columns, units)) for t in (times, np.round(times, 3)))
    assert np.abs(rounded.inertance) == pytest.approx(np.abs(exact.inertance), rel=1e-3)


def test_stamps_that_never_step_are_refused():
    with pytest.raises(InputError, match="most time stamps are duplicates"):
        uniform(recording(np.zeros(N), sine(np.arange(N))))
