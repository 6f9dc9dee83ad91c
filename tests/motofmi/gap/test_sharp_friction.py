"""Dry friction whose transition is a fifth of that of the search, in a motion that changes its direction within a sample.

    q'' + 2 z q' + q = u - F tanh(q' / s),   2 z = 0.1, F = 0.5, s = 0.01

in the time in which the mass has the natural frequency 1, integrated with an explicit Runge-Kutta method of order 5(4).
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import motofmi as mf
from fmus.effects.damping import CoulombFriction, SoftFriction, StribeckFriction
from fmus.mechanisms.mass_spring_damper import MassSpringDamper
from motofmi.gap.estimation.fit_result import parameters_of_effect
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.selection.any_component import investigate
from motofmi.recordings.recording import Recording
from tests.few_laws import only_families

STIFFNESS, FREQUENCY, LENGTH = 1e4, 5.0, 0.01  # N/m, Hz, and the unit of the displacement [m]


def record(seed: int, samples: int = 2000, per_period: int = 40) -> Recording:
    """A mass under a multisine of 0.1 to 2.5 natural frequencies, with sensor noise of 0.1 %."""
    rng, step = np.random.default_rng(seed), 2 * np.pi / per_period
    lines, phases = np.linspace(0.1, 2.5, 60), rng.uniform(0, 2 * np.pi, 60)

    def force(t):
        return 2 * np.cos(np.outer(np.atleast_1d(t), lines) + phases).sum(1) / np.sqrt(30)

    def rates(t, x):
        return [x[1], force(t)[0] - x[0] - 0.1 * x[1] - 0.5 * np.tanh(x[1] / 0.01)]

    time = np.arange(samples) * step
    found = solve_ivp(rates, (0, time[-1]), [0, 0], t_eval=time, rtol=1e-8, atol=1e-9, max_step=step / 4).y[0]
    noisy = found + 1e-3 * found.std() * rng.standard_normal(samples)
    columns = {"force": STIFFNESS * LENGTH * force(time), "displacement": LENGTH * noisy}
    units = {"force": "N", "displacement": "m"}
    return Recording(f"run_{seed}", time / (2 * np.pi * FREQUENCY), columns, units)


@pytest.mark.slow
def test_sharp_friction_has_its_value_and_no_excess_near_standstill():
    """In too long steps, and in a wide transition, a Stribeck curve or another interpolation of the force fit better."""
    experiment = input_output_experiment(MassSpringDamper(), ["force", "displacement"])
    found = investigate(
        experiment,
        [prepare_sampled_run(record(7), experiment)],
        validation=[record(107)],
        library=[CoulombFriction, SoftFriction, StribeckFriction],
    ).verdict
    assert [c.effect.form for c in found.effects] == ["coulomb"]
    value, error = parameters_of_effect(found.best, found.best.model.effects[0])["friction_torque"][:2]
    assert abs(value - 0.5 * STIFFNESS * LENGTH) < 2 * error < 0.005 * value


def swing(seed: int, amplitude: float) -> Recording:
    """A pendulum that is released at an angle [rad], with sharp friction and drag, sampled 25 times per period."""
    stiffness, inertia, damping, friction, drag = 4.0, 0.1, 0.002, 0.006, 0.003

    def rates(t, x):
        torque = stiffness * x[0] + damping * x[1] + friction * np.tanh(x[1] / 0.002) + drag * abs(x[1]) * x[1]
        return [x[1], -torque / inertia]

    step = 2 * np.pi * np.sqrt(inertia / stiffness) / 25
    time = np.arange(900) * step
    found = solve_ivp(rates, (0, time[-1]), [amplitude, 0], t_eval=time, rtol=1e-8, atol=1e-9, max_step=step / 6).y[0]
    noisy = found + 6e-4 * amplitude * np.random.default_rng(seed).standard_normal(len(time))
    return Recording(f"swing_{seed}", time, {"angle": noisy}, {"angle": "rad"})


@pytest.mark.slow
def test_friction_and_drag_of_a_swing_have_their_values(monkeypatch):
    """A pair is narrowed too: in a wide transition a Stribeck curve alone was named, with a third of the friction."""
    only_families(monkeypatch, ("coulomb_friction", "progressive_damping", "extra_mode"))
    found = mf.find_gap([swing(7, 0.3), swing(8, 0.2)], validation=swing(9, 0.25), component=mf.mechanism("pendulum"))
    values = {e["name"]: next(iter(e["parameters"].values())) for e in found.effects}
    assert [e["form"] for e in found.effects] == ["coulomb", "quadratic"]
    assert values["coulomb_friction"]["value"] == pytest.approx(0.006, rel=0.005)
    assert values["progressive_damping"]["value"] == pytest.approx(0.003, rel=0.01)
