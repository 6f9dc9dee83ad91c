"""How a component is declared, and what it says when it is declared or used wrongly."""

import numpy as np
import pytest

from fmus import Component, InputError, calculated, input, local, output, parameter, state
from fmus.equations.sympy_form import symbolic


class Pendulum(Component):
    """A physical pendulum with a mass matrix, to try the base class on."""

    inertia = parameter("kg.m2", "Inertia", symbol="J", min=0.01, max=10, start=2)
    stiffness = parameter("N.m/rad", "Stiffness", symbol="k", min=0, max=100, start=8)
    torque = input("N.m", "Torque", symbol="T")
    angle = state("rad", "Angle", symbol="q", exposed=True)
    rate = state("rad/s", "Rate", symbol=r"\dot q")
    energy = output("J", "Energy", symbol="E")
    frequency = calculated("rad/s", "Natural frequency", symbol=r"\omega")
    spring_torque = local("N.m", "Torque of the spring", symbol="T_s")

    def mass(self, v, m):
        return {("rate", "rate"): v.inertia}

    def equations(self, v, m):
        v.spring_torque = -v.stiffness * v.angle
        return {
            "der(angle)": v.rate,
            "der(rate)": v.torque + v.spring_torque,
            "energy": v.inertia * v.rate**2 / 2 + v.stiffness * v.angle**2 / 2,
            "frequency": m.sqrt(v.stiffness / v.inertia),
        }


def test_the_table_is_in_the_order_of_declaration():
    component = Pendulum()
    assert component.states == ("angle", "rate")
    assert component.inputs == ("torque",)
    assert component.outputs == ("angle", "energy")
    assert [row.name for row in component.table.values()] == list(component.table)


def test_derivatives_solve_the_mass_matrix():
    rates, outputs = Pendulum().derivatives(np.array([0.5, 3.0]), np.array([7.0]))
    assert rates == pytest.approx([3.0, (7.0 - 8 * 0.5) / 2])
    assert outputs == pytest.approx([0.5, 9.0 + 1.0])


def test_run_gives_locals_and_calculated_parameters_too():
    from_numbers = Pendulum().run({**Pendulum().start_values(), "angle": 0.25}, _Roots())
    assert from_numbers["spring_torque"] == -2.0
    assert from_numbers["frequency"] == 2.0


class _Roots:
    """The one word that the pendulum needs."""

    @staticmethod
    def sqrt(x):
        return x**0.5


def test_values_can_be_changed_without_touching_the_original():
    first = Pendulum("first", "a source", stiffness=3.0)
    second = first.with_values(stiffness=4.0)
    assert (first.values["stiffness"], second.values["stiffness"]) == (3.0, 4.0)
    assert (second.name, second.source, type(second)) == ("first", "a source", Pendulum)


@pytest.mark.parametrize("values, message", [
    ({"stifness": 1.0}, "unknown parameter of Pendulum 'stifness', did you mean 'stiffness'\\? \\(valid: inertia, stiffness\\)"),
    ({"stiffness": -1.0}, "stiffness = -1 N.m/rad is outside its bounds \\[0, 100\\]"),
    ({"stiffness": float("nan")}, "stiffness = nan N.m/rad is outside its bounds"),
    ({"stiffness": float("inf")}, "stiffness = inf N.m/rad is outside its bounds"),
    ({"stiffness": "soft"}, "stiffness = 'soft' is not a number \\[N.m/rad\\]"),
])  # fmt: skip
def test_bad_values_are_named(values, message):
    with pytest.raises(InputError, match=message):
        Pendulum(**values)


def test_a_start_outside_the_bounds_moves_into_them():
    assert parameter("m", "A length", min=2.0).start == 2.0
    assert parameter("m", "A length", max=-1.0).start == -1.0


def test_variables_are_declared_in_si():
    with pytest.raises(InputError, match=r"declared in \[deg\]: declare variables in SI"):
        parameter("deg", "An angle")


class Misspelt(Pendulum):
    def equations(self, v, m):
        return {"rate": v.angel}


class Incomplete(Pendulum):
    def equations(self, v, m):
        return {"der(angle)": v.rate, "der(rate)": v.torque, "frequency": 1.0, "power": v.torque * v.rate}


class Undeclared(Pendulum):
    def equations(self, v, m):
        v.arm_torque = v.torque
        return {}


def test_equations_that_read_an_unknown_name_say_which():
    with pytest.raises(AttributeError, match="unknown variable of Misspelt 'angel', did you mean 'angle'"):
        Misspelt().derivatives(np.zeros(2), np.zeros(1))


def test_equations_that_leave_something_out_say_what():
    with pytest.raises(
        InputError, match=r"equations of Incomplete: missing: \['energy'\], not in its table: \['power'\]"
    ):
        symbolic(Incomplete())


def test_equations_that_set_an_undeclared_name_say_which():
    with pytest.raises(AttributeError, match="sets 'arm_torque', which its table does not declare as local"):
        Undeclared().derivatives(np.zeros(2), np.zeros(1))


def test_a_component_without_equations_says_so():
    class Nothing(Component):
        """Nothing."""

    with pytest.raises(NotImplementedError, match="Nothing defines no equations"):
        Nothing().derivatives(np.zeros(0), np.zeros(0))


def test_rows_are_inherited():
    assert Misspelt.declared == Pendulum.declared
    assert "stiffness" not in vars(Misspelt)


def test_infinity_is_no_value_even_where_there_are_no_bounds():
    class Unbounded(Component):
        """A component with a parameter of any size."""

        offset = parameter("N", "Offset")

    with pytest.raises(InputError, match="offset = inf N is outside its bounds"):
        Unbounded(offset=float("inf"))
