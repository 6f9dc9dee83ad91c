"""The full rider: energy, a second derivation of its equations, the linear limit, and what it refuses."""

from types import SimpleNamespace

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from fmus import InputError, linearise
from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem
from fmus.equations.sympy_form import symbolic
from fmus.export.build import build
from fmus.expressions.expression_graph import common_subexpressions
from fmus.expressions.functions import NUMERIC
from rider_fmu import FullRider, riders
from rider_fmu.components.full_rider import check_posture, on_rig
from rider_fmu.full_rider.arm_loop import arm
from rider_fmu.full_rider.limbs import motion
from rider_fmu.full_rider.reduction import matrices, reduce
from tests.truth import full_rider_by_angles

RIDER = riders.load("full_mean_2011")
WITHOUT_DAMPERS = {f"{joint}_damping": 0.0 for joint in ("waist", "shoulder", "elbow", "wrist")}
angles = st.tuples(st.floats(-0.15, 0.15), st.floats(-0.1, 0.1))
rates = st.tuples(st.floats(-5, 5), st.floats(-5, 5))


def positions(rider, steer, torso, side=1):
    at = arm(SimpleNamespace(**rider.values), NUMERIC, side, steer, torso)
    return [np.array([float(c.f) for c in point]) for point in (at.shoulder, at.elbow, at.wrist)]


# The loop ------------------------------------------------------------------------------------------


@pytest.mark.slow
@given(angles)
def test_the_loop_is_closed_and_the_elbow_bends_to_the_side_of_the_wrists_axis(at):
    p = RIDER.values
    for side in (1, -1):
        shoulder, elbow, wrist = positions(RIDER, *at, side)
        assert np.linalg.norm(elbow - shoulder) == pytest.approx(p["upper_arm_length"], rel=1e-13)
        assert np.linalg.norm(wrist - elbow) == pytest.approx(p["forearm_length"], rel=1e-13)
        c, s = np.cos(at[0]), np.sin(at[0])
        out, down = side * np.sin(p["elbow_spread"]), np.cos(p["elbow_spread"])
        axis = np.array([-out * s, out * c, down])
        # The plane of the arm contains the axis: the wrist's second revolute is parallel to the elbow's.
        assert np.dot(np.cross(elbow - shoulder, wrist - shoulder), axis) == pytest.approx(0, abs=1e-13)
        line = (wrist - shoulder) / np.linalg.norm(wrist - shoulder)
        assert np.dot(elbow - shoulder, axis - line * np.dot(line, axis)) > 0


@pytest.mark.slow
@given(angles)
def test_left_and_right_are_mirror_images(at):
    right, left = positions(RIDER, *at, 1), positions(RIDER, -at[0], -at[1], -1)
    assert np.allclose(np.array(left), np.array(right) * [1, -1, 1], atol=1e-14)


# Lagrange's equations ------------------------------------------------------------------------------


@pytest.mark.slow
@settings(max_examples=25)
@given(angles, rates)
def test_equations_are_those_of_a_second_derivation(at, moving):
    """Arms as bodies placed by angles, Lagrange's equations by differences of the energies."""
    rig = on_rig(RIDER)
    state = np.array([*at, *moving])
    values = {**rig.values, "time": 0.0, **dict(zip(rig.states, state, strict=True)), **dict.fromkeys(rig.inputs, 0.0)}
    results, entries = rig.run(values, NUMERIC), rig.mass_entries(values, NUMERIC)
    names = ("steer_rate", "torso_rate")
    M = np.array([[entries[i, j] for j in names] for i in names])
    other_M, other_f = full_rider_by_angles.equations(rig.values, np.array(at), np.array(moving))
    # Complex steps for M; the forces by differences of sixth order, whose rounding is 1e-9 of the largest torque.
    assert np.allclose(M, other_M, rtol=1e-12, atol=1e-13)
    found = np.array([results[f"der({n})"] for n in names])
    assert np.allclose(found, other_f, atol=1e-7 * max(np.abs(other_f).max(), 10.0))


