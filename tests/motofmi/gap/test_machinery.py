"""The machinery of the gap workflow: slopes of what is compared, and many processes against one."""

import json
import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fmus.effects import load_folder
from fmus.effects.placement import laws_at
from fmus.support import parallel
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation import effect_fit, screening
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.screening import screen, shapes_of
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.models.harmonic_model import HarmonicModel
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
