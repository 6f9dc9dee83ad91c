"""Signals that repeat each of their values until the next one, beside one with a sample at every time."""

import numpy as np
import pytest
from scipy.signal import lsim

import motofmi as mf
from fmus.mechanisms import DrivenJoint
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.preprocessing.held_signals import at_rate_of_slowest, between_new_values, hold_of
from motofmi.recordings.recording import Recording
from tests.few_laws import only_families
from tests.motofmi.gap.smoothly_driven_joint import JOINT, STIFFNESS, smooth_torque, with_noise

RATE, HELD = 500, 10
TIME = np.arange(8000) / RATE


def slow_sensor(seed: int, held: int = HELD, first: int = 3, slow: str = "angle") -> Recording:
    """A joint under a smooth torque, with noise of 0.1 % on the angle; one of them is sampled at 50 Hz."""
    random = np.random.default_rng(seed)
    torque = smooth_torque(TIME, random)
    _, angle, _ = lsim(JOINT, torque, TIME)
    columns = {"torque": torque, "angle": with_noise(angle, random)}
    last = np.maximum((np.arange(len(TIME)) - first) // held * held + first, 0)
    columns[slow] = columns[slow][last]
    return Recording(f"run_{seed}", TIME, columns, {"torque": "N.m", "angle": "rad"})


@pytest.mark.parametrize(("held", "first"), [(10, 0), (10, 3), (2, 1), (33, 7)])
def test_the_hold_of_a_slow_sensor_and_its_first_sample_are_found(held, first):
    assert hold_of(slow_sensor(1, held, first)["angle"]) == (held, first)


@pytest.mark.parametrize("signal", [
    np.sin(3 * TIME), np.round(np.sin(3 * TIME), 2), np.floor(20 * TIME) / 100, np.round(np.sin(0.5 * TIME), 1), 0 * TIME,
])  # fmt: skip
def test_a_smooth_or_a_quantised_signal_is_not_held(signal):
    """The encoder of a constant rate steps at equal intervals, by one step each."""
    assert hold_of(signal) == (1, 0)


@pytest.mark.parametrize("slow", ["angle", "torque"])
def test_a_slow_sensor_is_no_delay(monkeypatch, slow):
    """It is late by half of its sampling interval on average: channel_delay was named for the angle, and the verdict was
    unknown for the torque."""
    only_families(monkeypatch, ("channel_delay", "coulomb_friction", "extra_mode"))
    runs = [slow_sensor(seed, slow=slow) for seed in (1, 2)]
    found = mf.find_gap(runs[:1], validation=runs[1:], component="driven_joint")
    assert (found.verdict, found.effects) == ("none", [])
    assert any(f"{slow} repeats each of its values in 10 samples" in each and "50 Hz" in each for each in found.limitations)
    stiffness = found.to_dict()["base"]["stiffness"]
    # 0.2 %: the interpolation of the torque between its samples
    assert stiffness["value"] == pytest.approx(STIFFNESS, rel=2e-3)


def test_steps_of_the_input_that_are_long_against_the_motion_are_kept():
    run = slow_sensor(1)
    torque = np.repeat(np.random.default_rng(3).uniform(-1, 1, 160), 50)
    fast = Recording("steps", TIME, {"torque": torque, "angle": np.sin(20 * TIME)}, dict(run.units))
    experiment = input_output_experiment(DrivenJoint(), ["torque", "angle"])
    assert hold_of(torque) == (50, 0)
    assert at_rate_of_slowest(fast, experiment) == (fast, ())


def test_the_sensors_of_a_ride_are_interpolated_between_their_new_values():
    """As of a bus with a slower message; the rate of the other channels is kept."""
    exact = np.sin(2 * np.pi * TIME)
    last = np.maximum((np.arange(len(TIME)) - 3) // HELD * HELD + 3, 0)
    ride = Recording("ride", TIME, {"steer": exact[last], "roll": exact}, {"steer": "rad", "roll": "rad"})
    made, (note,) = between_new_values(ride, ["steer", "roll"])
    assert "steer repeats each of its values in 10 samples" in note
    assert np.max(np.abs(ride["steer"] - exact)) > 0.05
    # a cubic spline: h^4 (2 pi)^4 5/384 = 3e-6 with h = 20 ms, but for the ends
    assert made["steer"][20:-20] == pytest.approx(exact[20:-20], abs=1e-5)
    assert made["roll"] is ride["roll"]
