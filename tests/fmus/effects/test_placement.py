"""Laws at states, inputs and outputs of components whose states are no deflection and rate, against their formulas."""

from typing import ClassVar

import numpy as np
import pytest

from fmus import Component, Effect, Element, input, local, parameter, state
from fmus.composition.added_force import with_force_element
from fmus.effects.placement import by_name, laws_at, states_of_no_element
from fmus.mechanisms import DrivenJoint, MassSpringDamper, TwoMass
from tests.simulators.other_components import Tanks, TwoCarts

LEVELS = {"upper_level": 0.5, "level": 0.3}
RANGES = {"upper_level": (0.1, 0.7), "level": (0.2, 0.4)}


def law(component: Component, family: str, form: str, **values: float) -> tuple[type[Effect], Component]:
    """The effect of that name, and the component with it."""
    every = laws_at(component, 1.0, {"pump": 10.0}, {"level": 0.4}, RANGES, 100.0)
    found = next(e for e in every if (e.family, e.form) == (family, form))
    return found, component.with_effects(found()).with_values(**{f"{family}.{n}": x for n, x in values.items()})


def rates(component: Component, pump: float = 3.0, **more: float) -> dict[str, float]:
    """Rates and outputs by name at the levels above."""
    known = {**component.start_values(), **LEVELS, "pump": pump, **more}
    found = component.derivatives(np.array([known[n] for n in component.states]), np.array([pump]))
    names = [*(f"der({n})" for n in component.states), *component.outputs]
    return dict(zip(names, np.concatenate(found).tolist(), strict=True))


@pytest.mark.parametrize(
    ("family", "form", "values", "lost"),
    [
        ("leakage", "linear_upper_level", {"rate": 0.2}, 0.2 * 0.5),
        ("leakage", "square_upper_level", {"square_rate": 0.2}, 0.2 * 0.5**2 / 0.7),
        ("leakage", "cubic_upper_level", {"cubic_rate": 0.2}, 0.2 * 0.5**3 / 0.7**2),
        ("overflow", "lost_upper_level", {"rate": 0.2, "threshold": 0.4}, 0.2 * 0.1),
        ("overflow", "lost_upper_level", {"rate": 0.2, "threshold": 0.6}, 0.0),
    ],
)
def test_a_law_at_a_state_adds_to_its_rate_alone(family, form, values, lost):
    base, joined = rates(Tanks()), rates(law(Tanks(), family, form, **values)[1])
    assert joined["der(upper_level)"] - base["der(upper_level)"] == pytest.approx(-lost, rel=1e-12)
    assert joined["der(level)"] == base["der(level)"]
    assert joined["level"] == LEVELS["level"]  # its sensor is another place


def test_a_share_of_an_overflow_arrives_at_another_state():
    effect, tanks = law(Tanks(), "overflow", "transfer_upper_level_to_level", rate=0.2, threshold=0.4, share=0.3)
    base, joined = rates(Tanks()), rates(tanks)
    assert joined["der(upper_level)"] - base["der(upper_level)"] == pytest.approx(-0.2 * 0.1, rel=1e-12)
    assert joined["der(level)"] - base["der(level)"] == pytest.approx(0.3 * 0.2 * 0.1, rel=1e-12)
    assert (tanks.table["overflow.threshold"].unit, tanks.table["overflow.threshold"].max) == ("m", 0.7)
    assert effect.starts["threshold"] == pytest.approx((0.4, 0.49, 0.58, 0.64))  # shares of the range of the level


def test_laws_between_a_recorded_input_and_what_acts():
    gain = Tanks().values["pump_gain"]
    outflow = rates(Tanks(), pump=0.0)["der(upper_level)"]

    def acts(component: Component, pump: float, **more: float) -> float:
        return (rates(component, pump, **more)["der(upper_level)"] - outflow) / gain

    dead = law(Tanks(), "dead_zone", "threshold_pump", half_width=2.0)[1]
    assert [acts(dead, u) for u in (1.0, 5.0, -5.0)] == pytest.approx([0.0, 3.0, -3.0])
    cubic = law(Tanks(), "input_nonlinearity", "cubic_pump", cubic_gain=0.5)[1]
    assert acts(cubic, 5.0) == pytest.approx(5.0 * (1 + 0.5 * 0.25))  # half of the largest input
    late = law(Tanks(), "input_lag", "first_order_pump", time_constant=20.0)[1]
    assert acts(late, 5.0, **{"input_lag.following": 1.0}) == pytest.approx(1.0)
    found = rates(late, 5.0, **{"input_lag.following": 1.0})
    assert found["der(input_lag.following)"] == pytest.approx((5.0 - 1.0) / 20.0)
    assert late.table["input_lag.following"].unit == "V"


