"""A mass with dry friction of which only the acceleration is recorded: the initial states of its segments."""

import numpy as np
import pytest

from fmus.effects.placement import laws_at
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from tests.simulators.other_components import Accelerometer, accelerometer_run

FRICTION = {"coulomb_friction.friction_torque": 1.5, "coulomb_friction.sliding_rate": 1e-3}  # N, m/s


@pytest.mark.parametrize("seed", [1, 3])
def test_initial_states_that_are_not_recorded_continue_the_motion_before_them(seed):
    """With the simulated values, one of 11 segments kept initial states with 3.5 to 4.7 times the usual misfit (rms)."""
    component = Accelerometer(mass=2.0, stiffness=300.0, damping=4.0)
    experiment = input_output_experiment(component, ["force", "acceleration"])
    (soft,) = (e for e in laws_at(experiment.component) if (e.family, e.form) == ("coulomb_friction", "soft"))
    model = FreeInitialStateModel(experiment).with_added_effects(soft)
    simulated = np.array([FRICTION.get(n, x) for n, x in zip(model.names, model.start(), strict=True)])
    run = prepare_sampled_run(accelerometer_run("run", seed, FRICTION["coulomb_friction.friction_torque"]), experiment)
    residuals = model.reduced(run, simulated)[0] * run.deviation - run.data
    rms = [np.sqrt(np.mean(residuals[rows] ** 2)) for rows in run.reduction.rows]
    assert max(rms) < 3.0 * np.median(rms)