@pytest.mark.study
def test_energy_is_conserved_for_five_seconds_without_dampers():
    rig = on_rig(RIDER.with_values(**WITHOUT_DAMPERS))
    form = symbolic(rig)
    lines = [*form.rates, *(form.mass[i, j] for i in (2, 3) for j in (2, 3))]
    function = sympy.lambdify(
        [form.symbols[n] for n in rig.states],
        [e.subs(_numbers(form, rig)) for e in lines],
        "math",
        cse=common_subexpressions,
    )

    def slope(_, x):
        _, _, f1, f2, m11, m12, _, m22 = function(*x)
        determinant = m11 * m22 - m12 * m12
        return [x[2], x[3], (m22 * f1 - m12 * f2) / determinant, (m11 * f2 - m12 * f1) / determinant]

    def energy(x):
        now = motion(SimpleNamespace(**rig.values), NUMERIC, tuple(x[:2]))
        kinetic = (
            (now.M11 + rig.values["bar_inertia"]) * x[2] ** 2 / 2 + now.M12 * x[2] * x[3] + now.M22 * x[3] ** 2 / 2
        )
        return kinetic + full_rider_by_angles.potential(rig.values, np.array(x[:2])).real

    start = [0.1, 0.05, 0.0, 0.0]
    solution = solve_ivp(slope, (0, 5), start, method="DOP853", rtol=1e-12, atol=1e-13, t_eval=np.linspace(0, 5, 21))
    rest = full_rider_by_angles.potential(rig.values, np.zeros(2)).real
    energies = np.array([energy(x) for x in solution.y.T]) - rest
    assert np.ptp(solution.y[0]) > 0.1  # it does swing
    assert np.abs(energies / energies[0] - 1).max() < 1e-9


def _numbers(form, rig):
    numbers = {form.symbols[n]: v for n, v in rig.values.items()}
    return {**numbers, **{form.symbols[n]: 0.0 for n in (*rig.inputs, "time")}}


@pytest.mark.study
def test_the_port_gives_back_what_it_took():
    """Without dampers P^2 / (2 M22) + U changes by the power of the port, in whatever motion of bar and frame."""
    rider = RIDER.with_values(**WITHOUT_DAMPERS)
    v = SimpleNamespace(**rider.values)

    def port_input(t):
        return 0.12 * np.sin(9 * t), 1.08 * np.cos(9 * t), 0.3 * np.sin(5 * t + 1)

    def slope(t, x):
        rates_, outputs = rider.derivatives(x[:2], np.array(port_input(t)), t)
        torque = dict(zip(rider.outputs, outputs, strict=True))
        return [
            *rates_,
            torque["handlebar_torque"] * (port_input(t)[1] + port_input(t)[2])
            + torque["frame_torque"] * port_input(t)[2],
        ]

    def energy(t, x):
        at = (port_input(t)[0], x[0])
        return (
            x[1] ** 2 / (2 * motion(v, NUMERIC, at).M22)
            + full_rider_by_angles.potential(rider.values, np.array(at)).real
        )

    solution = solve_ivp(slope, (0, 0.5), [0.0, 0.0, 0.0], method="DOP853", rtol=1e-10, atol=1e-12)
    balance = [energy(t, x) + x[2] for t, x in zip(solution.t, solution.y.T, strict=True)]
    exchanged = np.abs(solution.y[2]).max()
    assert exchanged > 1.0
    assert np.ptp(balance) < 1e-8 * exchanged  # of the integration


# The linear limit ----------------------------------------------------------------------------------


@pytest.mark.study
@pytest.mark.parametrize(
    "rider",
    [
        RIDER,
        RIDER.with_values(
            grip_half_width=0.37, elbow_spread=1.0, wrist_stiffness=80.0, waist_stiffness=250.0, waist_damping=9.0
        ),
    ],
    ids=["spread", "wide"],
)
def test_the_linear_limit_is_the_linear_rider_with_what_the_bar_feels_of_the_frame(rider):
    reduced = reduce(rider)
    omega = 2 * np.pi * np.linspace(0.5, 12, 24)
    full, linear = linearise(rider), linearise(reduced.passive_rider())
    extra = reduced.steer_stiffness + 1j * omega * reduced.steer_damping
    for torque, sign in (("handlebar_torque", -1), ("frame_torque", 1)):
        by_angle = [
            s.frequency_response(omega, torque, "steer_angle")
            + 1j * omega * s.frequency_response(omega, torque, "steer_rate")
            for s in (full, linear)
        ]
        expected = by_angle[1] + sign * extra
        assert np.abs(by_angle[0] / expected - 1).max() < 1e-8
        # The frame's rate adds to the steer rate in the inertias only.
        by_frame = [s.frequency_response(omega, torque, "frame_rate") for s in (full, linear)]
        assert np.abs(by_frame[0] - by_frame[1]).max() < 1e-8 * np.abs(by_frame[1]).max()


