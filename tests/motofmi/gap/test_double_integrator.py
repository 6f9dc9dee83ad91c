"""The gap workflow on a mass without spring and damper, whose errors grow with the square of time."""

import numpy as np
import pytest
from scipy.integrate import quad

import motofmi as mf
from fmus import Component, input, parameter, state
from motofmi.gap.estimation.double_integrator import is_double_integrator, longest_segment
from motofmi.gap.estimation.initial_fit import initial_fit
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run_preparation import SEGMENT_PERIODS, prepare_sampled_run
from tests.simulators.ball_on_beam import GAIN, beam_run


class Beam(Component):
    """A ball on a beam at small angles."""

    gain = parameter("m/s2/rad", "Acceleration per angle", min=0, start=5.0)
    beam = input("rad", "Angle of the beam")
    position = state("m", "Position of the ball", exposed=True)
    speed = state("m/s", "Speed of the ball")

    def equations(self, v, m):
        return {"der(position)": v.speed, "der(speed)": v.gain * v.beam}


def test_dry_friction_does_not_take_the_gain_of_a_double_integrator():
    """Over 40 s as one segment the least squares reduce the gain from 7 to 0.9 m/s2."""
    experiment = input_output_experiment(Beam(), ["beam", "position"])
    run = prepare_sampled_run(beam_run("run", 40, 50, 1, friction=0.08), experiment)
    found = initial_fit(FreeInitialStateModel(experiment), [run])
    assert np.exp(found.x[0]) == pytest.approx(GAIN, rel=0.05)
    assert len(found.runs[0].segments) > len(run.segments)


def test_the_error_of_a_segment_is_that_of_an_oscillator_over_segments_of_usual_length():
    frequency, w = 0.3, 2 * np.pi * 0.3
    of_oscillator = quad(lambda t: abs(np.sin(w * t)) / w, 0, SEGMENT_PERIODS / frequency, limit=200)[0]
    assert longest_segment(frequency) ** 2 / 2 == pytest.approx(of_oscillator, rel=1e-6)


def test_what_a_double_integrator_is():
    assert is_double_integrator(np.zeros((3, 2)), 20.0)
    assert not is_double_integrator(np.array([[0.0, -2.0]]), 20.0)  # a damper
    assert not is_double_integrator(np.array([[3j, -3j]]), 20.0)  # a spring
    assert not is_double_integrator(np.array([[0.0, 0.0], [3j, -3j]]), 20.0)  # a spring at some deflections


@pytest.mark.slow
def test_the_delay_of_a_servo_is_named_and_the_length_of_segments_is_said():
    runs = [beam_run(name, 40, 50, seed, delay=0.1) for name, seed in (("fit", 1), ("held", 2))]
    found = mf.find_gap(runs[0], validation=runs[1], component=Beam())
    assert [e["name"] for e in found.effects] == ["channel_delay"]
    assert any("in segments of at most 3.83 s" in sentence for sentence in found.limitations)


@pytest.mark.study
def test_the_friction_of_a_ball_on_a_beam_is_named():
    """190 s on one core. In two segments of 20 s there were too few blocks for a name."""
    runs = [beam_run(name, 40, 50, seed, friction=0.25) for name, seed in (("fit", 1), ("held", 2))]
    found = mf.find_gap(runs[0], validation=runs[1], component=Beam())
    assert [e["name"] for e in found.effects] == ["coulomb_friction"]
    assert found.effects[0]["parameters"]["friction_torque"]["value"] == pytest.approx(0.25, rel=0.02)