def test_laws_between_an_output_and_its_recording():
    clipped = law(Tanks(), "saturation", "clip_level", limit=0.2, share=1.0)[1]
    found = rates(clipped)
    assert (found["level_shown"], found["level"]) == (pytest.approx(0.2), 0.3)
    late = law(Tanks(), "sensor_lag", "first_order_level", time_constant=4.0, share=1.0)[1]
    found = rates(late, **{"sensor_lag.following": 0.1})
    assert found["level_shown"] == pytest.approx(0.1)
    assert found["der(sensor_lag.following)"] == pytest.approx((0.3 - 0.1) / 4.0)


def test_times_are_bounded_by_the_period_where_one_is_known():
    def longest(**period: float) -> dict[str, float]:
        every = laws_at(Tanks(), 1.0, {"pump": 10.0}, {"level": 0.4}, RANGES, **period)
        names = {"input_lag": "time_constant", "sensor_lag": "time_constant", "channel_delay": "delay"}
        return {e.family: e.declared[names[e.family]].max for e in every if e.family in names}

    assert longest(period=100.0) == {"input_lag": 100.0, "sensor_lag": 100.0, "channel_delay": 25.0}
    # A value file is read without a motion: it may hold the values of any.
    assert set(longest().values()) == {np.inf}


def test_a_motion_that_is_faster_than_the_usual_lag_has_laws_of_lags():
    """The start value of a time constant is within its bound, which is the period."""
    every = laws_at(Tanks(), 1.0, {"pump": 10.0}, {"level": 0.4}, RANGES, period=0.02)
    lags = [effect for effect in every if effect.family in ("input_lag", "sensor_lag")]
    assert len(lags) == 2
    for effect in lags:
        assert Tanks().with_effects(effect()).values[f"{effect.family}.time_constant"] == 0.02


class Motor(Component):
    """A motor whose current is a state beside deflection and rate."""

    inertia = parameter("kg.m2", "Inertia", min=1e-9, start=0.1)
    stiffness = parameter("N.m/rad", "Stiffness", min=0, start=10.0)
    constant = parameter("N.m/A", "Torque per current", min=0, start=1.0)
    resistance = parameter("V/A", "Resistance", min=0, start=1.0)
    inductance = parameter("V.s/A", "Inductance", min=1e-9, start=0.01)
    load = input("N.m", "Torque of the load")
    voltage = input("V", "Voltage")
    current = state("A", "Current")
    angle = state("rad", "Angle", exposed=True)
    rate = state("rad/s", "Rate")

    def equations(self, v, m):
        torque = v.constant * v.current + v.load - v.stiffness * v.angle
        back = v.constant * v.rate
        return {
            "der(current)": (v.voltage - v.resistance * v.current - back) / v.inductance,
            "der(angle)": v.rate,
            "der(rate)": torque / v.inertia,
        }


def test_states_of_force_elements_have_the_laws_of_mechanics_and_others_those_of_states():
    assert states_of_no_element(TwoMass()) == states_of_no_element(DrivenJoint()) == []
    motor = with_force_element(Motor())
    assert states_of_no_element(motor) == ["current"]
    forms = {(e.family, e.form) for e in laws_at(motor)}
    assert {("coulomb_friction", "coulomb"), ("leakage", "square_current")} <= forms
    assert not any(family == "dead_zone" for family, _ in forms)
    assert {family for family, _ in forms if family == "leakage"} and not any("rate" in form for _, form in forms)


def test_every_point_that_a_force_drives_has_the_laws_of_mechanics():
    """m v' = F - R at both carts, with dry friction of 2 N at the second one."""
    carts = with_force_element(TwoCarts())
    rubbing = next(e for e in laws_at(carts) if e.form == "coulomb_at_other_position")
    joined = carts.with_effects(rubbing()).with_values(**{"coulomb_friction.friction_torque": 2.0, "other_mass": 4.0})
    assert joined.table["coulomb_friction.friction_torque"].unit == "N"
    state = dict.fromkeys(carts.states, 0.0) | {"velocity": 3.0, "other_velocity": 3.0}
    x = np.array([state[n] for n in joined.states])
    change = joined.derivatives(x, np.zeros(2))[0] - carts.with_values(other_mass=4.0).derivatives(x, np.zeros(2))[0]
    assert dict(zip(joined.states, change, strict=True)) == pytest.approx(
        {"position": 0.0, "velocity": 0.0, "other_position": 0.0, "other_velocity": -2.0 / 4.0}
    )


