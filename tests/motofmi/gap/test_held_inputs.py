"""Voltage steps to a motor whose amplifier has a dead zone, from the exact solution between two steps:

w' = K d(u) - c w,   d(u) = sign(u) max(|u| - u_0, 0):   w = w_s + (w_0 - w_s) exp(-c t),   w_s = K d(u) / c
"""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.signal import StateSpace, dlsim, lsim

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
NATURAL = 2 * np.pi * 5  # rad/s


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
    """A joint under a smooth torque that a controller holds over each of its samples of 20 ms, with noise of 0.1 %;
    the angle is so many samples late, or early, as in a log that pairs a command with the angle that follows it."""
    random, rate = np.random.default_rng(seed), 50
    time = np.arange(2000) / rate
    torque = smooth_torque(time, random)
    _, angle, _ = dlsim(JOINT.to_discrete(1 / rate, "zoh"), np.concatenate([np.zeros(max(delay, 0)), torque])[: len(time)])
    angle = with_noise(angle[:, 0], random)
    kept = len(time) - max(-delay, 0)
    columns = {"torque": torque[:kept], "angle": angle[max(-delay, 0) :]}
    return Recording(f"run_{seed}", time[:kept], columns, {"torque": "N.m", "angle": "rad"})


def late_channel(seed: int, late: dict[str, float]) -> Recording:
    """A joint under a smooth torque, where a column is late by so many seconds behind the true signal."""
    random = np.random.default_rng(seed)
    fine = np.arange(-1000, 40000) / 1000  # s
    torque = smooth_torque(fine, random)
    _, angle, _ = lsim(JOINT, torque, fine - fine[0])
    time = np.arange(2000) / 50
    columns = {name: CubicSpline(fine, values)(time - late.get(name, 0.0))
               for name, values in {"torque": torque, "angle": angle}.items()}  # fmt: skip
    columns["angle"] = with_noise(columns["angle"], random)
    return Recording(f"run_{seed}", time, columns, {"torque": "N.m", "angle": "rad"})


def test_a_command_that_a_controller_holds_is_no_delay():
    """Between its samples it is no spline: a delay of 10 ms and a further body were named."""
    found = mf.find_gap(sampled_command(1), validation=sampled_command(2), component="driven_joint")
    assert (found.verdict, found.effects) == ("none", [])


@pytest.mark.parametrize("samples", [3, -1])
def test_a_delay_beside_a_held_command_is_that_of_the_hold_or_half_a_sample_more(samples, monkeypatch):
    """An angle that is late, or early, by whole samples. Where both interpolations fit, a limitation gives both values."""
    only_families(monkeypatch, ("channel_delay", "coulomb_friction"))
    found = mf.find_gap(sampled_command(1, samples), validation=sampled_command(2, samples), component="driven_joint")
    (effect,) = found.effects
    delay, true = effect["parameters"]["delay"]["value"], 0.02 * samples
    if abs(delay - true) > 1e-4:  # s
        assert any(f"the delay is {true:.3g} s, half a sampling interval (0.01 s) less" in each for each in found.limitations)
        delay -= 0.01
    assert delay == pytest.approx(true, abs=1e-4)


@pytest.mark.parametrize(("late", "true"), [({"angle": 0.02}, 0.02), ({"torque": 0.007}, -0.007), ({"angle": 0.004}, 0.004)])
def test_a_late_sensor_is_a_delay_by_its_own_value(late, true):
    """With a torque that is late a further body of a damping ratio of 2 was named; of an angle that is late by a sample,
    half was attributed to a hold of the torque."""
    found = mf.find_gap(late_channel(1, late), validation=late_channel(2, late), component="driven_joint")
    (effect,) = found.effects
    assert effect["name"] == "channel_delay"
    value = effect["parameters"]["delay"]
    assert value["value"] == pytest.approx(true, abs=max(4 * value["standard_error"], 2e-5))  # s, of the interpolation


def test_a_step_of_a_simulation_ends_at_the_corners_of_a_held_input():
    """With a corner within each step the error was 8e-4 of the motion."""
    experiment = input_output_experiment(mf.mechanism("driven_joint"), ["torque", "angle"])
    run = prepare_sampled_run(sampled_command(1), experiment)
    assert [run.with_interpolation(kind).steps_per_sample % 2 for kind in ("smooth", "held")] == [1, 0]


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


@pytest.mark.slow
def test_a_lag_of_the_spring_is_no_hold_of_the_force(monkeypatch):
    """A Maxwell element makes the motion lag: held inputs, half a sample late, fit the base better than smooth ones."""
    only_families(monkeypatch, ("viscoelastic_arm", "extra_mode", "channel_delay", "coulomb_friction"))
    runs = [smooth_force_on_maxwell(seed) for seed in (7, 107)]
    found = mf.find_gap(runs[0], validation=runs[1], component=mf.mechanism("mass_spring_damper"))
    (effect,) = found.effects
    assert effect["name"] == "viscoelastic_arm"
    stiffness, time = (effect["parameters"][name] for name in ("series_stiffness", "relaxation_time"))
    assert stiffness["value"] == pytest.approx(5000.0, rel=0.002)  # 1.3 standard errors
    assert time["value"] == pytest.approx(1 / NATURAL, rel=0.002)


def smooth_force_on_maxwell(seed: int) -> Recording:
    """A mass with the natural frequency of 5 Hz and a Maxwell element of half its stiffness under a multisine up to
    2.5 natural frequencies, sampled 40 times per natural period, with sensor noise of 0.1 %."""
    rng, fine = np.random.default_rng(seed), np.arange(2000 * 8) * 2 * np.pi / 320
    lines, phases = np.linspace(0.1, 2.5, 60), rng.uniform(0, 2 * np.pi, 60)
    force = 2 * np.cos(np.outer(fine, lines) + phases).sum(axis=1) / np.sqrt(30)
    # in units of the stiffness and the natural frequency: displacement, rate, force of the element
    maxwell = StateSpace([[0, 1, 0], [-1, -0.1, -1], [0, 0.5, -1]], [[0], [1], [0]], [[1, 0, 0]], [[0]])
    motion = lsim(maxwell, force, fine)[1][::8]
    noisy = motion + 1e-3 * motion.std() * rng.standard_normal(len(motion))
    columns = {"force": 1e4 * force[::8], "displacement": noisy}
    return Recording(f"run_{seed}", fine[::8] / NATURAL, columns, {"force": "N", "displacement": "m"})
