"""Which effects have a magnitude that is distinguishable from zero."""

from types import SimpleNamespace

import numpy as np
import pytest

from fmus.effects.damping import CoulombFriction
from fmus.effects.resonance import HungBody
from fmus.effects.stiffness import AddedSpring, Asymmetry, CubicHardening
from fmus.mechanisms.mass_spring_damper import MassSpringDamper
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import undetermined_magnitude
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.eigenvalue_model import EigenvalueModel
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.recordings.recording import Recording
from motofmi.workflows.components import DEVICE_EFFECTS
from motofmi.workflows.gap.vehicle import vehicle_experiment
from vehicle_fmu import motorcycles


class SecondSpring(AddedSpring):
    """A spring beside the one of the base, whose parameter `stiffness` is its own."""

    family, element = "second_spring", "spring"


def fitted(*effects, imposed=""):
    """A mass of 2 kg, a spring of 300 N/m and a damper of 4 N.s/m, with effects at the values from which fits start."""
    time = np.arange(0, 4, 0.01)
    columns = {"force": np.sin(7 * time), "displacement": np.sin(7 * time + 0.1)}
    run = Recording("run", time, columns, {"force": "N", "displacement": "m"})
    slide = MassSpringDamper().with_values(mass=2.0, spring_stiffness=300.0, spring_damping=4.0)
    experiment = input_output_experiment(slide, ["force", "displacement"], imposed)
    model = FreeInitialStateModel(experiment, effects)
    return fit(model, [prepare_sampled_run(run, experiment)], model.start(), iterations=0)


@pytest.mark.parametrize("imposed", ["", "displacement"])
@pytest.mark.parametrize(("relative", "undetermined"), [(0.49, False), (0.51, True)])
def test_an_effect_on_a_stiffness_that_may_be_zero_has_no_determined_magnitude(relative, undetermined, imposed):
    """The error of a parameter of the base is that of its logarithm; at 0.51, two standard errors are 306 N/m."""
    found = fitted(Asymmetry, imposed=imposed)
    errors = np.full(len(found.model.names), 1e-3)
    errors[found.model.names.index("spring_stiffness")] = relative
    said = undetermined_magnitude(found, errors, Criteria())
    assert said == (pytest.approx(("spring_stiffness", 300.0, 300.0 * relative)) if undetermined else None)


@pytest.mark.parametrize(("relative", "undetermined"), [(0.49, False), (0.51, True)])
def test_a_body_that_takes_the_place_of_the_mass_has_no_determined_magnitude(relative, undetermined):
    """At 0.51, two standard errors of the mass are 2.04 kg; the body's own inertia is determined."""
    found = fitted(HungBody)
    errors = np.full(len(found.model.names), 1e-6)
    errors[found.model.names.index("mass")] = relative
    said = undetermined_magnitude(found, errors, Criteria())
    assert said == (pytest.approx(("mass", 2.0, 2.0 * relative)) if undetermined else None)


@pytest.mark.parametrize("effect", [CubicHardening, CoulombFriction, SecondSpring])
def test_an_effect_with_a_coefficient_of_its_own_does_not_depend_on_the_stiffness(effect):
    found = fitted(effect)
    errors = np.full(len(found.model.names), 1e-3)
    errors[: len(found.model.base)] = 10.0
    assert undetermined_magnitude(found, errors, Criteria()) is None


def test_a_rider_at_the_handlebar_changes_no_stiffness_of_the_vehicle():
    """The parameters of the rider have a prior, and no magnitude that may be zero."""
    (rider,) = (effect for effect in DEVICE_EFFECTS if effect.family == "passive_rider")
    model = EigenvalueModel(vehicle_experiment(motorcycles.load("sharp_1971")), [rider])
    found = SimpleNamespace(model=model, shared=model.start(), x=model.start())
    assert undetermined_magnitude(found, np.full(len(model.names), 1e9), Criteria()) is None


def test_an_effect_within_its_own_error_has_no_determined_magnitude():
    found = fitted(CubicHardening)
    errors = np.full(len(found.model.names), 1e-3)
    errors[-1] = 1e9
    name, value, error = undetermined_magnitude(found, errors, Criteria())
    assert name == "hardening_stiffness.cubic_stiffness" and (value, error) == (found.x[len(errors) - 1], 1e9)
