"""Two modes of a free motion that its duration does not resolve are not distinguishable from one that changes."""

from types import SimpleNamespace

import numpy as np
import pytest

from fmus.effects.placement import laws_at
from fmus.mechanisms import MassSpringDamper
from motofmi.gap.comparison.unresolved_modes import unresolved_modes
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.recordings.recording import Recording

FREQUENCY = 2.0  # Hz, of the base alone
COMPONENT = MassSpringDamper(mass=1.0, spring_stiffness=(2 * np.pi * FREQUENCY) ** 2, spring_damping=0.1)
LAWS = {e.form: e for e in laws_at(COMPONENT)}


def fitted(form, values, duration, force=0.0):
    """A fit of an effect to a run of some seconds."""
    time = np.arange(0, duration, 0.01)
    columns = {"displacement": np.cos(time), "force": force * np.sin(time)}
    recording = Recording("run", time, columns, {"displacement": "m", "force": "N"})
    experiment = input_output_experiment(COMPONENT, list(columns))
    model = FreeInitialStateModel(experiment, [LAWS[form]])
    x = model.start({experiment.parameter(LAWS[form], name): value for name, value in values.items()})
    return SimpleNamespace(model=model, x=x, runs=[SimpleNamespace(recording=recording, experiment=experiment)])


# A light body hardly changes the mode of the base.
NEAR = {"inertia": 1e-6, "frequency": FREQUENCY + 0.02, "damping_ratio": 0.01}
FAR = {**NEAR, "frequency": FREQUENCY + 1.0}


def test_the_resolution_is_that_of_the_duration():
    low, high, resolution = unresolved_modes(fitted("hung_body", NEAR, 20.0))
    # 1e-3: damping of 1 % lowers a frequency by 5e-5 of it
    assert (low, high) == pytest.approx((FREQUENCY, FREQUENCY + 0.02), rel=1e-3)
    assert resolution == pytest.approx(1 / 20.0, rel=1e-3)  # the last sample is 0.01 s before the end
    assert unresolved_modes(fitted("hung_body", NEAR, 100.0)) is None
    assert unresolved_modes(fitted("hung_body", FAR, 20.0)) is None


def test_an_input_tells_modes_apart():
    assert unresolved_modes(fitted("hung_body", NEAR, 20.0, force=1.0)) is None


def test_a_state_that_does_not_oscillate_is_no_mode():
    assert unresolved_modes(fitted("dahl", {}, 20.0)) is None
    assert unresolved_modes(fitted("coulomb", {}, 20.0)) is None
