"""The gap workflow on a motor whose speed alone is a state: friction without a deflection."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import motofmi as mf
from fmus import Component, input, parameter, state
from motofmi.recordings.recording import Recording


class Motor(Component):
    """A rotor that a torque drives."""

    inertia = parameter("kg.m2", "Inertia", min=1e-9, start=1e-4)
    damping = parameter("N.m.s/rad", "Damping", min=0, start=1e-4)
    torque = input("N.m", "Torque")
    speed = state("rad/s", "Speed", exposed=True)

    def equations(self, v, m):
        return {"der(speed)": (v.torque - v.damping * v.speed) / v.inertia}


def driven(seed: int, friction: float, end: float = 20, step: float = 0.002, noise: float = 0.05) -> Recording:
    """A motor of 2e-4 kg.m2 and 1e-4 N.m.s/rad with friction [N.m] until `end` [s], by a variable-step solver.

    The samples have a distance `step` [s], the sensor of the speed a noise [rad/s].
    """
    rng, time = np.random.default_rng(seed), np.arange(0, end, step)
    frequency, phase = 2 * np.pi * np.linspace(0.1, 4, 12), rng.uniform(0, 2 * np.pi, 12)

    def torque(t):
        return 0.012 * np.sin(np.multiply.outer(t, frequency) + phase).sum(-1)

    def change(t, x):
        return [(torque(t) - 1e-4 * x[0] - friction * np.tanh(x[0] / 0.05)) / 2e-4]

    made = solve_ivp(change, (0, end), [0], t_eval=time, max_step=0.002, rtol=1e-8, atol=1e-8, method="LSODA").y[0]
    columns = {"torque": torque(time), "speed": made + noise * rng.standard_normal(len(time))}
    return Recording(f"run_{seed}", time, columns, {"torque": "N.m", "speed": "rad/s"})


@pytest.mark.slow
def test_the_friction_of_a_motor_whose_speed_alone_is_a_state_is_named():
    result = mf.find_gap([driven(1, 0.01)], validation=[driven(2, 0.01)], component=Motor())
    (effect,) = result.effects
    torque = effect["parameters"]["friction_torque"]
    assert (result.verdict, effect["name"], torque["unit"]) == ("named", "coulomb_friction", "N.m")
    # four standard errors, and 1e-3 of the value for the torque between its samples
    assert torque["value"] == pytest.approx(0.01, abs=4 * torque["standard_error"] + 1e-5)


@pytest.mark.slow
def test_nothing_is_named_where_the_motor_lacks_nothing():
    assert mf.find_gap([driven(1, 0.0)], validation=[driven(2, 0.0)], component=Motor()).verdict == "none"


@pytest.mark.slow
def test_the_interval_of_what_friction_explains_comes_from_pieces_of_time():
    """One block of 250 samples, whose misfit is in a few of its lowest coefficients and in most of its duration."""
    runs = [driven(seed, 0.004, end=3, step=0.012, noise=1.0) for seed in (1, 2)]
    result = mf.find_gap(runs[:1], validation=runs[1:], component=Motor())
    explained = result.to_dict()["explained"]
    assert [effect["name"] for effect in result.effects] == ["coulomb_friction"]
    # The friction closes all of the misfit, to the scatter of mean squares of 20 pieces.
    assert explained["share"] > 0.9 and explained["low"] > 0.7
