"""A joint with dry friction of which only the acceleration is recorded: the initial states of its segments."""

import numpy as np

from fmus import output
from fmus.effects.placement import laws_at
from fmus.mechanisms import DrivenJoint
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.recordings.recording import Recording

INERTIA, STIFFNESS, DAMPING, FRICTION, SLIDING = 0.05, 20.0, 0.25, 0.3, 0.02  # kg.m2, N.m/rad, N.m.s/rad, N.m, rad/s
STEP, SAMPLE = 5e-4, 10  # s; steps per sample
NOISE = 0.02  # rad/s2


class SensedJoint(DrivenJoint):
    """A driven joint with an accelerometer."""

    acceleration = output("rad/s2", "Acceleration of the body")

    def equations(self, v, m):
        results = super().equations(v, m)
        return {**results, "acceleration": results["der(rate)"]}


def recorded(seed: int, duration: float = 30.0) -> Recording:
    """20 sines from 0.2 Hz to 6 Hz, simulated by the midpoint rule."""
    random, time = np.random.default_rng(seed), np.arange(0.0, duration, STEP)
    phases = random.uniform(0, 2 * np.pi, 20)
    torque = 0.25 * np.sin(np.outer(time, 2 * np.pi * np.geomspace(0.2, 6.0, 20)) + phases).sum(axis=1)
    between = np.append((torque[1:] + torque[:-1]) / 2, torque[-1])
    angle, rate, found = 0.0, 0.0, np.empty(len(time))

    def acceleration(torque, angle, rate):
        return (torque - STIFFNESS * angle - DAMPING * rate - FRICTION * np.tanh(rate / SLIDING)) / INERTIA

    for k in range(len(time)):
        found[k] = acceleration(torque[k], angle, rate)
        half = angle + STEP / 2 * rate, rate + STEP / 2 * found[k]
        angle, rate = angle + STEP * half[1], rate + STEP * acceleration(between[k], *half)
    noise = NOISE * random.standard_normal(len(time))
    columns = {"torque": torque[::SAMPLE], "acceleration": (found + noise)[::SAMPLE]}
    units = {"torque": "N.m", "acceleration": "rad/s2"}
    return Recording("run", time[::SAMPLE], columns, units)


def test_initial_states_that_are_not_recorded_continue_the_motion_before_them():
    """Of 22 segments three kept initial states with up to 200 times the misfit of the others."""
    component = SensedJoint(inertia=INERTIA, stiffness=STIFFNESS, damping=DAMPING)
    (soft,) = (e for e in laws_at(component) if (e.family, e.form) == ("coulomb_friction", "soft"))
    experiment = input_output_experiment(component, ["torque", "acceleration"])
    model = FreeInitialStateModel(experiment).with_added_effects(soft)
    values = {"coulomb_friction.friction_torque": FRICTION, "coulomb_friction.sliding_rate": SLIDING}
    true = np.array([values.get(n, x) for n, x in zip(model.names, model.start(), strict=True)])
    run = prepare_sampled_run(recorded(1), experiment)
    residuals = model.reduced(run, true)[0] * run.deviation - run.data
    rms = [np.sqrt(np.mean(residuals[rows] ** 2)) for rows in run.reduction.rows]
    assert max(rms) < 3 * np.median(rms)
