"""Recorded inputs between their samples, and the rate and acceleration of an imposed motion."""

from time import process_time

import numpy as np
import pytest

from fmus import Component, input, parameter, state
from motofmi.gap.estimation.initial_fit import initial_fit
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.input_interpolation import (
    input_function,
    is_held,
    is_rough,
    motion_functions,
    unresolved_input,
)
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.recordings.recording import Recording


class Lag(Component):
    """A first-order lag."""

    time_constant = parameter("s", "Time constant", min=1e-3, start=0.3)
    command = input("V", "Command")
    response = state("V", "Response", exposed=True)

    def equations(self, v, m):
        return {"der(response)": (v.command - v.response) / v.time_constant}


@pytest.mark.parametrize("samples", [4000, 100_000])
def test_an_imposed_motion_is_differentiated_twice(samples):
    time = 0.005 * np.arange(samples)
    angle = 0.1 * np.sin(2 * np.pi * 2 * time) + 0.05 * np.sin(2 * np.pi * 3.3 * time)
    exact = -0.1 * (4 * np.pi) ** 2 * np.sin(4 * np.pi * time) - 0.05 * (6.6 * np.pi) ** 2 * np.sin(6.6 * np.pi * time)
    noisy = angle + 1e-5 * np.random.default_rng(3).standard_normal(len(time))
    found = motion_functions(time, noisy, "rate")["der(rate)"](time)
    inside = slice(200, -200)
    # Differences of the samples themselves would be off by 1e-5 * sqrt(6) / 0.005^2 = 1 rad/s2
    assert np.std(found[inside] - exact[inside]) < 0.01 * np.std(exact)


@pytest.mark.slow
def test_the_time_of_an_imposed_motion_is_proportional_to_its_samples():
    """Four times the samples take four times as long, and sixteen times where it grows with samples times knots."""

    def seconds(samples: int) -> float:
        time = 0.005 * np.arange(samples)
        taken = []
        for _ in range(3):
            begun = process_time()
            motion_functions(time, 0.1 * np.sin(2 * np.pi * 30 * time), "rate")  # knots are close
            taken.append(process_time() - begun)
        return min(taken)

    assert seconds(48_000) < 10 * seconds(12_000)


def test_an_input_that_changes_in_steps_is_held():
    steps = np.repeat(np.random.default_rng(1).uniform(-1, 1, 40), 25)
    assert is_held(steps) and not is_held(np.sin(0.1 * np.arange(1000))) and not is_held(np.ones(1000))


def test_the_base_is_fitted_with_the_interpolation_of_a_command_in_steps():
    """Held between samples, the exact response of y' = (u - y) / T from one sample to the next is that of a constant.
    A square wave of 1 s has 1 % of its power in the upper half of the spectrum at 100 Hz."""
    time, lag = np.arange(0, 30, 0.01), 0.2
    command = np.sign(np.sin(2 * np.pi * time + 0.1))
    response = np.zeros(len(time))
    for k in range(1, len(time)):
        response[k] = command[k - 1] + (response[k - 1] - command[k - 1]) * np.exp(-0.01 / lag)
    noisy = response + 1e-4 * np.random.default_rng(2).standard_normal(len(time))
    recording = Recording("steps", time, {"command": command, "response": noisy}, {"command": "V", "response": "V"})
    experiment = input_output_experiment(Lag(), ["command", "response"])
    found = initial_fit(FreeInitialStateModel(experiment), [prepare_sampled_run(recording, experiment)])
    assert not is_rough(command)
    assert found.runs[0].kind == "held"
    assert np.exp(found.x[0]) == pytest.approx(lag, rel=2e-3)  # 0.5 % of the half sample by which lines are early


def test_a_held_input_keeps_its_amplitude():
    """Half way to the highest frequency lines through the samples are 10 % too small, sinc(1/4) of what is held."""
    time = np.arange(0, 40, 0.1)
    values = np.sin(2 * np.pi * 2.5 * time)
    inside = 10 + 5e-4 * (np.arange(40000) + 0.5)
    wave = np.exp(-2j * np.pi * 2.5 * inside)
    held = values[np.floor(inside / 0.1).astype(int)]
    exact, lines, joined = (
        np.mean(y * wave)
        for y in (
            held,
            input_function(time, values, "lines")(inside - 0.05),
            input_function(time, values, "held")(inside),
        )
    )
    assert abs(joined / exact - 1) < 1e-3
    assert abs(lines / exact) == pytest.approx(np.sinc(0.25), abs=2e-3)


@pytest.mark.slow
def test_what_samples_miss_of_a_pulses_area():
    """Pulses that begin and end anywhere between samples: as much as the spline through them errs by is said to be
    unforeseen."""
    rng, time = np.random.default_rng(11), np.arange(0, 60.0)
    errors, said = [], []
    for begin, width in zip(rng.uniform(20, 21, 400), rng.uniform(6, 12, 400), strict=True):
        values = ((time >= begin) & (time < begin + width)).astype(float)
        errors.append(input_function(time, values, "smooth").integrate(0, 59) - width)
        said.append(np.sqrt(np.sum(unresolved_input(values) ** 2)))
    # Two ends, each evenly spread over a sample; 400 pulses scatter by 4 %
    assert np.std(errors) == pytest.approx(np.sqrt(2 / 12), rel=0.1)
    assert np.sqrt(np.mean(np.square(said))) == pytest.approx(np.sqrt(2 / 12), rel=0.1)


def test_a_smooth_input_is_resolved():
    time = np.arange(0, 20, 0.1)
    four, six = (
        (2 * np.sin(np.pi / 10)) ** 4 / 6,
        (2 * np.sin(np.pi / 10)) ** 6 / 20,
    )  # of a sine with ten samples per period
    assert np.abs(unresolved_input(np.sin(2 * np.pi * time))).max() == pytest.approx(
        np.sqrt(0.15) * four * (six / four) ** 2, rel=0.1
    )
