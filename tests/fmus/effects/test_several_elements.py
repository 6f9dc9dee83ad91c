"""A law at several elements at once, on two links with a joint each, against Lagrange's equations in matrix form."""

import numpy as np
import pytest

from fmus.effects import Effect
from fmus.effects.placement import by_name, laws_at
from fmus.mechanisms import DrivenJoint, TwoMass
from fmus.support.errors import InputError
from tests.simulators.double_pendulum import DoublePendulum

LAWS = by_name(laws_at(DoublePendulum()))
STATES = {"angle": 0.4, "elbow_angle": -1.1, "rate": 0.7, "elbow_rate": -0.3}


def accelerations(arm: DoublePendulum, torques: tuple[float, float] = (0.3, -0.2)) -> np.ndarray:
    """The accelerations (2,) of both links in the state above."""
    found = arm.derivatives(np.array([STATES[n] for n in arm.states]), np.array(torques))[0]
    return found[[arm.states.index("rate"), arm.states.index("elbow_rate")]]


def mass(arm: DoublePendulum) -> np.ndarray:
    """The mass matrix (2, 2) of both links."""
    coupling, elbow = arm.values["coupling"] * np.cos(STATES["elbow_angle"]), arm.values["elbow_inertia"]
    return np.array([[arm.values["inertia"] + elbow + 2 * coupling, elbow + coupling], [elbow + coupling, elbow]])


@pytest.mark.parametrize(
    ("name", "magnitude", "force"),
    [
        ("coulomb_friction.coulomb", "friction_torque", lambda rate: np.tanh(rate / 0.02)),
        ("progressive_damping.quadratic", "coefficient", lambda rate: np.abs(rate) * rate),
        ("progressive_damping.cubic", "cubic_coefficient", lambda rate: rate**3),
    ],
)
def test_each_element_has_the_force_of_the_law_with_its_own_magnitude(name, magnitude, force):
    arm, law = DoublePendulum(), LAWS[f"{name}_shoulder_and_elbow"]
    joined = arm.with_effects(law())
    values = {f"{law.family}.{magnitude}_shoulder": 0.15, f"{law.family}.{magnitude}_elbow": 0.2}
    rubbing = joined.with_values(**values)
    forces = np.array([0.15, 0.2]) * force(np.array([STATES["rate"], STATES["elbow_rate"]]))
    # 1e-9: rounding in the solution of two equations
    assert mass(arm) @ (accelerations(rubbing) - accelerations(arm)) == pytest.approx(-forces, rel=1e-9)
    absent = joined.with_values(**dict.fromkeys(values, 0.0))
    assert accelerations(absent) == pytest.approx(accelerations(arm), rel=1e-12)


def test_magnitudes_belong_to_an_element_and_shapes_to_all():
    soft = LAWS["coulomb_friction.soft_shoulder_and_elbow"]
    assert soft.free_parameters() == ("friction_torque_shoulder", "friction_torque_elbow", "sliding_rate")
    assert soft.nonlinear_parameters() == ("sliding_rate",)
    assert soft.magnitudes_by_element() == [("friction_torque_shoulder",), ("friction_torque_elbow",)]
    assert soft.element == "shoulder and elbow"
    table = DoublePendulum().with_effects(soft()).table
    assert [table[f"coulomb_friction.{n}"].unit for n in soft.free_parameters()] == ["N.m", "N.m", "rad/s"]


def test_any_two_elements_and_all_of_them_are_places():
    forms = {e.form for e in laws_at(TwoMass()) if e.family == "coulomb_friction" and e.form.startswith("coulomb")}
    assert forms == {
        "coulomb", "coulomb_drive", "coulomb_load", "coulomb_spring_and_drive", "coulomb_spring_and_load",
        "coulomb_drive_and_load", "coulomb_spring_and_drive_and_load",
    }  # fmt: skip
    assert not any("and" in e.element.split() for e in laws_at(DrivenJoint()))  # it has one element


def test_laws_with_states_or_of_one_direction_act_at_one_element():
    several = {name for name, law in LAWS.items() if len(law.magnitudes_by_element()) > 1}
    assert several == {f"{name}_shoulder_and_elbow" for name in (
        "coulomb_friction.coulomb", "coulomb_friction.soft", "progressive_damping.quadratic",
        "progressive_damping.cubic")}  # fmt: skip


def test_a_missing_element_is_named():
    law: type[Effect] = LAWS["coulomb_friction.coulomb_shoulder_and_elbow"]
    with pytest.raises(InputError, match="unknown element of DrivenJoint 'shoulder'"):
        DrivenJoint().with_effects(law())
