"""The steering dampers: equal and opposite torques, the forces of their laws, and energy that only goes in."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmus import linearise
from vehicle_fmu import InerterCompensator, LinearDamper, ProgressiveDamper, dampers

rates = st.floats(-20, 20)
coefficients = st.floats(0, 100)


def torques(damper, steer_rate, state=()):
    inputs = {"steer_angle": 0.1, "steer_rate": steer_rate, "frame_rate": 0.3}
    _, outputs = damper.derivatives(np.array(state, float), np.array([inputs[n] for n in damper.inputs]))
    return dict(zip(damper.outputs, outputs, strict=True))


@given(c=coefficients, s=rates)
def test_linear_damper(c, s):
    assert torques(LinearDamper(damping=c), s) == {"handlebar_torque": -c * s, "frame_torque": c * s}


@given(c=coefficients, growth=coefficients, s=rates)
def test_progressive_damper(c, growth, s):
    found = torques(ProgressiveDamper(damping=c, progression=growth), s)
    assert found["handlebar_torque"] == pytest.approx(-np.sign(s) * (c * abs(s) + growth * s**2), rel=1e-12)
    assert found["frame_torque"] == -found["handlebar_torque"]


@given(b=st.floats(0.01, 10), c=st.floats(0.1, 100), frequency=st.floats(0.1, 20))
def test_inerter_compensator_is_the_series_of_its_two_elements(b, c, frequency):
    """In series the mobilities add: 1/c of the damper and 1/(i omega b) of the inerter."""
    omega = 2 * np.pi * frequency
    space = linearise(InerterCompensator(inertance=b, damping=c))
    torque = space.frequency_response(np.array(omega), "handlebar_torque", "steer_rate")
    assert torque == pytest.approx(-1 / (1 / c + 1 / (1j * omega * b)), rel=1e-9)


@given(b=st.floats(0.01, 10), c=st.floats(0.1, 100), s=rates, z=rates)
def test_what_the_inerter_stores_and_the_damper_burns_is_what_goes_in(b, c, s, z):
    damper = InerterCompensator(inertance=b, damping=c)
    (z_dot,), _ = damper.derivatives(np.array([z]), np.array([0.0, s, 0.0]))
    power_in = -torques(damper, s, [z])["handlebar_torque"] * s
    assert power_in == pytest.approx(b * z * z_dot + c * (s - z) ** 2, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("name, damping", [("low_2011", 0.5), ("medium_2011", 4.0), ("high_2011", 7.5)])
def test_dampers_of_the_2011_paper_by_its_equation_14(name, damping):
    omega = 2 * np.pi * np.array([0.5, 2.0, 12.0])
    space = linearise(dampers.load(name))
    frame = 1j * omega * space.frequency_response(omega, "frame_torque", "steer_rate")
    assert frame == pytest.approx(1j * omega * damping)
    handlebar = 1j * omega * space.frequency_response(omega, "handlebar_torque", "steer_rate")
    assert handlebar == pytest.approx(
        -1j * omega * damping
    )  # the paper prints + for both: the port's sign is that of the steer angle


def test_the_progressive_damper_is_linear_for_small_motions():
    (slope,) = linearise(ProgressiveDamper(damping=3.0, progression=5.0)).D[:1, 1]
    assert slope == -3.0