class Isolated(Component):
    """A mass on a spring whose foot is moved: no input is a force."""

    stiffness = parameter("1/s2", "Stiffness over mass", min=0, start=400.0)
    foot = input("m", "Displacement of the foot")
    position = state("m", "Displacement of the mass")
    velocity = state("m/s", "Velocity of the mass")

    def equations(self, v, m):
        return {"der(position)": v.velocity, "der(velocity)": v.stiffness * (v.foot - v.position)}


class TwoIsolated(Isolated):
    """Two masses on springs with one foot: what a force between them does to each is not known."""

    upper = state("m", "Displacement of the upper mass")
    upper_velocity = state("m/s", "Velocity of the upper mass")

    def equations(self, v, m):
        return {**super().equations(v, m), "der(upper)": v.upper_velocity,
                "der(upper_velocity)": v.stiffness * (v.position - v.upper)}  # fmt: skip


def test_a_mass_that_a_motion_drives_has_the_laws_of_mechanics_per_unit_of_mass():
    """x'' = k (u - x) - F / m, with friction of 2 N/kg and quadratic drag of 3 N.s2/m2 per kg."""
    laws = by_name(laws_at(with_force_element(Isolated())))
    both = [laws[name]() for name in ("coulomb_friction.coulomb", "progressive_damping.quadratic")]
    names = {"coulomb_friction.friction_torque": 2.0, "progressive_damping.coefficient": 3.0}
    joined = with_force_element(Isolated()).with_effects(*both).with_values(**names)
    assert [joined.table[n].unit for n in names] == ["N/kg", "N.s2/m2.kg"]
    change = joined.derivatives(np.array([0.1, -0.5]), np.array([0.02]))[0]
    assert change == pytest.approx([-0.5, 400.0 * (0.02 - 0.1) + 2.0 + 3.0 * 0.5**2])


def test_a_component_without_a_force_has_the_laws_of_signals_as_well():
    families = {e.family for e in laws_at(with_force_element(Isolated()))}
    assert {"coulomb_friction", "dead_zone", "input_lag"} <= families
    assert "dead_zone" not in {e.family for e in laws_at(DrivenJoint())}


def test_masses_that_a_motion_drives_through_each_other_have_no_added_force():
    assert with_force_element(TwoIsolated()).elements == {}


class Normalised(Isolated):
    """The same mass with a force element of its own, in the unit of an acceleration."""

    pull = local("m/s2", "Force of the spring over mass")
    elements: ClassVar = {"spring": Element("pull", "position", "velocity")}

    def equations(self, v, m):
        v.pull = v.stiffness * (v.position - v.foot)
        return {"der(position)": v.velocity, "der(velocity)": -v.pull}


def test_the_laws_at_a_force_that_is_written_as_an_acceleration_are_per_unit_of_mass():
    coulomb, soft = (by_name(laws_at(Normalised()))[f"coulomb_friction.{form}"] for form in ("coulomb", "soft"))
    assert Normalised().with_effects(coulomb()).table["coulomb_friction.friction_torque"].unit == "N/kg"
    assert Normalised().with_effects(soft()).table["coulomb_friction.sliding_rate"].unit == "m/s"


class Arms(Component):
    """Two arms without gravity, a torque at each joint and explicit accelerations: both depend on both torques."""

    torque_1 = input("N.m", "Torque at the first joint", symbol="T1")
    torque_2 = input("N.m", "Torque at the second joint", symbol="T2")
    angle_1 = state("rad", "Angle of the first arm", symbol="q1")
    rate_1 = state("rad/s", "Rate of the first arm", symbol="s1")
    angle_2 = state("rad", "Angle of the second arm from the first", symbol="q2")
    rate_2 = state("rad/s", "Rate of the second arm from the first", symbol="s2")

    def equations(self, v, m):
        # M = [[4, 1.5], [1.5, 1]]: the second torque accelerates the first arm backwards.
        return {"der(angle_1)": v.rate_1, "der(rate_1)": (v.torque_1 - 1.5 * v.torque_2) / 1.75,
                "der(angle_2)": v.rate_2, "der(rate_2)": (4 * v.torque_2 - 1.5 * v.torque_1) / 1.75}  # fmt: skip


