"""Voltage steps to a motor whose amplifier has a dead zone, from the exact solution between two steps:

w' = K d(u) - c w,   d(u) = sign(u) max(|u| - u_0, 0):   w = w_s + (w_0 - w_s) exp(-c t),   w_s = K d(u) / c
"""


import numpy as np
import pytest
from scipy.signal import dlsim

import motofmi as mf
from fmus import Component, input, parameter, state
from fmus.support.errors import InputError
from motofmi.gap.estimation import fitting, initial_fit
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.initial_fit import in_interpolation_of, with_best_interpolation
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.selection.chi_square_conditions import unless_sufficient
from motofmi.gap.selection.result import Verdict
from motofmi.recordings.recording import Recording
from tests.few_laws import only_families
from tests.motofmi.gap.smoothly_driven_joint import JOINT, smooth_torque, with_noise

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
    random, rate = np.random.default_rng(seed), 50
    time = np.arange(2000) / rate
    torque = smooth_torque(time, random)
    _, angle, _ = dlsim(JOINT.to_discrete(1 / rate, "zoh"), np.concatenate([np.zeros(delay), torque])[: len(time)])
    angle = with_noise(angle[:, 0], random)
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


def smooth_fit() -> Fit:
    """The base fitted to a held command that is taken as smooth."""
    run = sampled_command(1)
    experiment = input_output_experiment(mf.mechanism("driven_joint"), list(run.columns))
    model = FreeInitialStateModel(experiment)
    return fit(model, [prepare_sampled_run(run, experiment)], model.start())


def test_an_interpolation_with_which_a_model_cannot_be_simulated_is_left_out(monkeypatch):
    """Beside a hysteresis the simulation with another one diverged, and the command ended in an error."""
    found = smooth_fit()

    def diverges(model, runs, x):
        raise InputError("the simulation diverges")

    monkeypatch.setattr(fitting, "fit", diverges)
    assert with_best_interpolation(found.model, found) is found


def test_the_interpolation_of_an_effect_is_left_out_where_the_base_fits_worse_with_it(monkeypatch):
    """A spline with a delay is nearly a held input: the base was fitted again with the spline, a hundred times worse."""
    smooth = smooth_fit()
    held = with_best_interpolation(smooth.model, smooth)
    monkeypatch.setattr(initial_fit, "with_best_interpolation", lambda model, found: smooth)
    assert (smooth.runs[0].kind, held.runs[0].kind) == ("smooth", "held")
    assert in_interpolation_of(smooth, held) is None


def test_a_base_within_the_tolerance_is_sufficient_where_nothing_is_named():
    """In the smooth interpolation it misses the half sample by which the command is late."""
    smooth = smooth_fit()
    held = with_best_interpolation(smooth.model, smooth)
    found = unless_sufficient(Verdict("unknown", held, held))
    assert found.verdict == "none" and "within the tolerance of 1.00%" in found.withheld
    assert unless_sufficient(Verdict("unknown", smooth, smooth)).verdict == "unknown"
