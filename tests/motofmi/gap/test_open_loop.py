"""Simulation of a fit over whole recordings, and the refit to its error: a hardening spring, and an overflowing tank.

The recordings are simulated by scipy's `solve_ivp`.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fmus import Component, input, parameter, state
from fmus.effects.state_rate import Overflow
from fmus.effects.stiffness import CubicHardening
from fmus.mechanisms import MassSpringDamper
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.validation.open_loop import open_loop, refitted_in_open_loop
from motofmi.recordings.recording import Recording

TRUE = {"mass": 1.0, "spring_stiffness": 40.0, "spring_damping": 0.6, "hardening_stiffness.cubic_stiffness": 25.0}
NOISE, OFFSET, LIMIT, WINDOW = 2e-3, 0.05, 0.9, 50
EXPERIMENT = input_output_experiment(MassSpringDamper(), ["force", "displacement"]).with_sensor_offsets({"force": 1.0})


def oscillator_run(seed: int, limit: float = np.inf) -> Recording:
    """60 s at 25 Hz under five sines, read by a sensor with an offset, white noise and a limit."""
    time, force, displacement = motion(seed)
    noise = NOISE * np.random.default_rng([seed, 1]).standard_normal(len(time))
    seen = np.minimum(displacement + OFFSET + noise, limit)
    return Recording("run", time, {"force": force, "displacement": seen}, {"force": "N", "displacement": "m"})


@cache
def motion(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time, force and displacement (n,)."""
    rng, time = np.random.default_rng(seed), np.arange(1500) / 25
    frequency, phase = 0.3 + 0.4 * np.arange(5) + 0.1 * rng.random(5), 2 * np.pi * rng.random(5)
    m, k, c, k3 = TRUE.values()

    def force(t):
        return 8.0 * np.sin(2 * np.pi * np.multiply.outer(t, frequency) + phase).sum(axis=-1)

    made = solve_ivp(lambda t, x: [x[1], (force(t) - k * x[0] - c * x[1] - k3 * x[0] ** 3) / m], (0, 60), [0.3, 0.0],
                     "DOP853", t_eval=time, rtol=1e-8, atol=1e-8)  # fmt: skip
    return time, force(time), made.y[0]


def found(recording: Recording, **values: float) -> Fit:
    """A fit over segments with some values that are wrong."""
    model = FreeInitialStateModel(EXPERIMENT).with_added_effects(CubicHardening)
    run = prepare_sampled_run(recording, EXPERIMENT)
    return fit(model, [run], model.start(TRUE | values), iterations=0)


def values(made) -> dict[str, float]:
    return {name: value for name, value in made.model.values(made.q).items() if name in TRUE}


def rms(made, recording: Recording, output: str = "displacement") -> float:
    left = made.simulated(recording)[:, 0] - recording[output]
    return float(np.sqrt(np.mean(left[WINDOW:] ** 2)))


@pytest.mark.slow
def test_the_true_model_predicts_another_run_within_its_noise_and_with_its_offset():
    made = open_loop(found(oscillator_run(1)), [prepare_sampled_run(oscillator_run(1), EXPERIMENT)], WINDOW)
    # 1,500 samples of noise give the offset with a standard error of NOISE / 39.
    assert made.offset[0] == pytest.approx(OFFSET, abs=4 * NOISE / 39)
    # The initial states rest on 50 samples, and the simulation follows them until they have decayed (3 s).
    assert rms(made, oscillator_run(2)) < 1.1 * NOISE
    # Three of the base, the offset of the force, the cubic stiffness, the offset of the sensor.
    assert made.fitted_numbers == 6


@pytest.mark.slow
@pytest.mark.parametrize("limit", [np.inf, LIMIT])
def test_a_refit_to_the_simulation_error_comes_from_wrong_values_to_the_true_ones(limit):
    run = oscillator_run(1, limit)
    assert np.isinf(limit) or np.mean(run["displacement"] == limit) > 0.02
    wrong = open_loop(
        found(run, spring_stiffness=42.0, spring_damping=0.8), [prepare_sampled_run(run, EXPERIMENT)], WINDOW
    )
    made = refitted_in_open_loop(wrong, [prepare_sampled_run(run, EXPERIMENT)])
    assert rms(made, oscillator_run(2, limit)) < 1.1 * NOISE < 0.1 * rms(wrong, oscillator_run(2, limit))
    for name, value in values(made).items():
        assert value == pytest.approx(TRUE[name], rel=5e-3), name
    assert made.limits[1, 0] == limit and made.limits[0, 0] == -np.inf


