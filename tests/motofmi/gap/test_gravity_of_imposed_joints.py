"""Joints of a robot arm whose angle is imposed and counted from anywhere, as in joint-wise tests of industrial robots.

    T = J q'' + d q' + F tanh(q' / v) + G cos(q + p)
"""

import numpy as np
import pytest

import motofmi as mf
from fmus.mechanisms import DrivenJoint
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.base_fit import fitted_base
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.recordings.recording import Recording
from tests.few_laws import FAMILIES, only_families

INERTIA, DAMPING, FRICTION, SLIDING = 0.3, 1.2, 2.6, 0.005
GRAVITY, PHASE, MIDDLE, REACH = 3.5, 0.3, -2.6, 1.5
RATE = 100


def joint(seed: int, gravity: float = GRAVITY) -> Recording:
    """60 s of a slow multisine of the angle about its middle."""
    random, time = np.random.default_rng(seed), np.arange(60 * RATE) / RATE
    turns = 2 * np.pi * np.array([3, 5, 8, 13]) / 60
    sizes, phases = random.uniform(0.5, 1.0, 4), random.uniform(0, 2 * np.pi, 4)
    sizes *= REACH / sizes.sum()
    waves = np.exp(1j * (np.outer(time, turns) + phases)) * sizes
    angle, rate, acceleration = (np.real(waves @ (1j * turns) ** order) for order in range(3))
    angle = MIDDLE + angle
    torque = INERTIA * acceleration + DAMPING * rate + FRICTION * np.tanh(rate / SLIDING)
    torque += gravity * np.cos(angle + PHASE) + 0.1 * random.standard_normal(len(time))
    columns = {"torque": torque, "angle": angle + 1e-5 * random.standard_normal(len(time))}
    return Recording(f"joint_{seed}", time, columns, {"torque": "N.m", "angle": "rad"})


def test_gravity_is_named_from_a_vertical_that_is_not_known(monkeypatch):
    only_families(monkeypatch, (*FAMILIES, "geometric_nonlinearity", "backlash", "sensor_nonlinearity"))
    found = mf.find_gap(joint(1), validation=joint(2), component="driven_joint", impose="angle")
    assert found.verdict == "named" and {e["name"] for e in found.effects} == {"geometric_nonlinearity", "coulomb_friction"}
    parameters = {n: p for e in found.effects for n, p in e["parameters"].items()}
    friction = parameters["friction_torque"]
    # 2 %: the transition through zero rate is that of the fitted form
    assert friction["value"] == pytest.approx(FRICTION, abs=4 * friction["standard_error"] + 0.02 * FRICTION)
    # The part with the sine, of 1 N.m about this middle, takes the place of a stiffness and is not determined.
    cosine = parameters["cosine_torque"]
    assert cosine["value"] == pytest.approx(GRAVITY * np.cos(PHASE), abs=4 * cosine["standard_error"])


@pytest.mark.parametrize(("swing", "candidate"), [(1.4, False), (1.7, True)])
def test_less_than_a_quarter_of_a_revolution_does_not_show_the_vertical(swing, candidate):
    run = joint(1)
    angle = (run["angle"] - MIDDLE) * swing / np.ptp(run["angle"])
    recording = Recording("joint", run.time, {**run.columns, "angle": angle}, dict(run.units))
    experiment = input_output_experiment(DrivenJoint(), ["torque", "angle"], "angle")
    base = fitted_base(experiment, [prepare_sampled_run(recording, experiment)], {}, (), Criteria())
    assert ("turned" in [effect.form for effect in base.candidates]) == candidate
