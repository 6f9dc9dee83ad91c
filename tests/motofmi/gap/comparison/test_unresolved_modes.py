"""Two modes of a free motion that its duration does not resolve are not distinguishable from one that changes."""

from types import SimpleNamespace

import numpy as np
import pytest

from fmus import Component, parameter, state
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
    modes = unresolved_modes(fitted("hung_body", NEAR, 20.0))
    # 1e-3: damping of 1 % lowers a frequency by 5e-5 of it
    assert (modes.first, modes.second) == pytest.approx((FREQUENCY, FREQUENCY + 0.02), rel=1e-3)
    assert modes.resolution == pytest.approx(1 / 20.0, rel=1e-3)  # the last sample is 0.01 s before the end
    assert str(modes) == "modes of 2 and 2.02 Hz (resolution 0.05 Hz)"
    assert unresolved_modes(fitted("hung_body", NEAR, 100.0)) is None
    assert unresolved_modes(fitted("hung_body", FAR, 20.0)) is None


def test_an_input_tells_modes_apart():
    assert unresolved_modes(fitted("hung_body", NEAR, 20.0, force=1.0)) is None


def test_a_state_that_does_not_oscillate_is_no_mode():
    assert unresolved_modes(fitted("dahl", {}, 20.0)) is None
    assert unresolved_modes(fitted("coulomb", {}, 20.0)) is None


class Drum(Component):
    """A drum that coasts down."""

    damping = parameter("1/s", "Drag over inertia", min=0, start=0.004)
    speed = state("m/s", "Speed of the surface", exposed=True)

    def equations(self, v, m):
        return {"der(speed)": -v.damping * v.speed}


def lagging(time_constant, duration, component):
    """A fit of a sensor's lag to a coast-down of some seconds."""
    time = np.arange(0, duration, 1.0)
    recording = Recording("run", time, {"speed": np.exp(-0.004 * time)}, {"speed": "m/s"})
    experiment = input_output_experiment(component, ["speed"])
    (lag,) = (e for e in laws_at(component, outputs={"speed": 1.0}) if e.family == "sensor_lag")
    model = FreeInitialStateModel(experiment, [lag])
    x = model.start({experiment.parameter(lag, "time_constant"): time_constant})
    return SimpleNamespace(model=model, x=x, runs=[SimpleNamespace(recording=recording, experiment=experiment)])


def test_two_decays_are_resolved_where_their_ratio_changes_by_a_factor_of_e():
    """Of a drum of 0.004 1/s and a sensor of 300 s: their rates differ by 1/1500 1/s."""
    decays = unresolved_modes(lagging(300.0, 500.0, Drum()))
    assert (decays.first, decays.second) == pytest.approx((1 / 300, 0.004))
    assert str(decays) == "decays of 0.003333 and 0.004 1/s (resolution 0.002 1/s)"
    assert unresolved_modes(lagging(300.0, 1600.0, Drum())) is None
    assert unresolved_modes(lagging(10.0, 500.0, Drum())) is None


class TwoDrums(Drum):
    """A drum, and another one of which nothing is recorded."""

    other = state("m/s", "Speed of the other drum")

    def equations(self, v, m):
        return {"der(speed)": -v.damping * v.speed, "der(other)": -(v.damping + 1e-4) * v.other}


def test_decays_of_the_base_alone_say_nothing_about_an_effect():
    assert unresolved_modes(lagging(10.0, 500.0, TwoDrums())) is None
