"""A pendulum that goes over the top; its base is linear.

    J q'' = u - k sin q - c q'

A motor drives it (by SciPy, u held between the samples) through more than a hundred radians, so that the stiffness of a
linear base vanishes. Or it is moved by hand to 4.6 rad, so that the stiffness of a linear base is negative.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import motofmi as mf
from fmus.effects.stiffness import GeometricNonlinearity
from fmus.mechanisms import Pendulum
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.base_fit import fitted_base
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run, sampled_run
from motofmi.recordings.recording import Recording

INERTIA, STIFFNESS, DAMPING = 0.2, 5.0, 0.1
RATE, NOISE = 100, 1e-3
UNITS = {"torque": "N.m", "angle": "rad"}


def driven(seed: int, seconds: float = 20.0) -> Recording:
    """A run under steps of torque between 0.3 and 1.5 s long, with angles about zero up to a hundred radians."""
    generator, time = np.random.default_rng(seed), np.arange(int(RATE * seconds)) / RATE
    torque = np.zeros(len(time))
    begin = 0
    while begin < len(time):
        length = int(generator.integers(30, 150))
        torque[begin : begin + length] = 1.3 * STIFFNESS * generator.uniform(-1, 1)
        begin += length

    def rates(t, x):
        u = torque[min(int(t * RATE + 1e-9), len(torque) - 1)]
        return [x[1], (u - STIFFNESS * np.sin(x[0]) - DAMPING * x[1]) / INERTIA]

    found = solve_ivp(rates, (0, time[-1]), [0.1, 0.0], t_eval=time, max_step=0.5 / RATE, rtol=1e-8, atol=1e-10)
    angle = found.y[0] + NOISE * generator.standard_normal(len(time))
    return Recording(f"driven {seed}", time, {"torque": torque, "angle": angle}, UNITS)


@pytest.fixture(scope="module")
def based():
    experiment = input_output_experiment(Pendulum(), ["torque", "angle"])
    return fitted_base(experiment, [prepare_sampled_run(driven(21), experiment)], {}, (), Criteria())


def test_the_equation_error_of_the_sine_is_the_least_and_has_its_values(based):
    base, starts = based.fit, based.starts
    assert np.ptp(driven(21)["angle"]) > 50.0
    first, second = starts[:2]
    assert (first.effect.form, second.chi2 > 10 * first.chi2) == ("sine", True)
    model, x = first.on(base)
    values = model.values(x[: len(model.names)])
    # 3 %: the torque is held, and an interpolation of its samples is late by half a sample at each step
    assert values["inertia"] == pytest.approx(INERTIA, rel=0.03)
    assert values["gravity_stiffness"] == pytest.approx(STIFFNESS, rel=0.03)
    assert values["geometric_nonlinearity.share"] == pytest.approx(1.0, abs=0.01)


def test_segments_and_band_are_those_of_the_motion_over_which_the_pendulum_is_stable(based):
    base, (run,) = based.fit, based.fit.runs
    fall = np.sqrt(STIFFNESS / INERTIA)  # 1/s, the growth about the upper equilibrium
    # ln(20) / fall is the time in which a motion grows by a factor of 20
    assert min(last - first for first, last in run.segments) < 2 * np.log(20) / fall * RATE
    # Without the angle's growth, the band holds the frequency of small swings.
    assert run.reduction_band > fall / (2 * np.pi)
    assert base.count > 5 * len(run.segments) * len(base.model.component.states)


def test_a_free_swing_has_no_equation_error(based):
    experiment = input_output_experiment(Pendulum(), ["angle"])
    time = np.arange(600) / RATE
    angle = np.exp(-0.1 * time) * np.cos(5 * time)
    free = Recording("free", time, {"angle": angle + NOISE * np.random.default_rng(1).standard_normal(600)}, UNITS)
    assert fitted_base(experiment, [prepare_sampled_run(free, experiment)], {}, (), Criteria()).starts == []


def imposed(first: float, last: float, seconds: float, seed: int) -> Recording:
    """A slow motion between two angles [rad], to and fro, and the torque of the weight; the sensor has small noise."""
    time = np.arange(int(RATE * seconds)) / RATE
    frequency = 2 * np.pi / 10.0  # 1/s: one way takes 5 s
    middle, amplitude = (first + last) / 2, (last - first) / 2
    angle = middle - amplitude * np.cos(frequency * time)
    rate, acceleration = amplitude * frequency * np.sin(frequency * time), (middle - angle) * frequency**2
    torque = INERTIA * acceleration + DAMPING * rate + STIFFNESS * np.sin(angle)
    torque += 1e-3 * STIFFNESS * np.random.default_rng(seed).standard_normal(len(time))
    return Recording(f"imposed {seed}", time, {"torque": torque, "angle": angle}, UNITS)


def test_the_sine_is_named_where_the_stiffness_of_the_base_has_the_other_sign():
    """On average over the angles the torque falls with the angle; the sine needs a positive stiffness."""
    run = imposed(0.0, 4.6, 40.0, 1)
    assert np.polyfit(run["angle"], run["torque"], 1)[0] < -0.1 * STIFFNESS
    found = mf.find_gap([run], validation=[imposed(0.3, 4.3, 40.0, 2)], component="pendulum", impose="angle")
    assert found.verdict == "named" and [e["name"] for e in found.effects] == ["geometric_nonlinearity"]
    assert found.effects[0]["parameters"]["share"]["value"] == pytest.approx(1.0, abs=0.01)  # noise of 1e-3
    assert found.to_dict()["base"]["gravity_stiffness"]["value"] == pytest.approx(STIFFNESS, rel=0.01)


@pytest.mark.parametrize(("sine", "offset"), [(True, 0.0), (False, 2 * np.pi)])
def test_whole_revolutions_are_no_offset_of_an_angle_with_the_sine_of_a_pendulum(sine, offset):
    """A small swing about 2 pi rad; the model starts beside zero, and its offset is free."""
    experiment = input_output_experiment(Pendulum(), ["angle"])
    time = np.arange(600) / RATE
    swing = 0.1 * np.exp(-0.25 * time) * np.cos(5 * time)
    run = sampled_run(Recording("swing", time, {"angle": 2 * np.pi + swing}, UNITS), experiment)
    model = FreeInitialStateModel(experiment, [GeometricNonlinearity] if sine else [])
    start = np.concatenate([np.log([INERTIA, DAMPING, STIFFNESS]), np.ones(len(model.names) - 3)])  # the whole sine
    run.guess.update({0: {"initial": {"angle": 0.1, "rate": 0.0}, "misfit": np.inf}})
    assert model.offsets_of_outputs(run, start) == pytest.approx([offset], abs=1e-3)  # the swing ends at 0.02 rad


@pytest.mark.slow
@pytest.mark.study
@pytest.mark.parametrize("seed", [21, 31])
def test_the_sine_is_named(seed):
    found = mf.find_gap([driven(seed)], validation=[driven(seed + 1)], component="pendulum")
    assert found.verdict == "named" and found.effects[0]["name"] == "geometric_nonlinearity"
    share = found.effects[0]["parameters"]["share"]
    assert share["value"] == pytest.approx(1.0, abs=0.01)


@pytest.mark.slow
@pytest.mark.study
def test_the_sine_is_named_where_it_cannot_be_simulated_over_the_segments_of_the_base():
    """Friction that lags, over longer segments, explains the run within noise that a flexible model estimates."""
    found = mf.find_gap([driven(61, 80.0)], validation=[driven(62, 40.0)], component="pendulum")
    assert found.verdict == "named" and found.effects[0]["name"] == "geometric_nonlinearity"
    assert found.effects[0]["parameters"]["share"]["value"] == pytest.approx(1.0, abs=0.01)


def swing(name: str, released: float, about: float) -> Recording:
    """10 s of a free swing whose angle is counted from another direction than that of the equilibrium."""
    def rates(_, x):
        return [x[1], (-STIFFNESS * np.sin(x[0]) - 0.3 * DAMPING * x[1]) / INERTIA]

    time = np.arange(1000) / RATE
    found = solve_ivp(rates, (0, time[-1]), [released, 0.0], t_eval=time, rtol=1e-9, atol=1e-11)
    noise = NOISE * np.random.default_rng(len(name)).standard_normal(len(time))
    return Recording(name, time, {"angle": about + found.y[0] + noise}, {"angle": "rad"})


@pytest.mark.parametrize("about", [np.pi, -np.pi])
def test_a_swing_is_counted_from_its_equilibrium(about):
    """Counted from the top: the sine fits from there only, and the equilibrium of the linear base is anywhere."""
    runs = [swing("fitted", 1.6, about), swing("validation", 0.6, about)]
    found = mf.find_gap(runs[:1], validation=runs[1:], component="pendulum")
    (effect,) = found.effects
    share = effect["parameters"]["share"]
    assert (found.verdict, effect["form"]) == ("named", "sine")
    assert share["value"] == pytest.approx(1.0, abs=4 * share["standard_error"])
    (note,) = [each for each in found.limitations if "oscillates about" in each and "fitted" in each]
    assert "without an input" in note


def test_a_swing_about_zero_and_a_driven_angle_keep_their_values():
    experiment = input_output_experiment(Pendulum(), ["angle"])
    free = prepare_sampled_run(swing("about zero", 1.0, 0.2), experiment)
    assert free.measured[:, 0] == pytest.approx(swing("about zero", 1.0, 0.2)["angle"])
    held, both = swing("held", 0.5, np.pi), input_output_experiment(Pendulum(), ["torque", "angle"])
    columns = {**held.columns, "torque": np.sin(held.time)}
    run = prepare_sampled_run(Recording("held", held.time, columns, UNITS), both)
    assert run.measured[:, 0] == pytest.approx(held["angle"])
