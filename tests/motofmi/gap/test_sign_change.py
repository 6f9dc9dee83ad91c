"""A base whose fit moves a stiffness to zero is tried with the other sign: a joint that turns away from zero.

Short runs from rest of a joint that is driven by a torque, simulated by scipy's LSODA, as a steering motor is recorded:
the stiffness is negative, and the joint drifts away from zero.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lsim

import motofmi as mf
from fmus.declaration.component import Component
from fmus.declaration.variables import input, parameter, state
from fmus.effects.damping import CoulombFriction
from fmus.mechanisms import DrivenJoint, MassSpringDamper
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.base_fit import fitted_base, fitted_values
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.frequency_domain_fit import frequency_domain_start
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.recordings.recording import Recording
from tests.simulators.hidden_mechanisms import simulate

JOINT = {"J": 0.24, "k": -0.7, "c": 0.4, "sliding": 1e-3}
UNITS = {"torque": "N.m", "angle": "rad"}


def driven(hidden: dict[str, float], frequency: float, duration: float, seed: int = 0, **values: float) -> Recording:
    """A run from rest under a harmonic torque of 1.8 N.m, 120 Hz, with the noise of a fine encoder."""
    time = np.arange(0, duration, 1 / 120)
    motion, torque = simulate({**JOINT, **values}, hidden, lambda t: 1.8 * np.cos(2 * np.pi * frequency * t), time)
    angle = motion[:, 0] + 2e-4 * np.random.default_rng(seed).standard_normal(len(time))
    return Recording(f"{frequency:g}Hz", time, {"torque": torque, "angle": angle}, UNITS)


@pytest.mark.slow
@pytest.mark.parametrize("stiffness", [-0.7, 4.0])
def test_the_stiffness_of_the_base_gets_the_sign_of_the_data(stiffness):
    recordings = [driven({}, 0.3, 2.5, 1, k=stiffness), driven({}, 1.0, 3.0, 2, k=stiffness)]
    experiment = input_output_experiment(DrivenJoint(), list(UNITS))
    experiment = replace(experiment, own_values=False)
    runs = [prepare_sampled_run(recording, experiment) for recording in recordings]
    found = fitted_values(fitted_base(experiment, runs, {}, (CoulombFriction,), Criteria()).fit)
    # The noise is 1e-4 of the motion; input and output are interpolated between 120 samples per second. The
    # stiffness is determined least: it is a small part of the torque.
    assert found["stiffness"] == pytest.approx(stiffness, rel=0.005)
    assert found["inertia"] == pytest.approx(JOINT["J"], rel=0.005)


class Amplifier(Component):
    """A gain of either sign, with a delay of first order."""

    gain = parameter("1", "Gain", min=-1000.0, max=10.0, start=-1.0)
    corner = parameter("1/s", "Corner frequency", min=0.0, max=100.0, start=3.0)
    drive = input("V", "Input")
    voltage = state("V", "Output", exposed=True)

    def equations(self, v, m):
        return {"der(voltage)": v.corner * (v.gain * v.drive - v.voltage)}


def test_the_bounds_of_a_negative_parameter_are_those_of_its_sign():
    """The gain of -50 is within its bounds of -1000 and 10."""
    time, rng = np.arange(0, 10, 0.01), np.random.default_rng(1)
    drive = np.cos(3 * time) + np.cos(7 * time + 1)
    _, voltage, _ = lsim((-50.0 * 5.0, [1.0, 5.0]), drive, time)
    columns = {"drive": drive, "voltage": voltage + 0.01 * rng.standard_normal(len(time))}
    experiment = input_output_experiment(Amplifier(), list(columns))
    run = prepare_sampled_run(Recording("driven", time, columns, dict.fromkeys(columns, "V")), experiment)
    model = FreeInitialStateModel(experiment)
    assert [list(ends) for ends in model.magnitudes] == [[0.0, 0.0], [1000.0, 100.0]]
    for start in (model.start(), frequency_domain_start(model, [run])):
        found = fit(model, [run], start)
        # The noise is 0.1 % of the output, in 1000 samples.
        assert model.values(found.shared)["gain"] == pytest.approx(-50.0, rel=1e-3)


def test_a_spring_that_cannot_be_negative_keeps_its_sign():
    assert MassSpringDamper.declared["spring_stiffness"].min == 0 and DrivenJoint.declared["stiffness"].min < 0


@pytest.mark.study
def test_friction_is_named_in_short_runs_of_a_joint_that_turns_away():
    fitted = [driven({"friction": 0.55}, f, d, i) for i, (f, d) in enumerate([(0.5, 2.4), (1.0, 2.9), (2.0, 6.0)])]
    found = mf.find_gap(fitted, validation=driven({"friction": 0.55}, 0.7, 4.0, 9), component="driven_joint")
    assert found.verdict == "named" and found.effects[0]["name"] == "coulomb_friction"
    torque = found.effects[0]["parameters"]["friction_torque"]
    assert abs(torque["value"] - 0.55) < max(3 * torque["standard_error"], 0.02)
