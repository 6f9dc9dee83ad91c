"""The machinery of the gap workflow: trajectories and slopes against SciPy and differences, many processes against one."""

import os
import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from benchmarks import gap_speed
from fmus import Component, input, output, parallel, parameter, state
from fmus.errors import InputError
from identification.gap.data.runs import prepare
from identification.gap.models.equations import Equations
from identification.gap.models.model import Model
from identification.gap.models.over_time import inverse, product
from identification.gap.models.simulate import Motion, led_in, simulate
from identification.gap.naming import joining, screening
from identification.gap.naming.competing import compete
from identification.gap.naming.fitting import fit
from identification.gap.naming.screening import screen, shapes_of
from scenarios.rig_test import rig_effects, rig_test

pytest.importorskip("numba", reason="the simulator of the hidden effects is compiled by numba")
from simulators.as_recordings import as_recording
from simulators.hidden_rig import RIDER, record, sweep
from simulators.rig_runs import RIG


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
        np.testing.assert_allclose(made.slopes[:, :, i], (up - down) / (2 * step), atol=1e-4 * np.abs(made.slopes[:, :, i]).max())
    for i in range(2):
        step = 1e-4 * np.eye(2)[i]
        difference = (outputs(duffing.values, begin + step) - outputs(duffing.values, begin - step)) / 2e-4
        np.testing.assert_allclose(made.initial_slopes[:, :, i], difference, atol=1e-4 * np.abs(difference).max())


@pytest.mark.parametrize("faulty", [{"damping": -400.0}, {"damping": -40.0, "hardening": 0.0}])
def test_a_motion_that_runs_away_is_refused(faulty):
    _, motion = pushed()
    duffing = Duffing()
    with pytest.raises(InputError, match="diverges"):
        simulate(Equations(duffing, ["position"], []), {**duffing.values, **faulty}, motion, initial=np.array([1.0, 0.0]))


def test_slopes_that_run_away_where_the_motion_does_not_yet_are_refused(monkeypatch):
    _, motion = pushed()
    duffing = Duffing()
    made = simulate(Equations(duffing, ["position"], ["damping"]), {**duffing.values, "damping": -2.0, "hardening": 0.0}, motion)
    monkeypatch.setattr("identification.gap.models.simulate.LARGEST", 1.5 * np.abs(made.outputs).max())
    with pytest.raises(InputError, match="diverges"):
        made.slopes  # noqa: B018


def test_matrices_over_time_are_those_of_numpy():
    rng = np.random.default_rng(0)
    dense = np.eye(3) + 0.2 * rng.standard_normal((5, 3, 3))
    dense[:, 0, 1], dense[:, 2, 0] = 0.0, 0.1
    mixed = np.zeros((3, 3)).astype(object)
    for place in np.ndindex(3, 3):
        column = dense[(slice(None), *place)]
        mixed[place] = float(column[0]) if np.ptp(column) == 0 else column
    for ours, exact in ((product(mixed, mixed), dense @ dense), (inverse(mixed), np.linalg.inv(dense))):
        for place in np.ndindex(3, 3):
            np.testing.assert_allclose(np.broadcast_to(ours[place], 5), exact[(slice(None), *place)], atol=1e-12)


@pytest.mark.parametrize("hardening, push", [(300.0, 3.0), (1000.0, 1.0), (3000.0, 1.0)])
def test_a_stiff_spring_is_led_in_where_nothing_is_known_of_its_motion(hardening, push):
    """At 64 Hz the whole trajectory cannot be found at once; with the hardening growing to its size it is that of solve_ivp."""
    duffing, time = Duffing(), np.arange(2561) / 64
    force = lambda t: {"force": push * (4 * np.sin(2.5 * t + 0.05 * t**2) + 2 * np.cos(4 * t))}  # noqa: E731
    motion = Motion(time, force(time), force((time[1:] + time[:-1]) / 2))
    equations, values = Equations(duffing, ["position", "pull"], []), {**duffing.values, "hardening": hardening}
    with pytest.raises(InputError, match="diverges"):
        simulate(equations, values, motion)
    made = led_in(equations, values, motion, ["hardening"])
    exact = solve_ivp(lambda t, x: [x[1], force(t)["force"] - 40 * x[0] - hardening * x[0] ** 3 - 0.6 * x[1]], (0, time[-1]), [0, 0],
                      t_eval=time, rtol=1e-9, atol=1e-10).y.T  # fmt: skip
    # Fourth order: at its largest motion the stiffest of these springs swings with some 35 rad/s, (w h)^4 / 180 is 5e-4 per radian, most of it a phase
    np.testing.assert_allclose(made.states, exact, atol=5e-4 * np.abs(exact).max())
    with pytest.raises(InputError, match="diverges"):
        led_in(equations, {**values, "hardening": 1e5}, motion, ["hardening"])


@pytest.fixture(scope="module")
def short_run():
    arrays = record(sweep(0.5, 8, 3, 40.0), {"kr": 15.0, "tau": 0.1, "Tc": 0.3}, RIDER, np.random.default_rng(5))
    return prepare(as_recording("sweep", arrays), "steer_angle", "steer_torque", "steer_angle_command")


