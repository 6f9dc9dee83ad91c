"""Records with gaps: what is estimated from the stretches between them agrees with the whole record, and with the rider.

An error is measured against the model as the estimator's own weights see it, in standard errors. Of 47 bands, one in
170 such runs errs by more than three by chance.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from fmus.support.errors import InputError
from motofmi.frequency_response.estimators import estimate
from motofmi.frequency_response.excitation import sweep
from motofmi.frequency_response.roll_motion import roll_frf
from motofmi.recordings.resampling import uniform
from motofmi.virtual_rig.simulated_rig import QUIET, Noise, roll_test, steer_test
from motofmi.workflows.measured_rider import rig_response
from rider_fmu import riders
from rider_fmu.components.rider_in_roll import point_heights

MODEL = rig_response()
SWEEPS = {"up": sweep(0.5, 12), "down": sweep(12, 0.5)}


@lru_cache
def run(direction, noise=None):
    return steer_test(riders.load("mean_2011"), 0.125, SWEEPS[direction], noise or Noise(), seed=3, oversampling=4)


def without(recording, *gaps):
    """The recording without the samples in the gaps (begin, length) [s]."""
    kept = np.all([(recording.time < at) | (recording.time >= at + length) for at, length in gaps], axis=0)
    return replace(
        recording, time=recording.time[kept], columns={name: y[kept] for name, y in recording.columns.items()}
    )


def error(frf):
    """Of the apparent inertia (n,), against the model seen through the estimator's weights."""
    return frf.apparent_inertia - np.sum(
        frf.weights / MODEL(2 * np.pi * frf.nodes.ravel()).reshape(frf.nodes.shape), axis=1
    )


@pytest.mark.slow
@pytest.mark.parametrize("direction", SWEEPS)
@pytest.mark.parametrize("at", [5.0, 23.0, 60.0, 120.0, 160.0])
@pytest.mark.parametrize("length", [0.1, 100 / 128, 1.6])
def test_a_gap_does_not_move_the_estimate(direction, at, length):
    whole, gap = estimate(run(direction)), estimate(without(run(direction), (at, length)))
    assert any("1 gap is left out" in w for w in gap.warnings)
    assert len(gap.frequency) >= len(whole.frequency) - 6  # within 4 s of a gap near the end of a sweep of 0.06 Hz/s
    same = np.isin(whole.frequency, gap.frequency)
    assert np.max(np.abs(error(gap) - error(whole)[same]) / np.sqrt(gap.variance)) < 3
    assert np.max(np.abs(error(gap)) / np.sqrt(gap.variance)) < 3


@pytest.mark.slow
@pytest.mark.parametrize("at", [23.0, 60.0, 120.0])
def test_without_noise_cuts_leak_nothing_that_a_bridge_would(at):
    """The model is met to 1e-3, where straight lines over the gap are off by more than 5 % near the frequency of the
    gap."""
    cut = without(run("up", QUIET), (at, 100 / 128))
    assert np.max(np.abs(error(estimate(cut)) / estimate(cut).apparent_inertia)) < 1e-3
    bridged = estimate(replace(uniform(cut)[0], gaps=()))
    assert np.max(np.abs(error(bridged) / bridged.apparent_inertia)) > 0.05


@pytest.mark.slow
def test_many_gaps():
    gaps = [(10 + 18 * k, 0.18) for k in range(10)]
    frf = estimate(without(run("up"), *gaps))
    assert np.max(np.abs(error(frf)) / np.sqrt(frf.variance)) < 3
    assert any(
        "10 gaps are left out, the first at 9.99219 s: the spectra are of the 11 stretches between" in w
        for w in frf.warnings
    )
    assert any("no estimate at 0.5, 0.75, 1, " in w for w in frf.warnings) and len(frf.frequency) > 40


@pytest.mark.slow
def test_stretches_too_short_for_the_bands_are_said():
    gaps = [(5 + 5 * k, 0.04) for k in range(39)]
    with pytest.raises(
        InputError, match=r"40 stretches between, none long enough for bands of 0.25 Hz; give wider bands"
    ):
        estimate(without(run("up"), *gaps))
    assert len(estimate(without(run("up"), *gaps), width=1.0).frequency) >= 10


@pytest.mark.slow
def test_a_short_gap_is_bridged_and_the_record_stays_whole():
    frf = estimate(without(run("up"), (60.0, 2 / 128)))
    assert len(frf.frequency) == 47 and not any("left out" in w for w in frf.warnings)


@pytest.mark.slow
def test_a_gap_in_a_roll_test():
    recording, levels = roll_test(accelerometer_noise=0.0)
    heights = {"mockup": 0.5, **point_heights(riders.load("roll_3_2008"))}
    whole, gap = (roll_frf(r, heights, levels).absolute for r in (recording, without(recording, (47.0, 0.5))))
    for point, curve in whole.items():
        # a level of 20 s is cut into two: averages over 0.15 Hz weigh its flanks otherwise
        np.testing.assert_allclose(gap[point], curve, atol=0.02 * np.abs(curve).max())