def test_a_torque_at_a_joint_belongs_to_the_rate_of_that_joint():
    """Power of friction 2 N.m at the second joint: x' M x'' = -2 |s2|, with M from the equations."""
    arms = with_force_element(Arms())
    assert {e.rate: e.force for e in arms.elements.values()} == {
        "rate_1": "resisting_force", "rate_2": "resisting_force_at_angle_2",
    }  # fmt: skip
    rubbing = next(e for e in laws_at(arms) if e.form == "coulomb_at_angle_2")
    joined = arms.with_effects(rubbing()).with_values(**{"coulomb_friction.friction_torque": 2.0})
    speeds = {"rate_1": -0.7, "rate_2": 3.0}
    x = np.array([speeds.get(n, 0.0) for n in joined.states])
    accelerations = dict(zip(joined.states, joined.derivatives(x, np.zeros(2))[0], strict=True))
    inertias = np.array([[4, 1.5], [1.5, 1]])
    power = np.array([*speeds.values()]) @ inertias @ [accelerations[n] for n in speeds]
    assert power == pytest.approx(-2.0 * 3.0)


@pytest.mark.parametrize("seed", range(20))
def test_efforts_belong_to_their_rates_for_any_mass_matrix(seed):
    generator = np.random.default_rng(seed)
    roots = generator.normal(size=(3, 3))
    inverse, order = np.linalg.inv(roots @ roots.T + 0.05 * np.eye(3)), generator.permutation(3)

    class Chain(Component):
        """Three joints with explicit accelerations; the torques are declared in another order than the rates."""

        locals().update({f"torque_{i}": input("N.m", "Torque") for i in order})
        locals().update({f"angle_{i}": state("rad", "Angle") for i in range(3)})
        locals().update({f"rate_{i}": state("rad/s", "Rate") for i in range(3)})

        def equations(self, v, m):
            efforts = [v[f"torque_{i}"] for i in range(3)]
            rows = {f"der(rate_{i})": sum(float(b) * e for b, e in zip(inverse[i], efforts, strict=True)) for i in range(3)}
            return {f"der(angle_{i})": v[f"rate_{i}"] for i in range(3)} | rows

    chain = with_force_element(Chain())
    of_rates = {element.rate: chain.points[element.force][0] for element in chain.elements.values()}
    assert of_rates == {f"rate_{i}": f"torque_{i}" for i in range(3)}


@pytest.mark.parametrize("rate", [0.5, -0.5])
@pytest.mark.parametrize(
    ("form", "values", "force"), [("bilinear", {"ratio": 0.2}, 0.2 * 3.0 * 0.5), ("quadratic", {"even_coefficient": 4.0}, 4.0 * 0.5**2)]
)
def test_a_damper_with_another_coefficient_in_each_direction_has_a_force_of_one_sign(form, values, force, rate):
    base = MassSpringDamper().with_values(mass=2.0, spring_damping=3.0)
    effect = next(e for e in laws_at(base) if (e.family, e.form) == ("damping_asymmetry", form))
    joined = base.with_effects(effect()).with_values(**{f"damping_asymmetry.{n}": x for n, x in values.items()})
    states, drive = np.array([0.1, rate]), np.zeros(1)
    change = joined.derivatives(states, drive)[0] - base.derivatives(states, drive)[0]
    assert change == pytest.approx([0.0, -force / 2.0], rel=1e-12)


@pytest.mark.parametrize(("period", "longest"), [(0.5, 0.2), (10.0, 2.5)])
@pytest.mark.parametrize(("inputs", "sign"), [({"force": 1.0}, -1), ({}, 0)])
def test_a_delay_is_in_proportion_to_a_slow_motion_and_negative_where_an_input_drives_it(inputs, sign, period, longest):
    """Where a motion is imposed, a spring whose deflection is recorded late has the force of a spring and a damper."""
    (delay,) = (e for e in laws_at(MassSpringDamper(), inputs=inputs, period=period) if e.family == "channel_delay")
    row = delay.declared["delay"]
    assert (row.min, row.max) == (sign * longest, longest)


@pytest.mark.parametrize("largest", [1e-6, 1.0, 1e3])
@pytest.mark.parametrize("period", [1e-3, 1.0, 100.0])
def test_starting_values_are_within_the_bounds_at_any_scale_of_motion_and_time(largest, period):
    """The bounds of widths, rates and times allow those of a motion of micrometres or of a kilometre."""
    laws = laws_at(MassSpringDamper(), 2 * np.pi * largest / period, period=period, largest=largest)
    outside = []
    for effect in laws:
        relative = dict.fromkeys(effect.relative, largest)
        for name, starts in effect.starts.items():
            row, scaled = effect.declared[name], [s * relative.get(name, 1.0) for s in starts]
            outside += [(effect, name) for s in scaled if not row.min <= s <= row.max]
    assert outside == []
    (maxwell,) = (e for e in laws if e.form == "maxwell")
    time = maxwell.declared["relaxation_time"]
    assert time.min <= 0.01 * period and period <= time.max