class Tank(Component):
    """A tank that a pump fills and that empties itself."""

    gain = parameter("1/s", "Rise of the level per voltage", min=0, start=0.2)
    outflow = parameter("V/s", "Fall of the level at 1 V", min=0, start=0.24)
    pump = input("V", "Voltage of the pump")
    level = state("V", "Level", start=3.0, exposed=True)

    def equations(self, v, m):
        root = m.sqrt(m.where(v.level > 1e-6, v.level, 1e-6 + 0 * v.level))
        return {"der(level)": v.gain * v.pump - v.outflow * root}


class TankOverflow(Overflow):
    """The overflow of the tank."""

    element = "level"


TANK = input_output_experiment(Tank(), ["pump", "level"])
FULL = {"gain": 0.2, "outflow": 0.24, "overflow.rate": 40.0, "overflow.threshold": 5.0}
HOLD = 4  # samples for which the pump's voltage is held
LEVEL_NOISE = 0.01


@cache
def tank_run(seed: int) -> Recording:
    """400 samples of a tank that overflows at FULL's threshold, under a pump whose voltage is held."""
    rng, time = np.random.default_rng(seed), 1.0 * np.arange(400)
    pump = np.repeat(1.0 + 3.5 * rng.random(len(time) // HOLD), HOLD)
    gain, outflow, rate, threshold = FULL.values()

    def change(_, x, voltage):
        return gain * voltage - outflow * np.sqrt(x) - rate * np.maximum(x - threshold, 0.0)

    level = [3.0]
    for voltage in pump[:-1]:
        made = solve_ivp(change, (0, 1), level[-1:], "LSODA", args=(voltage,), rtol=1e-8, atol=1e-8)
        level.append(made.y[0, -1])
    seen = np.array(level) + LEVEL_NOISE * rng.standard_normal(len(time))
    return Recording("run", time, {"pump": pump, "level": seen}, {"pump": "V", "level": "V"})


def tank(**values: float):
    """The open-loop simulation of the tank with some values of FULL replaced, and the prepared run."""
    model, run = FreeInitialStateModel(TANK).with_added_effects(TankOverflow), prepare_sampled_run(tank_run(1), TANK)
    made = open_loop(fit(model, [run], model.start(FULL | values), iterations=0), [run], WINDOW)
    return made, run


def test_the_error_of_the_same_values_does_not_depend_on_the_trial_before():
    made, run = tank(**{"overflow.rate": 160.0})
    run, afresh = made.prepared(run), made.prepared(run)
    threshold = made.model.names.index("overflow.threshold")
    for before in (3.0, 8.0):
        q = made.q.copy()
        q[threshold] = before
        replace(made, q=q).error(run)
        # The steps of Newton's method end at 1e-6 of the level (4 V), and change it by no more.
        assert made.error(run) == pytest.approx(made.error(afresh), abs=1e-5)


def test_a_refit_finds_the_threshold_of_a_fast_overflow_and_that_the_input_is_held():
    made, run = tank(gain=0.22, outflow=0.25, **{"overflow.threshold": 4.4})
    refitted = refitted_in_open_loop(made, [run])
    assert refitted.interpolation == "held" != made.interpolation
    # Eight steps per sample of 1 s: a faster overflow is not distinguishable.
    assert refitted.q[made.model.names.index("overflow.rate")] == pytest.approx(8.0, rel=1e-3)
    # The overflow is faster than a sample by 40: the level stays at the threshold within 0.7 / 8 V (the most that the
    # pump brings in the time to which its rate is bounded, a step of an eighth of a sample).
    threshold = refitted.q[made.model.names.index("overflow.threshold")] + refitted.offset[0]
    assert threshold == pytest.approx(FULL["overflow.threshold"], abs=0.7 / 8)
    # The jumps of a held input are at a sample in the solver of the run, and in the step before it in the simulation.
    assert rms(refitted, tank_run(2), "level") < 3 * LEVEL_NOISE < 0.2 * rms(made, tank_run(2), "level")
