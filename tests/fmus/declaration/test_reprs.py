"""What components, systems, libraries and state spaces print: one short line that says what they are."""

import pytest

from fmus import InputError, linearise
from rider_fmu import riders
from rider_fmu.effects.head import SteeringFriction
from vehicle_fmu import LinearDamper, motorcycles, ridden


def test_a_component_shows_name_parameters_effects_and_source():
    rider = riders.load("mean_2011")
    assert repr(rider).startswith(
        "PassiveRider('rider_mean_2011', 7 parameters, source='Cossalter, Doria, Lot, Massaro"
    )
    assert len(repr(rider)) < 130
    assert repr(LinearDamper("soft")) == "LinearDamper('soft', 1 parameter)"
    assert "effects: SteeringFriction" in repr(rider.with_effects(SteeringFriction()))
    assert repr(SteeringFriction()) == "SteeringFriction(coulomb_friction.coulomb at steering_head)"


def test_a_component_is_a_table_of_its_values_in_a_notebook():
    page = riders.load("mean_2011")._repr_html_()
    assert "<td>arm_stiffness</td>" in page and "<td>1053.4</td><td>N.m/rad</td>" in page


def test_a_system_shows_its_parts_and_a_library_its_names():
    system = ridden(motorcycles.load("sharp_1971"), riders.load("mean_2011"))
    assert "vehicle=Motorcycle('motorcycle_sharp_1971'), device=PassiveRider('rider_mean_2011')" in repr(system)
    assert repr(motorcycles).startswith("Library('motorcycle', 6 names: ") and "sharp_1971" in repr(motorcycles)


def test_a_state_space_shows_its_signals_and_a_wrong_one_is_an_error():
    space = linearise(riders.load("mean_2011"))
    assert repr(space).startswith("StateSpace(2 states, inputs: steer_angle, steer_rate, frame_rate; outputs: ")
    with pytest.raises(
        InputError, match="unknown output of the linear system 'handlebar_torqe', did you mean 'handlebar_torque'"
    ):
        space.frequency_response(1.0, "handlebar_torqe", "steer_angle")
