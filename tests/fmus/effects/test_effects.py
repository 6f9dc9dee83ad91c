"""An effect adds to named quantities: the sum is what a component with the term written in would give."""

from typing import ClassVar

import numpy as np
import pytest

from fmus import Effect, InputError, adds_to, linearise, parameter, state
from fmus.equations.sympy_form import symbolic
from tests.fmus.declaration.test_component import Pendulum

STATE, INPUT = np.array([0.5, 3.0]), np.array([7.0])


class Hardening(Effect):
    """Adds to a local."""

    cubic_stiffness = parameter("N.m/rad3", "Cubic stiffness", symbol="k_3", min=0, max=100, start=16)

    @adds_to("spring_torque")
    def cubic(self, v, m):
        return -v.cubic_stiffness * v.angle**3


class AddedMass(Effect):
    """Adds to the mass matrix."""

    added_inertia = parameter("kg.m2", "Added inertia", symbol="J_a", min=0, max=10, start=2)

    @adds_to("mass(rate, rate)")
    def inertia(self, v, m):
        return v.added_inertia


class Maxwell(Effect):
    """Brings a state and a rate of its own, and adds to a rate of the component."""

    dashpot = parameter("N.m.s/rad", "Damping in series", symbol="c_m", min=0.1, max=100, start=4)
    series_torque = state("N.m", "Torque of the branch", symbol="T_m")

    @adds_to("der(series_torque)")
    def relaxation(self, v, m):
        return 10 * v.rate - 10 / v.dashpot * v.series_torque

    @adds_to("der(rate)")
    def torque_of_the_branch(self, v, m):
        return -v.series_torque


class Sensor(Effect):
    """Adds to an input and to an output of the component."""

    offset = parameter("N.m", "Offset of the torque", symbol="o", min=-10, max=10, start=1)

    @adds_to("torque")
    def drift(self, v, m):
        return v.offset

    @adds_to("energy")
    def lost(self, v, m):
        return -v.torque


def test_an_addition_to_a_local():
    rates, _ = Pendulum(effects=[Hardening()]).derivatives(STATE, INPUT)
    assert rates == pytest.approx([3.0, (7.0 - 8 * 0.5 - 16 * 0.5**3) / 2])


def test_an_addition_to_the_mass_matrix():
    rates, _ = Pendulum(effects=[AddedMass()]).derivatives(STATE, INPUT)
    assert rates == pytest.approx([3.0, (7.0 - 8 * 0.5) / (2 + 2)])


def test_a_state_of_its_own():
    component = Pendulum(effects=[Maxwell()])
    assert component.states == ("angle", "rate", "series_torque")
    rates, _ = component.derivatives(np.array([0.5, 3.0, 6.0]), INPUT)
    assert rates == pytest.approx([3.0, (7.0 - 8 * 0.5 - 6.0) / 2, 10 * 3.0 - 10 / 4 * 6.0])


def test_additions_to_an_input_and_an_output():
    rates, outputs = Pendulum(effects=[Sensor()]).derivatives(STATE, INPUT)
    assert rates == pytest.approx([3.0, (7.0 + 1.0 - 8 * 0.5) / 2])
    assert outputs == pytest.approx([0.5, 10.0 - 8.0])


def test_several_effects_add_up_and_carry_their_parameters():
    component = Pendulum().with_effects(Hardening(), AddedMass()).with_values(cubic_stiffness=32.0, added_inertia=1.0)
    rates, _ = component.derivatives(STATE, INPUT)
    assert rates[1] == pytest.approx((7.0 - 8 * 0.5 - 32 * 0.5**3) / (2 + 1))


def test_the_jacobian_knows_of_them():
    space = linearise(Pendulum(effects=[Hardening(), AddedMass()]), angle=0.5)
    assert space.A == pytest.approx(np.array([[0, 1], [-(8 + 3 * 16 * 0.5**2) / 4, 0]]))


def test_a_component_with_effects_does_not_share_its_symbols_with_one_without():
    assert symbolic(Pendulum()) is symbolic(Pendulum(stiffness=1.0))
    assert symbolic(Pendulum()) is not symbolic(Pendulum(effects=[Hardening()]))


def test_a_clash_of_names_is_refused():
    class Rival(Effect):
        """Declares what is there already."""

        stiffness = parameter("N.m/rad", "Another stiffness")

    with pytest.raises(InputError, match="effect Rival and Pendulum both declare stiffness"):
        Pendulum(effects=[Rival()])


def test_a_target_that_is_not_there_is_refused():
    class Lost(Effect):
        """Adds to nothing."""

        gain = parameter("1", "Gain")

        @adds_to("waist_torque")
        def nowhere(self, v, m):
            return v.gain

    with pytest.raises(InputError, match="adds to 'waist_torque', which Pendulum does not have"):
        symbolic(Pendulum(effects=[Lost()]))


def test_what_the_sensor_of_a_state_shows_is_an_output_beside_the_state():
    class Late(Effect):
        """The angle is shown late, and bent."""

        lag = parameter("s", "Lag", min=1e-3, max=1, start=0.02)

        @adds_to("angle")
        def shown(self, v, m):
            return -v.lag * v.rate + v.angle**3

    bent = Pendulum().with_effects(Late())
    assert bent.sensor_output("angle") == "angle_shown" and bent.sensor_output("rate") == "rate"
    space = linearise(bent, angle=0.5)
    rows = dict(zip(space.outputs, space.C, strict=True))
    # A model exchange importer sets the state and reads it again: it is no other number.
    assert rows["angle"] == pytest.approx([1.0, 0.0])
    assert rows["angle_shown"] == pytest.approx([1 + 3 * 0.5**2, -0.02])
    assert not [n for n in Pendulum().outputs if n.endswith("_shown")]


def test_the_quantities_that_terms_read_are_those_of_their_formulas():
    class Late(Effect):
        """A delayed spring beside drag, with a method that adds nothing."""

        stiffness = parameter("N.m/rad", "Stiffness", start=1.0)
        delay = parameter("s", "Delay", min=1e-3, max=1, start=0.1)
        delayed: ClassVar = {"late": ("deflection", "delay")}

        @adds_to("force")
        def spring(self, v, m):
            return v.stiffness * v.late

        @adds_to("force")
        def drag(self, v, m):
            return m.absolute(v.rate) * v.rate

        def unused(self, v, m):
            return v.velocity

    assert Late.reads() == {"stiffness", "late", "deflection", "rate"}
