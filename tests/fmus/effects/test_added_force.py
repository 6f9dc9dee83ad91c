"""The points of a component without force elements at which the laws of mechanics act."""

import numpy as np
import pytest

from fmus import Component, input, parameter, state
from fmus.composition.added_force import with_force_element
from fmus.effects.placement import by_name, laws_at
from fmus.mechanisms import DrivenJoint


class VoltageCrane(Component):
    """A trolley that a motor drives by its voltage, and a load on a rod: the trolley's position is no state."""

    gain = parameter("m/V.s2", "Acceleration of the trolley per voltage", start=0.25)
    pull = parameter("m/s2", "Pull of the load on the trolley, per angle", start=0.7)
    length = parameter("m", "Length of the rod", min=0.1, start=2.0)
    voltage = input("V", "Voltage of the motor")
    velocity = state("m/s", "Velocity of the trolley", exposed=True)
    angle = state("rad", "Angle of the load", exposed=True)
    rate = state("rad/s", "Rate of the load")

    def equations(self, v, m):
        acceleration = v.gain * v.voltage + v.pull * v.angle
        return {"der(velocity)": acceleration, "der(angle)": v.rate,
                "der(rate)": -(9.81 * v.angle + acceleration) / v.length}  # fmt: skip


def test_friction_of_a_point_that_a_voltage_drives_acts_on_what_hangs_at_it():
    """v' = g u + p q - F, and the load is accelerated by -v' / l, with friction F of 0.15 N per kg of the trolley."""
    crane = with_force_element(VoltageCrane())
    laws = by_name(laws_at(crane))
    assert {e.rate for e in crane.elements.values()} == {"velocity"}
    assert with_force_element(VoltageCrane().with_values(gain=0.0)).elements == {}  # the voltage drives nothing
    rubbing = crane.with_effects(laws["coulomb_friction.coulomb"]())
    assert rubbing.table["coulomb_friction.friction_torque"].unit == "N/kg"
    joined = rubbing.with_values(**{"coulomb_friction.friction_torque": 0.15, "gain": 0.5})
    change, _ = joined.derivatives(np.array([3.0, 0.1, 0.2]), np.array([2.0]))
    trolley = 0.5 * 2.0 + 0.7 * 0.1 - 0.15
    assert change == pytest.approx([trolley, 0.2, -(9.81 * 0.1 + trolley) / 2.0], rel=1e-12)


def test_a_force_drives_the_velocity_along_it_and_not_the_load_that_hangs_there():
    """A short rod turns by more per force than the cart moves."""

    class Cart(Component):
        """A cart with a load on a short rod, whose angle increases with the force."""

        force = input("N", "Force at the cart")
        angle = state("rad", "Angle of the load", exposed=True)
        velocity = state("m/s", "Velocity of the cart", exposed=True)
        rate = state("rad/s", "Rate of the load")

        def equations(self, v, m):
            acceleration = v.force / 2.0
            return {"der(angle)": v.rate, "der(velocity)": acceleration,
                    "der(rate)": acceleration / 0.1 - 98.1 * v.angle}  # fmt: skip

    assert {(e.deflection, e.rate) for e in with_force_element(Cart()).elements.values()} == {("", "velocity")}


class Drum(Component):
    """A drum that coasts down."""

    decay = parameter("1/s", "Viscous resistance per inertia", min=0, start=0.01)
    speed = state("m/s", "Speed at the surface", exposed=True, start=20.0)

    def equations(self, v, m):
        return {"der(speed)": -v.decay * v.speed}


def test_a_rate_without_a_deflection_has_laws_of_the_rate_and_no_others():
    drum = with_force_element(Drum())
    laws = {(e.family, e.form): e for e in laws_at(drum)}
    families = {family for family, _ in laws}
    assert {"coulomb_friction", "progressive_damping"} <= families
    # laws of a deflection, and those of a level
    assert not families & {"hysteresis", "backlash", "hardening_stiffness", "leakage", "overflow", "transfer"}
    slowed = drum.with_effects(laws["progressive_damping", "quadratic"](), laws["coulomb_friction", "coulomb"]())
    values = {"progressive_damping.coefficient": 0.002, "coulomb_friction.friction_torque": 0.3}
    ((rate,), _) = slowed.with_values(**values).derivatives(np.array([20.0]), np.zeros(0))
    assert rate == pytest.approx(-0.01 * 20 - 0.002 * 20**2 - 0.3, rel=1e-12)  # tanh(20 / s_0) is 1
    assert slowed.table["progressive_damping.coefficient"].unit == "N.s2/m2.kg"


class Arm(Component):
    """An arm that a throttle drives, at small angles; it declares no element."""

    gain = parameter("rad/s2", "Acceleration at full throttle", min=0, start=50.0)
    gravity = parameter("1/s2", "Gravity per angle", min=0, start=10.0)
    throttle = input("1", "Throttle")
    angle = state("rad", "Angle from hanging", exposed=True)
    rate = state("rad/s", "Rate")

    def equations(self, v, m):
        return {"der(angle)": v.rate, "der(rate)": v.gain * v.throttle - v.gravity * v.angle}


def test_an_angle_of_a_class_without_elements_has_the_sine_of_large_angles():
    arm = with_force_element(Arm())
    forms = {e.form: e for e in laws_at(arm) if e.family == "geometric_nonlinearity"}
    assert set(forms) == {"gravity", "turned"}
    pendulum = arm.with_effects(forms["gravity"]()).with_values(**{"geometric_nonlinearity.gravity_torque": 10.0})
    rates, _ = pendulum.derivatives(np.array([2.0, 0.0]), np.zeros(1))
    assert rates == pytest.approx([0.0, -10 * np.sin(2.0)], rel=1e-12)  # the pendulum, q'' = -g/l sin q
    turned = arm.with_effects(forms["turned"]()).with_values(
        **{"geometric_nonlinearity.sine_torque": 6.0, "geometric_nonlinearity.cosine_torque": 8.0}
    )
    rates, _ = turned.derivatives(np.array([2.0, 0.0]), np.zeros(1))
    hanging = arm.derivatives(np.array([2.0, 0.0]), np.zeros(1))[0]
    # beside the base: sin(q + p), tan p = 8/6
    assert rates - hanging == pytest.approx([0.0, -10 * np.sin(2.0 + np.arctan2(8.0, 6.0))], rel=1e-12)
    assert {e.form for e in laws_at(DrivenJoint()) if e.family == "geometric_nonlinearity"} == {"sine", "turned"}
