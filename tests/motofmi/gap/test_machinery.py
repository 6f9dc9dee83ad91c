"""The machinery of the gap workflow: trajectories and slopes against SciPy and differences, many processes against one."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fmus import Component, input, output, parameter, state
from fmus.effects import load_folder
from fmus.effects.placement import laws_at
from fmus.support import parallel
from fmus.support.errors import InputError
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation import effect_fit, screening
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.screening import screen, shapes_of
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models import simulation
from motofmi.gap.models.collocation import Motion
from motofmi.gap.models.equations import Equations
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.models.harmonic_model import HarmonicModel
from motofmi.gap.models.simulation import simulate, simulate_by_continuation
from motofmi.gap.models.time_varying_matrices import CACHED, carried, chain, inverse, product
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.preprocessing.steer_test_run import prepare_steer_test_run
from motofmi.gap.selection.candidate_search import search_candidates
from motofmi.recordings.recording import Recording
from motofmi.workflows.components import component_class
from motofmi.workflows.gap.rig import rig_effects, rig_experiment

pytest.importorskip("numba", reason="the simulator of the hidden effects is compiled by numba")
from tests import ROOT
from tests.simulators.as_recordings import as_recording
from tests.simulators.hidden_rig import RIDER, record, sweep
from tests.simulators.rig_runs import RIG


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


@pytest.fixture(scope="module")
def short_run():
    arrays = record(sweep(0.5, 8, 3, 40.0), {"kr": 15.0, "tau": 0.1, "Tc": 0.3}, RIDER, np.random.default_rng(5))
    return prepare_steer_test_run(as_recording("sweep", arrays), "steer_angle", "steer_torque", "steer_angle_command")


@pytest.mark.slow
@pytest.mark.parametrize("form", ["delayed_angle", "delay", "spring", "coulomb", "cubic", "dahl", "head"])
def test_slopes_of_the_reduced_output_are_those_of_differences(short_run, form):
    effect = next(e for e in rig_effects() if e.form == form)
    model = HarmonicModel(rig_experiment(RIG)).with_added_effects(effect)
    q = model.start()
    slopes = model.reduced(short_run, q)[1]
    for i, name in enumerate(model.names):
        step = np.eye(len(q))[i] * 1e-4 * max(abs(q[i]), 0.1 if i < len(model.base) else 1e-3)
        difference = (model.predicted(short_run, q + step) - model.predicted(short_run, q - step)) / (2 * step[i])
        # A lag's slope is that of an interpolated output, right to the fraction of a per cent at the highest orders.
        assert np.linalg.norm(slopes[:, i] - difference) < 3e-3 * np.linalg.norm(difference) + 1e-6, name


def candidates(run):
    model = HarmonicModel(rig_experiment(RIG))
    library = [
        e
        for e in rig_effects()
        if e.family in ("coulomb_friction", "reflex", "steer_damping", "hardening_stiffness") and not e.flexible
    ]
    return search_candidates(fit(model, [run], model.start()), library)


@pytest.mark.slow
def test_many_processes_find_what_one_finds(short_run, monkeypatch):
    monkeypatch.setattr(parallel, "processes", lambda: 1)
    alone = candidates(short_run)
    monkeypatch.setattr(parallel, "processes", lambda: 3)
    together = candidates(short_run)
    assert [(c.family, c.effect.form, c.fitted, c.delta_chi2) for c in together] == [
        (c.family, c.effect.form, c.fitted, c.delta_chi2) for c in alone
    ]
    assert [c.fitted for c in alone] == sorted((c.fitted for c in alone), reverse=True)
    assert all(c.delta_chi2 >= 0 for c in alone)


SLIDER = '''from fmus import Component, input, parameter, state


class Slider(Component):
    """A mass on a linear damper."""

    mass = parameter("kg", "Mass", symbol="m", min=0.1, max=20, start=2.0)
    damping = parameter("N.s/m", "Damping", symbol="c", min=0.1, max=50, start=3.0)
    force = input("N", "Force", symbol="F")
    velocity = state("m/s", "Velocity", symbol="v", exposed=True)

    def equations(self, v, m):
        return {"der(velocity)": (v.force - v.damping * v.velocity) / v.mass}
'''
TURBULENCE = '''from fmus import Effect, adds_to, parameter


class Turbulence(Effect):
    """Resistance of a turbulent flow."""

    family, form = "turbulence", "square"
    resistance = parameter("N.s2/m2", "Resistance over the square of the velocity", symbol="k", min=0, max=1e3)

    @adds_to("force")
    def square(self, v, m):
        return -v.resistance * v.velocity * m.absolute(v.velocity)
'''


@pytest.mark.slow
@pytest.mark.parametrize("start_method", ["fork", "loky"])
def test_workers_know_components_and_effects_of_a_users_files(tmp_path, monkeypatch, start_method):
    """Fresh workers, as on macOS and Windows, cannot import them: the classes are pickled by value."""
    if start_method == "fork" and not hasattr(os, "fork"):
        pytest.skip("no processes are forked on this platform")
    (tmp_path / "slider.py").write_text(SLIDER)
    (tmp_path / "effects").mkdir()
    (tmp_path / "effects" / "turbulence.py").write_text(TURBULENCE)
    component, (own,) = component_class(f"{tmp_path / 'slider.py'}:Slider")(), load_folder(tmp_path / "effects")
    time = np.arange(0.0, 12.0, 0.02)
    force = 8.0 * np.sin(1.3 * time) + 3.0 * np.sin(4.1 * time)
    solved = solve_ivp(
        lambda t, v: (np.interp(t, time, force) - 3.0 * v - 1.5 * v * abs(v)) / 2.0,
        (0.0, time[-1]),
        [0.0],
        t_eval=time,
        rtol=1e-8,
        atol=1e-10,
    )
    measured = solved.y[0] + 0.01 * np.random.default_rng(1).standard_normal(len(time))
    recording = Recording("slide", time, {"force": force, "velocity": measured}, {"force": "N", "velocity": "m/s"})
    test = input_output_experiment(component, ["force", "velocity"])
    base = fit(FreeInitialStateModel(test), [prepare_sampled_run(recording, test)], FreeInitialStateModel(test).start())
    monkeypatch.setenv("MOTOFMI_START_METHOD", start_method)
    library, found = [own, *laws_at(component)[:3]], []
    for count in (1, 2):
        monkeypatch.setattr(parallel, "processes", lambda count=count: count)
        found.append([(c.effect, c.fitted, c.delta_chi2) for c in search_candidates(base, library)])
    alone, together = found
    assert together[0][0] is alone[0][0] is own and together[0][1]
    assert [c[0] for c in together] == [c[0] for c in alone]
    assert [c[2] for c in together] == pytest.approx([c[2] for c in alone], rel=1e-6)


@pytest.mark.slow
def test_all_shapes_of_an_effect_are_screened_however_they_are_shared_out(short_run, monkeypatch):
    found = fit(HarmonicModel(rig_experiment(RIG)), [short_run], HarmonicModel(rig_experiment(RIG)).start())
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


@pytest.mark.slow
@pytest.mark.parametrize("share, tried_again", [(1e-3, False), (0.9, True)])
def test_a_rival_that_is_out_of_reach_gets_no_further_start(short_run, monkeypatch, share, tried_again):
    """It gains less than it promised: far from what is to be reached there is no other start, near it there is."""
    found = fit(HarmonicModel(rig_experiment(RIG)), [short_run], HarmonicModel(rig_experiment(RIG)).start())
    rival = screen(found, [e for e in rig_effects() if e.family == "cross_inertia"], keep=1)[0]
    begun = []
    monkeypatch.setattr(parallel, "processes", lambda: 1)
    monkeypatch.setattr(effect_fit, "fit", lambda *a, **k: begun.append(fit(*a, **k)) or begun[-1])
    effect_fit.fit_each(found, [replace(rival, gain=found.chi2)], [], share * found.chi2, [], Criteria())
    assert begun[0].chi2 < found.chi2 and (len(begun) > 1) == tried_again


@pytest.mark.slow
def test_the_benchmark_measures_a_verdict():
    # In a process of its own: the peak is that of a process since its start, whatever other tests it has run.
    call = "import json; from benchmarks.gap_speed import measured; print(json.dumps(measured('none', 40.0, 0.1)))"
    run = subprocess.run([sys.executable, "-c", call], capture_output=True, text=True, cwd=ROOT, check=True)
    cost = json.loads(run.stdout)
    assert cost["verdict"] == "none"
    assert (
        0 < cost["screening_cpu_s"] < 20 and 0 < cost["preparing_cpu_s"] < 20
    )  # hundredths of a second, on a machine with nothing else to do
    assert cost["peak_mb"] < 1000
