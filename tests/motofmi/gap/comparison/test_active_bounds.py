"""Masses and dampers that a fit moves to zero: errors of the other values are those with these at zero.

The loop of Dahl's hysteresis under a displacement with constant speed is exact (Dahl 1968):

    z' = (1 - z sign(v)) v / w:   z = s + (z0 - s) exp(-|x - x0| / w),   s = sign(v)
"""

import numpy as np
import pytest

from fmus.effects.hysteresis import DahlHysteresis
from fmus.mechanisms import MassSpringDamper
from motofmi.gap.comparison.active_bounds import at_zero
from motofmi.gap.comparison.compared_model import CommonBlocks
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.fit_result import standard_errors
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.recordings.recording import Recording

STIFFNESS, FORCE, WIDTH, SPEED = 50.0, 8.0, 0.02, 0.05  # N/m, N, m, m/s


def slow_loops(damping: float) -> Recording:
    """60 s of loops between +-0.05 m at 0.05 m/s, with noise of 0.05 N; nothing is accelerated but at the ends."""
    time = np.arange(0, 60, 0.02)
    phase = (SPEED * time + 0.05) % 0.2
    x = np.where(phase < 0.1, phase - 0.05, 0.15 - phase)
    z = np.zeros(len(time))
    for k, step in enumerate(np.diff(x), 1):
        side = np.sign(step)
        z[k] = side + (z[k - 1] - side) * np.exp(-abs(step) / WIDTH)
    rate = np.gradient(x, time)
    noise = 0.05 * np.random.default_rng(4).standard_normal(len(time))
    force = STIFFNESS * x + damping * rate + FORCE * z + noise
    return Recording("loops", time, {"displacement": x, "force": force}, {"displacement": "m", "force": "N"})


@pytest.mark.parametrize("damping", [-4.0, 40.0])
def test_a_vanished_damper_does_not_widen_the_error_of_a_force_that_it_could_replace(damping):
    """At one speed a damper is a force with the sign of the rate: 40 N.s/m are 2 N, and -4 N.s/m, which its bound does
    not allow, are taken as 0.2 N less hysteresis."""
    base = MassSpringDamper(mass=1.0, spring_stiffness=STIFFNESS, spring_damping=max(damping, 1.0))
    experiment = input_output_experiment(base, ["displacement", "force"], "displacement")
    run = prepare_sampled_run(slow_loops(damping), experiment)
    model = FreeInitialStateModel(experiment.scaled(0.05, SPEED)).with_added_effects(DahlHysteresis)
    start = model.start()
    start[model.names.index("hysteresis.force")], start[model.names.index("hysteresis.width")] = FORCE, WIDTH
    found = fit(model, [run], start)
    names = [model.names[i] for i in at_zero(found)]
    assert ("spring_damping" in names) == (damping < 0)
    covariance = CommonBlocks(found, [], Criteria()).covariance(found)
    error = standard_errors(covariance)[model.names.index("hysteresis.force")]
    value = model.values(found.shared)["hysteresis.force"]
    expected = FORCE + min(damping, 0.0) * SPEED
    assert value == pytest.approx(expected, abs=4 * error + 0.02 * FORCE)  # 2 %: the rounded turning points
    if damping < 0:
        assert error < 0.1 * FORCE
