"""Linearisation against closed forms, python-control and finite differences."""

import numpy as np
import pytest

from fmus import Component, InputError, input, linearise, parameter, state
from rider_fmu import riders
from tests.fmus.declaration.test_component import Pendulum
from vehicle_fmu import motorcycles, ridden


class Tippler(Component):
    """A bead on a rotating bent wire: its mass depends on where it is, so that the rates enter the Jacobian."""

    curvature = parameter("1/m", "Curvature of the wire", symbol="k", min=0, max=10, start=1.5)
    push = input("N", "Force along the wire", symbol="F")
    place = state("m", "Place", symbol="x")
    rate = state("m/s", "Rate", symbol=r"\dot x")

    def mass(self, v, m):
        return {("rate", "rate"): 1 + (v.curvature * v.place) ** 2}

    def equations(self, v, m):
        return {"der(place)": v.rate, "der(rate)": v.push - v.curvature**2 * v.place * v.rate**2 + m.sin(v.place)}


def test_a_linear_component_is_its_own_matrices():
    space = linearise(Pendulum())
    assert space.A == pytest.approx(np.array([[0, 1], [-8 / 2, 0]]))
    assert space.B == pytest.approx(np.array([[0], [1 / 2]]))
    assert (space.states, space.inputs, space.outputs) == (("angle", "rate"), ("torque",), ("angle", "energy"))


def test_the_point_matters_where_it_is_not_linear():
    space = linearise(Pendulum(), angle=0.5, rate=3.0)
    assert space.C[1] == pytest.approx([8 * 0.5, 2 * 3.0])


@pytest.mark.parametrize("place, rate, push", [(0.7, -1.3, 2.0), (-0.2, 0.4, 0.0)])
def test_a_mass_that_depends_on_the_state(place, rate, push):
    component = Tippler()
    space = linearise(component, place=place, rate=rate, push=push)
    k = component.values["curvature"]
    m = 1 + (k * place) ** 2
    force = push - k**2 * place * rate**2 + np.sin(place)
    # d/dx (force / m) = (force' m - force m') / m^2, by hand.
    expected = ((-(k**2) * rate**2 + np.cos(place)) * m - force * 2 * k**2 * place) / m**2
    assert space.A == pytest.approx(np.array([[0, 1], [expected, -2 * k**2 * place * rate / m]]), rel=1e-12)
    assert space.B == pytest.approx(np.array([[0], [1 / m]]), rel=1e-12)


def test_arrays_of_points_give_stacked_matrices():
    system = ridden(motorcycles.load("sharp_1971"), riders.load("mean_2011"))
    speeds = np.array([[3.0, 20.0, 41.0], [5.0, 6.0, 7.0]])
    stacked = linearise(system, **{"vehicle.speed": speeds})
    assert stacked.A.shape == (2, 3, 10, 10)
    for index in np.ndindex(speeds.shape):
        one = linearise(system, **{"vehicle.speed": speeds[index]})
        for name in "ABCD":
            expected = getattr(one, name)
            assert np.broadcast_to(getattr(stacked, name), (2, 3, *expected.shape))[index] == pytest.approx(
                expected, rel=1e-12, abs=1e-9
            )


def test_arrays_of_parameters_reach_the_mass_matrix():
    inertia = np.array([1.0, 2.0, 4.0])
    assert linearise(Pendulum(), inertia=inertia).A[:, 1, 0] == pytest.approx(-8 / inertia)


def test_frequency_response_is_that_of_python_control():
    space = linearise(ridden(motorcycles.load("sharp_1971"), riders.load("mean_2011")), **{"vehicle.speed": 25.0})
    omega = np.geomspace(0.3, 120, 40)
    system = space.to_control()
    expected = system(1j * omega)[system.output_index["vehicle_roll_angle"], system.input_index["vehicle_steer_torque"]]
    found = space.frequency_response(omega, "vehicle.roll_angle", "vehicle.steer_torque")
    assert found == pytest.approx(expected, rel=1e-9)


def test_an_unknown_name_is_refused_with_the_valid_ones():
    with pytest.raises(
        InputError, match=r"unknown variable of Pendulum 'tork', did you mean 'torque'\? \(valid: angle, "
    ):
        linearise(Pendulum(), tork=1.0)