@pytest.mark.parametrize("form", ["delayed_angle", "delay", "spring", "coulomb", "cubic", "dahl", "head"])
def test_slopes_of_the_reduced_output_are_those_of_differences(short_run, form):
    effect = next(e for e in rig_effects() if e.form == form)
    model = Model(rig_test(RIG)).joined_by(effect)
    q = model.start()
    slopes = model.reduced(short_run, q)[1]
    for i, name in enumerate(model.names):
        step = np.eye(len(q))[i] * 1e-4 * max(abs(q[i]), 0.1 if i < len(model.base) else 1e-3)
        difference = (model.predicted(short_run, q + step) - model.predicted(short_run, q - step)) / (2 * step[i])
        # A lag's slope is that of an interpolated output, right to the fraction of a per cent at the highest orders.
        assert np.linalg.norm(slopes[:, i] - difference) < 3e-3 * np.linalg.norm(difference) + 1e-6, name


def candidates(run):
    model = Model(rig_test(RIG))
    library = [e for e in rig_effects() if e.family in ("coulomb_friction", "reflex", "steer_damping", "hardening_stiffness") and not e.flexible]
    return compete(fit(model, [run], model.start()), library)


def test_many_processes_find_what_one_finds(short_run, monkeypatch):
    monkeypatch.setattr(parallel, "processes", lambda: 1)
    alone = candidates(short_run)
    monkeypatch.setattr(parallel, "processes", lambda: 3)
    together = candidates(short_run)
    assert [(c.family, c.effect.form, c.fitted, c.delta_chi2) for c in together] == [(c.family, c.effect.form, c.fitted, c.delta_chi2) for c in alone]
    assert [c.fitted for c in alone] == sorted((c.fitted for c in alone), reverse=True)
    assert all(c.delta_chi2 >= 0 for c in alone)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no processes are forked on this platform")
def test_work_is_spread_in_order_and_its_errors_come_back(monkeypatch):
    monkeypatch.setattr(parallel, "processes", lambda: 2)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        answers = parallel.spread(lambda i: (i**2, os.getpid()), range(20), "squares")
    assert [a for a, _ in answers] == [i**2 for i in range(20)]
    assert os.getpid() not in {p for _, p in answers}
    with pytest.raises(ZeroDivisionError):
        parallel.spread(lambda i: 1 / i, range(3), "reciprocals")


@pytest.mark.parametrize("count", [1, 2])
def test_work_aside_answers_when_it_is_asked(monkeypatch, count):
    monkeypatch.setattr(parallel, "processes", lambda: count)
    with parallel.aside(os.getpid) as first, parallel.aside(lambda: 1 / 0) as failing:
        spread = parallel.spread(lambda i: -i, range(4), "between")
        assert (first() != os.getpid()) == (count > 1 and hasattr(os, "fork"))
        with pytest.raises(ZeroDivisionError):
            failing()
    assert spread == [0, -1, -2, -3] and not parallel._WORK


def test_all_shapes_of_an_effect_are_screened_however_they_are_shared_out(short_run, monkeypatch):
    found = fit(Model(rig_test(RIG)), [short_run], Model(rig_test(RIG)).start())
    effects = [e for e in rig_effects() if e.form in ("head", "coulomb", "dahl", "step")]
    assert max(len(shapes_of(found, e)) for e in effects) > 2
    seen = []
    for together in (1, 2, 100):
        monkeypatch.setattr(screening, "TOGETHER", together)
        seen.append(screen(found, effects, keep=100))
    assert len(seen[0]) == sum(len(shapes_of(found, e)) for e in effects)
    for other in seen[1:]:
        assert [s.effect for s in other] == [s.effect for s in seen[0]]
        # A trajectory begins where the last shape's ended, which moves it by its rounding.
        np.testing.assert_allclose([s.gain for s in other], [s.gain for s in seen[0]], rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("share, tried_again", [(1e-3, False), (0.9, True)])
def test_a_rival_that_is_out_of_reach_gets_no_further_start(short_run, monkeypatch, share, tried_again):
    """It gains less than it promised: far from what is to be reached there is no other start, near it there is."""
    found = fit(Model(rig_test(RIG)), [short_run], Model(rig_test(RIG)).start())
    rival = screen(found, [e for e in rig_effects() if e.family == "cross_inertia"], keep=1)[0]
    begun = []
    monkeypatch.setattr(parallel, "processes", lambda: 1)
    monkeypatch.setattr(joining, "fit", lambda *a, **k: begun.append(fit(*a, **k)) or begun[-1])
    joining.fit_each(found, [replace(rival, gain=found.chi2)], [], share * found.chi2, [])
    assert begun[0].chi2 < found.chi2 and (len(begun) > 1) == tried_again


def test_as_many_processes_as_are_allowed(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    assert parallel.processes() == 1


def test_the_benchmark_measures_a_verdict():
    cost = gap_speed.measured("none", 40.0, 0.1)
    assert cost["verdict"] == "none"
    assert 0 < cost["screening_cpu_s"] < 20 and 0 < cost["preparing_cpu_s"] < 20  # hundredths of a second, on a machine with nothing else to do
    assert cost["peak_mb"] < 1000
