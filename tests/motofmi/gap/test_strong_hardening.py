"""A spring that hardens tenfold: a linear base misses most of the motion, and from its states other models diverge."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import butter, lfilter

from fmus.effects.stiffness import Backlash, CubicHardening, SoftBacklash
from fmus.mechanisms import MassSpringDamper
from fmus.support.errors import InputError
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.selection.any_component import investigate
from motofmi.recordings.recording import Recording

MASS, DAMPING, STIFFNESS, CUBIC = 1.0, 1.0, 400.0, 2.5e5  # kg, N.s/m, N/m, N/m3
NOISE = 1e-5  # m, of deflections up to 0.13 m
EXPERIMENT = input_output_experiment(MassSpringDamper(), ["force", "displacement"])
TRUTH = {"mass": MASS, "spring_damping": DAMPING, "spring_stiffness": STIFFNESS}


def driven(name: str, seed: int, duration: float) -> Recording:
    """Low-passed random force in straight lines between samples at 200 Hz, and the displacement by an integrator of
    SciPy."""
    time, rng = np.arange(0, duration, 1 / 200), np.random.default_rng(seed)
    force = 120 * lfilter(*butter(2, 5, fs=200), rng.standard_normal(len(time)))

    def rates(t, s):
        push = np.interp(t, time, force)
        return [s[1], (push - DAMPING * s[1] - STIFFNESS * s[0] - CUBIC * s[0] ** 3) / MASS]

    x = solve_ivp(rates, (0, time[-1]), [0.0, 0.0], t_eval=time, rtol=1e-8, atol=1e-11).y[0]
    assert CUBIC * np.abs(x).max() ** 2 > 8 * STIFFNESS
    noisy = x + NOISE * rng.standard_normal(len(x))
    return Recording(name, time, {"force": force, "displacement": noisy}, {"force": "N", "displacement": "m"})


def test_a_simulation_without_an_earlier_one_begins_from_the_recorded_motion():
    """All segments converge together, which they do neither from the start values nor from the states of a linear fit."""
    run = prepare_sampled_run(driven("run", 1, 10), EXPERIMENT).cut(100)
    model = FreeInitialStateModel(EXPERIMENT).with_added_effects(CubicHardening)
    start = model.start(TRUTH | {"hardening_stiffness.cubic_stiffness": CUBIC})
    deflection, segments = run.measured[:, 0], range(len(run.segments))
    states = np.column_stack([deflection, np.gradient(deflection, run.recording.time)])
    initial = {i: states[first] for i, (first, _) in enumerate(run.segments)}
    made, nodes = model.simulated(run, segments, model.values(start), initial)
    found = np.concatenate([made.outputs[where, 0] for where in nodes.samples])
    # The rates at the begin are central differences over 10 ms, in error by some per cent.
    assert np.std(found - deflection) < 0.2 * np.std(deflection)
    base = FreeInitialStateModel(EXPERIMENT)
    linear = fit(base, [replace(run, guess={})], base.start(TRUTH))
    with pytest.raises(InputError, match="diverges"):
        fit(model, linear.runs, start)


@pytest.mark.slow
def test_the_hardening_is_named_and_not_a_backlash():
    """Fitted from the states of the base, backlash left 67 % of the motion and the cubic spring could not be simulated."""
    fitted, validation = driven("fitted", 1, 20), driven("validation", 2, 20)
    library = [CubicHardening, Backlash, SoftBacklash]
    verdict = investigate(
        EXPERIMENT, [prepare_sampled_run(fitted, EXPERIMENT)], validation=[validation], library=library
    ).verdict
    assert [effect.family for effect in verdict.effects] == ["hardening_stiffness"]
    values = verdict.best.model.values(verdict.best.shared)
    # 0.2 %: the force is read as a spline through its samples
    assert values["hardening_stiffness.cubic_stiffness"] == pytest.approx(CUBIC, rel=2e-3)
