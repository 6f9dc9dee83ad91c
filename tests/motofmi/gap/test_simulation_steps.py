"""The simulation steps per sample that a motion needs, against the errors of simulations with exact solutions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import butter, sosfilt

from fmus.mechanisms import MassSpringDamper
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.collocation import Motion, inner_times
from motofmi.gap.models.equations import Equations
from motofmi.gap.models.implicit_formulas import HERMITE_SIMPSON
from motofmi.gap.models.simulation import simulate
from motofmi.gap.preprocessing.input_interpolation import HELD
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.preprocessing.simulation_steps import ERROR, phase_error, simulation_steps
from motofmi.recordings.recording import Recording

RATE = 100.0
TIME = np.arange(4000) / RATE


def sine(frequency, amplitude=1.0):
    return amplitude * np.sin(2 * np.pi * frequency * TIME)


@pytest.mark.parametrize("steps", [12, 16, 24])
def test_the_error_is_that_of_a_simulated_oscillation(steps):
    """An undamped mass on a spring over one cycle: x = cos w t returns to 1 with the rate 0."""
    w = 2 * np.pi
    mass = MassSpringDamper().with_values(mass=1.0, spring_stiffness=w**2, spring_damping=0.0)
    time = np.linspace(0, 1, steps + 1)
    at, between = ({"force": np.zeros(len(t))} for t in (time, inner_times(time, HERMITE_SIMPSON)))
    start = np.repeat([[1.0, 0.0]], len(time), axis=0)
    made = simulate(
        Equations(mass, ["displacement"], []), mass.start_values(), Motion(time, at, between), start, start[0]
    )
    phase = abs(np.arctan2(made.states[-1, 1] / w, made.states[-1, 0]))
    # 0.06: the next term of the phase is (w h)^2 / 21 times the first one, 1.3 % at 12 steps, and the tolerance of
    # Newton's method
    assert phase == pytest.approx(phase_error(np.array([1.0]), np.array([1.0]), 1 / steps), rel=0.06)


@pytest.mark.parametrize(("per_cycle", "steps"), [(20, 1), (10, 2), (5, 4)])
def test_a_sine_has_steps_by_its_samples_per_cycle(per_cycle, steps):
    """2 pi (2 pi / n)^4 / 720 = 1e-4 at n = 19 steps per cycle; four steps are enough for any spectrum."""
    assert simulation_steps(sine(RATE / per_cycle)[:, None], RATE) == steps


def test_fast_noise_with_little_power_needs_no_further_step():
    """Noise of 1 % up to 0.3 of the sampling rate: its error at one step is 2 pi (0.6 pi)^4 / 720 = 0.11 at most, of a
    rms of 1.4 %: 1.5e-3 at most, and with two steps 1e-4 at most. A motion of that amplitude would need four."""
    band = butter(8, [0.05 * RATE, 0.3 * RATE], "bandpass", fs=RATE, output="sos")
    noise = sosfilt(band, np.random.default_rng(0).standard_normal(len(TIME)))
    slow = sine(0.5)
    assert simulation_steps((slow + 0.01 * slow.std() / noise.std() * noise)[:, None], RATE) <= 2
    assert simulation_steps(noise[:, None], RATE) == 4


def test_the_output_with_the_fastest_motion_decides():
    both = np.column_stack([sine(1.0), sine(10.0)])
    assert simulation_steps(both, RATE) == simulation_steps(both[:, ::-1], RATE) == 2


@given(frequency=st.floats(0.2, 40.0), share=st.floats(0.0, 1.0))
def test_the_steps_are_enough_or_the_most(frequency, share):
    """The amplitude-weighted error of two sines, of the slow one and of another one, by the exact spectrum."""
    steps = simulation_steps((sine(1.0) + sine(frequency, share))[:, None], RATE)
    powers = np.array([1.0, share**2])
    error = phase_error(np.array([1.0, frequency]), powers / powers.sum(), 1 / (RATE * steps))
    # 1.5: the smoothed spectrum spreads each line over its neighbours
    assert steps == 4 or error < 1.5 * ERROR


def test_a_long_recording_has_no_more_steps_than_samples_allow():
    assert simulation_steps(np.tile(sine(25.0), 10)[:, None], RATE) == 1


def test_a_held_input_is_simulated_with_nodes_between_samples():
    recording = Recording(
        "slow", TIME, {"force": sine(0.5), "displacement": sine(0.5)}, {"force": "N", "displacement": "m"}
    )
    run = prepare_sampled_run(recording, input_output_experiment(MassSpringDamper(), list(recording.columns)))
    assert run.steps_per_sample == 1 and run.with_interpolation(HELD).steps_per_sample == 2
