"""Starting values of effects by equation error, on a joint that turns by several radians."""

import numpy as np

from fmus.effects.stiffness import CubicHardening, GeometricNonlinearity, QuinticHardening
from fmus.mechanisms import DrivenJoint
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation import equation_error
from motofmi.gap.estimation.base_fit import fitted_base
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.recordings.recording import Recording

INERTIA, DAMPING, STIFFNESS = 0.1, 0.2, 2.0  # kg.m2, N.m.s/rad, N.m/rad


def turning() -> Recording:
    """20 s at 100 Hz: two sines of 3 rad and 1 rad, and the exact torque with noise."""
    time, noise = np.arange(2000) / 100, np.random.default_rng(3).standard_normal(2000)
    sines = [(3.0, 2 * np.pi * 0.4), (1.0, 2 * np.pi * 1.1)]
    angle, rate, acceleration = (sum(a * w**k * np.sin(w * time + k * np.pi / 2) for a, w in sines) for k in range(3))
    torque = INERTIA * acceleration + DAMPING * rate + STIFFNESS * angle + 0.01 * noise
    return Recording("turning", time, {"torque": torque, "angle": angle}, {"torque": "N.m", "angle": "rad"})


def test_every_start_has_a_torque_of_the_size_of_the_recorded_one(monkeypatch):
    """A declared stiffness of 1e6 N.m/rad5 is 1e9 N.m at 4 rad, so that simulations took minutes in other mechanisms.

    Only a declared share of a term of the base (the sine of an angle) is of the right size.
    """
    experiment = input_output_experiment(DrivenJoint(), ["torque", "angle"])
    library = [CubicHardening, QuinticHardening, GeometricNonlinearity]
    base = fitted_base(experiment, [prepare_sampled_run(turning(), experiment)], {}, library, Criteria()).fit
    starts = []

    def recorded(model, runs, start, **options):
        if model.effects:
            torque = runs[0].data / runs[0].deviation
            size = np.linalg.norm(model.reduced(runs[0], start)[0] - torque) / np.linalg.norm(torque)
            starts.append((model.effects[0].form, size))
        return fit(model, runs, start, **options)

    monkeypatch.setattr(equation_error, "fit", recorded)
    monkeypatch.setattr(equation_error, "parallel_map", lambda one, each, _: [one(x) for x in each])
    assert equation_error.equation_error_fits(base, library)
    assert {form for form, _ in starts} == {"cubic", "quintic", "sine"}
    assert max(size for _, size in starts) < 10  # of the rms of the recorded torque
