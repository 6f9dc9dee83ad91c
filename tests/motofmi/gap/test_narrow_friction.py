"""Dry friction with a transition through zero rate that no sample resolves: forms of it with a width of their own."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fmus.effects.damping import CoulombFriction
from fmus.effects.hysteresis import SharpenedHysteresis
from fmus.mechanisms import MassSpringDamper
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.base_fit import fitted_base
from motofmi.gap.estimation.effect_fit import best_portable_fit, candidate_of
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.screening import screen
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.collocation import Motion, inner_times
from motofmi.gap.models.equations import Equations
from motofmi.gap.models.newton_method import CONVERGED
from motofmi.gap.models.simulation import simulate
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.recordings.recording import Recording

FRICTION, MASS, DAMPING, STIFFNESS = 2.0, 1.0, 2.0, 400.0  # N, kg, N.s/m, N/m: near the values that ship
NARROW = 1e-5  # m/s, of rates up to 0.4 m/s


def driven(imposed: bool) -> Recording:
    """4 s at 250 Hz: a displacement of two sines with the exact force, or a force with the simulated displacement."""
    time = np.arange(1000) / 250
    noise = np.random.default_rng(5).standard_normal(len(time))
    units = {"force": "N", "displacement": "m"}
    if imposed:
        angles = [(0.02, 2 * np.pi * 1.1), (0.01, 2 * np.pi * 3.7)]
        x, v, a = (sum(f(s, w) for s, w in angles) for f in (
            lambda s, w: s * np.sin(w * time), lambda s, w: s * w * np.cos(w * time), lambda s, w: -s * w**2 * np.sin(w * time)))  # fmt: skip
        force = MASS * a + DAMPING * v + STIFFNESS * x + FRICTION * np.tanh(v / NARROW)
        return Recording("imposed", time, {"force": force + 1e-2 * noise, "displacement": x}, units)
    force = 8 * np.sin(2 * np.pi * 2.3 * time) + 5 * np.sin(2 * np.pi * 4.1 * time)

    def rates(t, s):
        drive = np.interp(t, time, force)
        return [s[1], (drive - DAMPING * s[1] - STIFFNESS * s[0] - FRICTION * np.tanh(s[1] / NARROW)) / MASS]

    found = solve_ivp(rates, (0, time[-1]), [0.0, 0.0], "LSODA", time, rtol=1e-8, atol=1e-10, max_step=0.004)
    return Recording("driven", time, {"force": force, "displacement": found.y[0] + 1e-6 * noise}, units)


@pytest.mark.parametrize("imposed", [True, False], ids=["imposed", "driven"])
def test_a_transition_that_no_sample_resolves_is_the_coulomb_form(imposed):
    """Forms with a width of their own contain the Coulomb form, so that they leave no more than it does."""
    experiment = input_output_experiment(MassSpringDamper(), ["force", "displacement"], "displacement" if imposed else "")
    based = fitted_base(experiment, [prepare_sampled_run(driven(imposed), experiment)], {}, (), Criteria())
    base = based.fit
    forms = [e for e in based.candidates if e.family == "coulomb_friction" and e.form in ("coulomb", "soft", "stribeck")]
    found = {}
    for signature in screen(base, forms, keep=1):
        fitted = best_portable_fit(base, signature, np.inf, [], Criteria())
        found[signature.effect.form] = candidate_of(base, signature, fitted).fit
    values = {form: each.model.values(each.shared) for form, each in found.items()}
    sliding = base.model.experiment.sliding_rate
    assert values["coulomb"]["coulomb_friction.friction_torque"] == pytest.approx(FRICTION, rel=0.02)
    assert values["soft"]["coulomb_friction.sliding_rate"] >= sliding * (1 - 1e-9)
    assert values["stribeck"]["coulomb_friction.stribeck_rate"] >= 2 * sliding * (1 - 1e-9)
    # one per cent: the fits end where a step gains less
    assert found["soft"].chi2 < 1.01 * found["coulomb"].chi2


def test_a_form_is_first_fitted_from_the_values_of_another_form_of_its_family(monkeypatch):
    """The screened start of a friction torque is the linear estimate, that of the second form the fitted value."""
    experiment = input_output_experiment(MassSpringDamper(), ["force", "displacement"])
    based = fitted_base(experiment, [prepare_sampled_run(driven(False), experiment)], {}, (), Criteria())
    base = based.fit
    forms = {e.form: e for e in based.candidates if e.family == "coulomb_friction"}
    (coulomb,), (soft,) = (screen(base, [forms[form]], keep=1) for form in ("coulomb", "soft"))
    fitted = best_portable_fit(base, coulomb, np.inf, [], Criteria())
    known, starts = candidate_of(base, coulomb, fitted).fit, []

    def recorded(model, runs, start, **options):
        starts.append(model.values(start)["coulomb_friction.friction_torque"])
        return fit(model, runs, start, **options)

    monkeypatch.setattr("motofmi.gap.estimation.effect_fit.fit", recorded)
    best_portable_fit(base, soft, np.inf, [known], Criteria())
    assert starts[0] == known.model.values(known.shared)["coulomb_friction.friction_torque"]


def simulated_from(exact, shares, mass, time, push):
    """The states (n, nx) of a mass that is pushed, from rest, which are the same from guesses that are shares of the exact
    ones."""
    motion = Motion(time, {"force": push(time)}, {"force": push(inner_times(time))})
    equations, begin = Equations(mass, ["displacement"], []), np.zeros(exact.shape[1])
    first, *others = (
        simulate(equations, mass.start_values(), motion, share * exact, begin).states for share in shares
    )
    for found in others:  # within the accuracy of Newton's method
        assert np.all((found - first).std(axis=0) < CONVERGED * exact.std(axis=0))
    return first


def test_a_mass_that_sticks_within_a_step_is_simulated():
    """h F / (m s_0) = 40: at every turn the corrections of a step alternate between the two signs of the rate.

    Solved alone, these steps converge, so that all guesses give the same trajectory. 1 % are the phase errors of 14 turns
    that lie within a step of 4 ms.
    """
    friction = {"coulomb_friction.friction_torque": 3.0, "coulomb_friction.sliding_rate": 3e-4}
    mass = MassSpringDamper().with_effects(CoulombFriction())
    mass = mass.with_values(mass=1.0, spring_stiffness=0.0, spring_damping=2.0, **friction)
    time = np.arange(2500) * 4e-3

    def push(t):
        return 8.0 * np.sin(2 * np.pi * 0.7 * t) + 4.8 * np.sin(2 * np.pi * 1.9 * t)

    def rates(t, x):
        return [x[1], push(t) - 2.0 * x[1] - 3.0 * np.tanh(x[1] / 3e-4)]

    exact = solve_ivp(rates, (0, time[-1]), [0.0, 0.0], "LSODA", time, rtol=1e-9, atol=1e-12, max_step=2e-3).y.T
    found = simulated_from(exact, (0.5, *np.linspace(0.9, 1.1, 21), 2.0), mass, time, push)
    assert np.all((found - exact).std(axis=0) < 0.01 * exact.std(axis=0))


@pytest.mark.parametrize("sharpness", [2.0, 8.0])
def test_a_sharp_loop_of_hysteresis_is_simulated_from_several_guesses(sharpness):
    """A mass on a spring with the loop of Bouc and Wen, w z' = v (1 - |z|^n (1 + sgn(v z)) / 2)."""
    force, width, stiffness = 30.0, 0.01, 400.0
    mass = MassSpringDamper().with_effects(SharpenedHysteresis())
    mass = mass.with_values(mass=1.0, spring_stiffness=stiffness, spring_damping=2.0, **{
        "hysteresis.force": force, "hysteresis.width": width, "hysteresis.sharpness": sharpness})  # fmt: skip
    time = np.arange(2500) * 4e-3

    def push(t):
        return 60.0 * np.sin(2 * np.pi * 0.7 * t) + 40.0 * np.sin(2 * np.pi * 1.9 * t)

    def rates(t, s):
        x, v, z = s
        loop = v * (1 - abs(z) ** sharpness * (1 + np.sign(v * z)) / 2) / width
        return [v, push(t) - 2.0 * v - stiffness * x - force * z, loop]

    exact = solve_ivp(rates, (0, time[-1]), np.zeros(3), "LSODA", time, rtol=1e-9, atol=1e-12, max_step=1e-3).y.T
    found = simulated_from(exact, (0.9, 1.0, 1.3), mass, time, push)
    # 1e-3: the slope of the loop changes abruptly at every reversal, which lies within a step of 4 ms
    assert np.all((found - exact).std(axis=0) < 1e-3 * exact.std(axis=0))