@pytest.mark.slow
def test_where_both_axes_are_one_the_papers_equations_hold_without_a_steer_stiffness():
    """Bar and torso turning about one axis: turning both by one angle deflects neither elbow, shoulder nor wrist."""
    one_axis = {"saddle_distance": 0.0, "saddle_drop": 0.08, "hip_rise": 0.08, "torso_inclination": -0.4715, "torso_length": 0.3,
                "grip_setback": -0.35, "grip_rise": 0.1, "grip_half_width": 0.25, "gravity": 0.0}  # fmt: skip
    rider = RIDER.with_values(**one_axis, shoulder_stiffness=150.0, wrist_stiffness=40.0)
    reduced = reduce(rider)
    assert reduced.arm_stiffness > 100
    assert abs(reduced.steer_stiffness) < 1e-10 * reduced.arm_stiffness
    assert reduced.waist_stiffness == pytest.approx(rider.values["waist_stiffness"], rel=1e-10)
    assert abs(reduced.steer_damping) < 1e-10 * reduced.arm_damping


@pytest.mark.slow
def test_the_port_inertia_at_rest_is_that_of_the_linear_rider():
    reduced = reduce(RIDER)
    port_inertia = RIDER.run(RIDER.start_values(), NUMERIC)["port_inertia"]
    assert port_inertia == pytest.approx(reduced.steer_inertia - reduced.cross_inertia**2 / reduced.torso_inertia, rel=1e-13)


# What it refuses -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "values, words",
    [
        ({"upper_arm_length": 0.2}, "must span"),
        ({"grip_setback": -0.3}, "upper_arm_length and forearm_length allow"),
        ({"forearm_length": 0.0}, "forearm_length = 0 m is outside its bounds"),
        ({"hand_mass": -1.0}, "hand_mass = -1 kg is outside its bounds"),
        ({"forearm_centre": 0.4}, "lies beyond forearm_length"),
    ],
)
def test_a_rider_who_cannot_be_is_refused_by_name_and_bound(values, words):
    with pytest.raises(InputError, match=words) as caught:
        RIDER.with_values(**values)
    assert "\n" not in str(caught.value)


def test_too_much_steer_is_refused_where_the_arm_is_straight():
    with pytest.raises(InputError, match="left arm must span"):
        check_posture(RIDER, 0.5, 0.0)
    with pytest.raises(InputError, match="right arm must span"):
        on_rig(RIDER).derivatives(np.array([-0.5, 0.0, 0.0, 0.0]), np.zeros(len(on_rig(RIDER).inputs)))
    check_posture(RIDER, 0.25, 0.0)


def test_stiffness_is_symmetric_in_any_posture():
    """It is the Hessian of a potential."""
    for at in ((0.0, 0.0), (0.1, -0.05), (0.15, 0.1)):
        K, C = matrices(RIDER, *at)
        assert K[0, 1] == pytest.approx(K[1, 0], rel=1e-12)
        assert np.linalg.eigvalsh((C + C.T) / 2).min() > 0


def test_the_defaults_reach():
    FullRider()


@pytest.mark.study
def test_the_compiled_rider_is_the_component(tmp_path):
    """The bar held at 5 deg from rest: the torso settles as the component's does."""
    inputs = np.array([np.radians(5), 0.0, 0.0])
    solution = solve_ivp(
        lambda t, x: RIDER.derivatives(x, inputs, t)[0], (0, 0.1), [0.0, 0.0], method="DOP853", rtol=1e-10, atol=1e-12
    )
    expected = dict(zip(RIDER.outputs, RIDER.derivatives(solution.y[:, -1], inputs)[1], strict=True))
    unit = FmuSubsystem(build(RIDER, tmp_path).path, values={"steer_angle": inputs[0]})
    for _ in range(20):
        unit.step(np.vstack([inputs, np.zeros((3, 3))]), 0.005)  # constant over the step
    # Each inner step errs by 1e-10 of the angle or a hundredth of a radian.
    for name, value in expected.items():
        assert unit.get(name) == pytest.approx(value, rel=1e-6, abs=1e-7), name
    unit.close()
