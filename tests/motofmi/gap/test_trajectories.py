"""Trajectories of the gap workflow, and their slopes, against SciPy and differences."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fmus import Component, input, output, parameter, state
from fmus.support.errors import InputError
from motofmi.gap.models import simulation
from motofmi.gap.models.collocation import Motion
from motofmi.gap.models.equations import Equations
from motofmi.gap.models.simulation import simulate, simulate_by_continuation
from motofmi.gap.models.time_varying_matrices import CACHED, carried, chain, inverse, product


class Duffing(Component):
    """A mass on a spring that hardens, pushed."""

    stiffness = parameter("N/m", "Stiffness", start=40.0)
    hardening = parameter("N/m3", "Hardening", start=30.0)
    damping = parameter("N.s/m", "Damping", start=0.6)
    force = input("N", "Push")
    position = state("m", "Position", exposed=True)
    velocity = state("m/s", "Velocity")
    pull = output("N", "Force of the spring")

    def equations(self, v, m):
        pull = v.stiffness * v.position + v.hardening * v.position**3
        return {"der(position)": v.velocity, "der(velocity)": v.force - pull - v.damping * v.velocity, "pull": pull}


def pushed(n=1281, h=1 / 128):
    time = np.arange(n) * h
    push = lambda t: {"force": 4 * np.sin(5 * t) + 2 * np.cos(9 * t)}  # noqa: E731
    return push, Motion(time, push(time), push((time[1:] + time[:-1]) / 2))


@pytest.mark.slow
def test_a_trajectory_is_that_of_solve_ivp():
    push, motion = pushed()
    duffing = Duffing()
    made = simulate(Equations(duffing, ["position", "pull"], []), duffing.values, motion, initial=np.array([0.1, -0.2]))

    def rates(t, x):
        return [x[1], push(t)["force"] - 40 * x[0] - 30 * x[0] ** 3 - 0.6 * x[1]]

    exact = solve_ivp(rates, (0, motion.time[-1]), [0.1, -0.2], t_eval=motion.time, rtol=1e-11, atol=1e-12).y.T
    # Fourth order at 128 Hz, fastest motion about 10 rad/s: (w h)^4 / 180 per radian, grown over some sixty radians
    np.testing.assert_allclose(made.states, exact, atol=2e-5 * np.abs(exact).max())


def test_slopes_by_parameters_and_initial_states_are_those_of_differences():
    _, motion = pushed(641)
    duffing, begin = Duffing(), np.array([0.3, 0.0])
    equations = Equations(duffing, ["position", "pull"], list(duffing.values))
    made = simulate(equations, duffing.values, motion, initial=begin, with_initial=True)

    def outputs(values, start):
        return simulate(equations, values, motion, initial=start).outputs

    for i, name in enumerate(duffing.values):
        step = 1e-4 * duffing.values[name]
        up, down = (outputs({**duffing.values, name: duffing.values[name] + s}, begin) for s in (step, -step))
        # Central differences: the step's square, and the trajectory's own 1e-10
        np.testing.assert_allclose(
            made.slopes[:, :, i], (up - down) / (2 * step), atol=1e-4 * np.abs(made.slopes[:, :, i]).max()
        )
    for i in range(2):
        step = 1e-4 * np.eye(2)[i]
        difference = (outputs(duffing.values, begin + step) - outputs(duffing.values, begin - step)) / 2e-4
        np.testing.assert_allclose(made.initial_slopes[:, :, i], difference, atol=1e-4 * np.abs(difference).max())


@pytest.mark.parametrize("hardening", [0.0, 30.0])
def test_states_after_other_initial_states_are_those_of_a_simulation_to_first_order(hardening):
    _, one = pushed(641)
    motion, duffing = replace(one, begins=np.array([0, 200, 450])), Duffing()
    equations, values = Equations(duffing, ["position"], []), {**duffing.values, "hardening": hardening}
    begin, change = np.array([[0.3, 0.0], [-0.2, 1.0], [0.1, -0.5]]), np.array([0.02, -0.1])
    made = simulate(equations, values, motion, initial=begin)

    def deviation(share):
        """From a simulation of the second piece from other initial states."""
        other = begin + share * change * np.array([[0], [1], [0]])
        return made.states_after({200: share * change}) - simulate(equations, values, motion, made.states, other).states

    assert np.all(np.delete(made.states_after({200: change}) - made.states, np.arange(200, 450), axis=0) == 0)
    whole, half = (np.abs(deviation(share)).max() for share in (1.0, 0.5))
    if hardening:
        assert whole / half == pytest.approx(4, rel=0.1)  # of second order, and the third is some per cent
    else:
        assert whole < 1e-12  # linear: roundings


@pytest.mark.parametrize("faulty", [{"damping": -400.0}, {"damping": -40.0, "hardening": 0.0}])
def test_a_motion_that_runs_away_is_refused(faulty):
    _, motion = pushed()
    duffing = Duffing()
    with pytest.raises(InputError, match="diverges"):
        simulate(
            Equations(duffing, ["position"], []), {**duffing.values, **faulty}, motion, initial=np.array([1.0, 0.0])
        )


def test_slopes_that_run_away_where_the_motion_does_not_yet_are_refused(monkeypatch):
    _, motion = pushed()
    duffing = Duffing()
    made = simulate(
        Equations(duffing, ["position"], ["damping"]), {**duffing.values, "damping": -2.0, "hardening": 0.0}, motion
    )
    monkeypatch.setattr("motofmi.gap.models.collocation.LARGEST", 1.5 * np.abs(made.outputs).max())
    with pytest.raises(InputError, match="diverges"):
        made.slopes  # noqa: B018


@pytest.mark.parametrize("count", [1, 2, CACHED - 1, CACHED, CACHED + 1, CACHED + 2, 2 * CACHED + 1])
def test_a_chain_of_steps_is_their_recursion(count):
    rng = np.random.default_rng(count)
    changing, constant = rng.uniform(-0.5, 0.5, (2, count - 1)), 0.3
    forcing = rng.standard_normal((count, 2))
    states = [forcing[0]]
    for k in range(count - 1):
        states.append(np.array([[changing[0, k], 0.0], [constant, changing[1, k]]]) @ states[-1] + forcing[k + 1])
    band = chain({(0, 0): changing[0], (1, 0): constant, (1, 1): changing[1]}, 2, count)
    np.testing.assert_allclose(carried(band, forcing.copy()), states, rtol=1e-12, atol=1e-14)  # rounding


def test_matrices_over_time_are_those_of_numpy():
    rng = np.random.default_rng(0)
    dense = np.eye(3) + 0.2 * rng.standard_normal((5, 3, 3))
    dense[:, 0, 1], dense[:, 2, 0] = 0.0, 0.1
    mixed = {}
    for place in np.ndindex(3, 3):
        column = dense[(slice(None), *place)]
        mixed[place] = float(column[0]) if np.ptp(column) == 0 else column
    for ours, exact in ((product(mixed, mixed), dense @ dense), (inverse(mixed, 3), np.linalg.inv(dense))):
        for place in np.ndindex(3, 3):
            np.testing.assert_allclose(np.broadcast_to(ours.get(place, 0.0), 5), exact[(slice(None), *place)], atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("hardening, push", [(300.0, 3.0), (1000.0, 1.0), (3000.0, 1.0)])
def test_a_stiff_spring_is_reached_by_continuation_where_its_motion_is_unknown(hardening, push):
    """At 64 Hz the whole trajectory cannot be found at once; with the hardening growing to its size it is that of
    solve_ivp."""
    duffing, time = Duffing(), np.arange(2561) / 64
    force = lambda t: {"force": push * (4 * np.sin(2.5 * t + 0.05 * t**2) + 2 * np.cos(4 * t))}  # noqa: E731
    motion = Motion(time, force(time), force((time[1:] + time[:-1]) / 2))
    equations, values = Equations(duffing, ["position", "pull"], []), {**duffing.values, "hardening": hardening}
    with pytest.raises(InputError, match="diverges"):
        simulate(equations, values, motion)
    made = simulate_by_continuation(equations, values, motion, ["hardening"])
    exact = solve_ivp(lambda t, x: [x[1], force(t)["force"] - 40 * x[0] - hardening * x[0] ** 3 - 0.6 * x[1]], (0, time[-1]), [0, 0],
                      t_eval=time, rtol=1e-9, atol=1e-10).y.T  # fmt: skip
    # Fourth order: at its largest motion the stiffest of these springs swings with some 35 rad/s, (w h)^4 / 180 is 5e-4
    # per radian, most of it a phase
    np.testing.assert_allclose(made.states, exact, atol=5e-4 * np.abs(exact).max())
    with pytest.raises(InputError, match="diverges"):
        simulate_by_continuation(equations, {**values, "hardening": 1e5}, motion, ["hardening"])


def test_a_continuation_that_alternately_converges_and_diverges_ends(monkeypatch):
    """Only steps of at most 2 % of the magnitude converge: halved six times, and again after each doubling."""
    tried = []

    def converges_over_short_steps(equations, values, motion, states):
        tried.append(values["size"])
        if values["size"] - (states or 0.0) > 0.02:
            raise InputError("the simulation diverges")
        return SimpleNamespace(states=values["size"])

    monkeypatch.setattr(simulation, "simulate", converges_over_short_steps)
    with pytest.raises(InputError, match="diverges"):
        simulate_by_continuation(None, {"size": 1.0}, None, ["size"])
    assert len(tried) <= 2 * simulation.MOST_HALVINGS
