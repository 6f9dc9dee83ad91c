"""Sensors that repeat each of their values until the next one, beside an input with a sample at every time."""

import numpy as np
import pytest
from scipy.signal import StateSpace, lsim

import motofmi as mf
from motofmi.gap.preprocessing.held_outputs import hold_of
from motofmi.recordings.recording import Recording
from tests.few_laws import only_families

RATE, HELD = 500, 10
TIME = np.arange(8000) / RATE
INERTIA, DAMPING, STIFFNESS = 0.05, 0.1, 2.0


def slow_sensor(seed: int, held: int = HELD, first: int = 3) -> Recording:
    """A joint under a smooth torque, whose angle is sampled at 50 Hz with noise of 0.1 %."""
    random = np.random.default_rng(seed)
    turns, phases = 2 * np.pi * np.linspace(0.1, 2.5, 25), random.uniform(0, 2 * np.pi, 25)
    torque = np.cos(np.outer(TIME, turns) + phases).sum(axis=1) / 5
    joint = StateSpace([[0, 1], [-STIFFNESS / INERTIA, -DAMPING / INERTIA]], [[0], [1 / INERTIA]], [[1, 0]], [[0]])
    _, angle, _ = lsim(joint, torque, TIME)
    angle = angle + 1e-3 * np.std(angle) * random.standard_normal(len(TIME))
    last = np.maximum((np.arange(len(TIME)) - first) // held * held + first, 0)
    return Recording(f"run_{seed}", TIME, {"torque": torque, "angle": angle[last]}, {"torque": "N.m", "angle": "rad"})


@pytest.mark.parametrize(("held", "first"), [(10, 0), (10, 3), (2, 1), (33, 7)])
def test_the_hold_of_a_slow_sensor_and_its_first_sample_are_found(held, first):
    assert hold_of(slow_sensor(1, held, first)["angle"]) == (held, first)


@pytest.mark.parametrize("signal", [
    np.sin(3 * TIME), np.round(np.sin(3 * TIME), 2), np.floor(20 * TIME) / 100, np.round(np.sin(0.5 * TIME), 1), 0 * TIME,
])  # fmt: skip
def test_a_smooth_or_a_quantised_signal_is_not_held(signal):
    """The encoder of a constant rate steps at equal intervals, by one step each."""
    assert hold_of(signal) == (1, 0)


def test_a_slow_sensor_is_no_delay(monkeypatch):
    """It is late by half of its sampling interval on average: channel_delay was named."""
    only_families(monkeypatch, ("channel_delay", "coulomb_friction", "extra_mode"))
    found = mf.find_gap(slow_sensor(1), validation=slow_sensor(2), component="driven_joint")
    assert (found.verdict, found.effects) == ("none", [])
    assert any("angle repeats each of its values in 10 samples" in each and "50 Hz" in each for each in found.limitations)
    stiffness = found.to_dict()["base"]["stiffness"]
    assert stiffness["value"] == pytest.approx(STIFFNESS, abs=4 * stiffness["standard_error"] + 1e-3)
