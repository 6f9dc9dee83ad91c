"""Voltage steps to a motor whose amplifier has a dead zone, from the exact solution between two steps:

w' = K d(u) - c w,   d(u) = sign(u) max(|u| - u_0, 0):   w = w_s + (w_0 - w_s) exp(-c t),   w_s = K d(u) / c
"""

import numpy as np
import pytest
from scipy.signal import StateSpace, dlsim

import motofmi as mf
from fmus import Component, input, parameter, state
from fmus.support.errors import InputError
from motofmi.gap.estimation import fitting
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.initial_fit import with_best_interpolation
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.recordings.recording import Recording
from tests.few_laws import only_families

GAIN, DAMPING, HALF_WIDTH = 40.0, 5.0, 0.6  # rad/V.s2, 1/s, V
HOLD, RATE = 2.0, 100.0  # s, Hz


class Motor(Component):
    """A motor by its speed."""

    gain = parameter("rad/V.s2", "Acceleration per voltage", min=0, start=30.0)
    damping = parameter("1/s", "Damping per inertia", min=0, start=3.0)
    voltage = input("V", "Voltage")
    speed = state("rad/s", "Speed", exposed=True)

    def equations(self, v, m):
        return {"der(speed)": v.gain * v.voltage - v.damping * v.speed}


def steps(name: str, levels: tuple[float, ...], half_width: float, seed: int) -> Recording:
    """Each voltage for 2 s, with noise of 0.05 rad/s on the speed."""
    after = np.arange(int(HOLD * RATE)) / RATE
    speed, parts = 0.0, []
    for level in levels:
        final = GAIN / DAMPING * np.sign(level) * max(abs(level) - half_width, 0.0)
        parts.append(final + (speed - final) * np.exp(-DAMPING * after))
        speed = final + (speed - final) * np.exp(-DAMPING * HOLD)
    noise = 0.05 * np.random.default_rng(seed).standard_normal(len(after) * len(levels))
    columns = {"voltage": np.repeat(levels, len(after)), "speed": np.concatenate(parts) + noise}
    return Recording(name, np.arange(len(noise)) / RATE, columns, {"voltage": "V", "speed": "rad/s"})


@pytest.mark.parametrize("half_width", [0.0, HALF_WIDTH])
def test_the_interpolation_of_an_input_is_chosen_with_the_effect(half_width):
    """With a dead zone the misfit of the base hides how the voltage passes between its samples: half a sample of delay
    beside friction was named."""
    runs = [
        steps(name, levels, half_width, seed)
        for seed, (name, levels) in enumerate({
            "first": (0, 2, 0, -2, 0, 4, 0, -4, 0, 1, 0, -1, 0),
            "second": (0, -3, 0, 3, 0, 1.2, 0, -1.2, 0, 5, 0, -5, 0),
            "held": (0, 2.5, 0, -2.5, 0, 4.5, 0, -4.5, 0, 1.4, 0, -1.4, 0),
        }.items())
    ]  # fmt: skip
    found = mf.find_gap(runs[:2], validation=runs[2], component=Motor())
    assert [e["name"] for e in found.effects] == ["dead_zone"] * bool(half_width)
    if half_width:
        value = found.effects[0]["parameters"]["half_width"]
        assert value["value"] == pytest.approx(half_width, abs=4 * value["standard_error"])
        assert value["standard_error"] < 0.01


def sampled_command(seed: int, delay: int = 0) -> Recording:
    """A joint under a smooth torque that a controller holds over each of its samples of 20 ms, with noise of 0.1 %."""
    inertia, damping, stiffness, rate = 0.05, 0.1, 2.0, 50
    random, time = np.random.default_rng(seed), np.arange(2000) / rate
    turns, phases = 2 * np.pi * np.linspace(0.1, 2.5, 25), random.uniform(0, 2 * np.pi, 25)
    torque = np.cos(np.outer(time, turns) + phases).sum(axis=1) / 5
    held = StateSpace([[0, 1], [-stiffness / inertia, -damping / inertia]], [[0], [1 / inertia]], [[1, 0]], [[0]])
    _, angle, _ = dlsim(held.to_discrete(1 / rate, "zoh"), np.concatenate([np.zeros(delay), torque])[: len(time)])
    angle = angle[:, 0] + 1e-3 * np.std(angle) * random.standard_normal(len(time))
    return Recording(f"run_{seed}", time, {"torque": torque, "angle": angle}, {"torque": "N.m", "angle": "rad"})


def test_a_command_that_a_controller_holds_is_no_delay():
    """Between its samples it is no spline: a delay of 10 ms and a further body were named."""
    found = mf.find_gap(sampled_command(1), validation=sampled_command(2), component="driven_joint")
    assert (found.verdict, found.effects) == ("none", [])


def test_the_part_of_a_delay_that_may_be_that_of_the_hold_is_said(monkeypatch):
    only_families(monkeypatch, ("channel_delay", "coulomb_friction"))
    found = mf.find_gap(sampled_command(1, 3), validation=sampled_command(2, 3), component="driven_joint")
    (effect,) = found.effects
    delay = effect["parameters"]["delay"]["value"]
    said = any("half a sampling interval (0.01 s) of the delay" in each for each in found.limitations)
    assert delay == pytest.approx(0.06 + 0.01 * said, abs=1e-3)  # s, three samples


def test_an_interpolation_with_which_a_model_cannot_be_simulated_is_left_out(monkeypatch):
    """Beside a hysteresis the simulation with another one diverged, and the command ended in an error."""
    run = sampled_command(1)
    experiment = input_output_experiment(mf.mechanism("driven_joint"), list(run.columns))
    model = FreeInitialStateModel(experiment)
    found = fit(model, [prepare_sampled_run(run, experiment)], model.start())

    def diverges(model, runs, x):
        raise InputError("the simulation diverges")

    monkeypatch.setattr(fitting, "fit", diverges)
    assert with_best_interpolation(model, found) is found
