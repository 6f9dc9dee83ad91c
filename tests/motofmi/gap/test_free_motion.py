"""Free motions whose rate alone is recorded, with the offset and the noise of a gyroscope."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, sosfilt

import motofmi as mf
from fmus.mechanisms import Pendulum
from motofmi.gap.estimation.fit_result import parameters_of
from motofmi.gap.estimation.initial_fit import initial_fit
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.free_decay import highest_of_motion, is_free, mean_frequency
from motofmi.gap.preprocessing.one_way import one_way_rates
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.recordings.recording import Recording
from motofmi.workflows.gap.input_output import anchored

RATE, SECONDS, FREQUENCY = 1000.0, 30.0, 0.63
OFFSET = 1.5  # rad/s, larger than the motion
INERTIA = 0.1  # kg.m2, as given
STIFFNESS = INERTIA * (2 * np.pi * FREQUENCY) ** 2
FRICTION, DAMPING = 0.003, 0.006  # N.m, N.m.s/rad
TIME = np.arange(int(SECONDS * RATE)) / RATE


def noise(seed):
    """Noise of 0.01 rad/s up to 120 Hz, where the sensor cuts it off: above the level near half the sampling rate."""
    white = np.random.default_rng(seed).standard_normal(len(TIME))
    return 0.01 * sosfilt(butter(6, 120.0, fs=RATE, output="sos"), white) + 1e-4 * white


def swing(released, seed):
    """The exact rate with dry friction f: half cycles about a deflection of f / k against the motion."""
    omega, shift = 2 * np.pi * FREQUENCY, FRICTION / STIFFNESS
    half = (TIME * 2 * FREQUENCY).astype(int)
    amplitude = released - (2 * half + 1) * shift
    assert amplitude.min() > shift  # it does not stick yet
    rate = -((-1.0) ** half) * amplitude * omega * np.sin(omega * (TIME - half / (2 * FREQUENCY)))
    return Recording(f"swing_{seed}", TIME, {"rate": rate + OFFSET + noise(seed)}, {"rate": "rad/s"})


def decaying(seed):
    """The exact rate of a damped pendulum at small angles, from 0.25 rad: d/dt e^(-d t) (cos w t + d / w sin w t)."""
    decay, natural = DAMPING / (2 * INERTIA), STIFFNESS / INERTIA
    omega = np.sqrt(natural - decay**2)
    rate = -0.25 * np.exp(-decay * TIME) * natural / omega * np.sin(omega * TIME)
    return Recording(f"decay_{seed}", TIME, {"rate": rate + OFFSET + noise(seed)}, {"rate": "rad/s"})


@pytest.mark.slow
def test_stiffness_and_damping_are_found_beside_the_offset_of_a_gyroscope():
    experiment, kept = anchored(input_output_experiment(Pendulum(inertia=INERTIA), ["rate"]))
    assert kept == "inertia"
    run = replace(prepare_sampled_run(decaying(1), experiment), experiment=experiment)
    found = parameters_of(initial_fit(FreeInitialStateModel(experiment), [run]))
    # 1e-4: noise of 0.01 rad/s on 30,000 samples of a motion of 0.5 rad/s; the damping shows in the decay alone
    assert found["gravity_stiffness"][0] == pytest.approx(STIFFNESS, rel=1e-4)
    assert found["damping"][0] == pytest.approx(DAMPING, rel=5e-3)


@pytest.mark.study
def test_the_friction_of_a_pendulum_is_named_from_the_rate_of_a_gyroscope():
    found = mf.find_gap(swing(0.25, 1), validation=swing(0.2, 2), component=Pendulum(inertia=INERTIA))
    assert [e["name"] for e in found.effects] == ["coulomb_friction"] and found.verdict == "named"
    value = found.effects[0]["parameters"]["friction_torque"]
    # four standard errors; 2 % for the transition of friction through zero rate
    assert value["value"] == pytest.approx(FRICTION, abs=4 * value["standard_error"] + 0.02 * FRICTION)
    assert not any("has one sign" in sentence for sentence in found.limitations)


def test_a_rate_that_oscillates_in_a_free_motion_has_an_offset_and_not_one_sign():
    elements = Pendulum().elements.values()
    assert one_way_rates(swing(0.25, 1), elements, free=True) == frozenset()
    assert one_way_rates(swing(0.25, 1), elements, free=False) == {"rate"}  # a motor may turn with a varying rate
    slowing = Recording("run", TIME, {"rate": 20.0 * np.exp(-TIME / 20.0) + 0.5 * np.sin(TIME)}, {"rate": "rad/s"})
    assert one_way_rates(slowing, elements, free=True) == {"rate"}


def test_a_free_motion_is_compared_up_to_its_harmonics_and_not_up_to_the_noise():
    recording = swing(0.25, 1)
    run = prepare_sampled_run(recording, input_output_experiment(Pendulum(), ["rate"]))
    assert is_free(recording, ["torque"])
    assert 3 * FREQUENCY < run.reduction_band < 20 * FREQUENCY
    assert run.recording.rate < RATE / 4
    driven = highest_of_motion(recording["rate"], RATE, free=False)
    assert driven > 100.0  # where the sensor cuts its noise off


def test_a_pendulum_that_goes_round_is_not_limited_to_harmonics_of_its_mean_frequency():
    round_and_round = 6.0 * TIME + 0.3 * np.sin(2 * np.pi * 2.0 * TIME) + 1e-4 * noise(4)
    assert mean_frequency(round_and_round, RATE) < 0.1
    assert highest_of_motion(round_and_round, RATE, free=True) >= 2.0


def test_a_further_mode_beyond_the_harmonics_is_compared():
    two = np.cos(2 * np.pi * 0.5 * TIME) + 0.1 * np.cos(2 * np.pi * 20.0 * TIME) + noise(3)
    assert mean_frequency(two, RATE) < 1.0
    assert 20.0 <= highest_of_motion(two, RATE, free=True) < 30.0
