"""The passive rider against the papers' equations and tables, and the bookkeeping of its momentum and energy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmus import System, linearise
from fmus.expressions.functions import NUMERIC
from rider_fmu import Handlebar, PassiveRider, riders

NAMES = [n for n in riders.names() if riders.contents(n)["component"] == "PassiveRider"]
OMEGA = 2 * np.pi * np.linspace(0.5, 12, 24)  # rad/s


def torque_per_steer_angle(rider, torque):
    space = linearise(rider)
    return (space.frequency_response(OMEGA, torque, "steer_angle")
            + 1j * OMEGA * space.frequency_response(OMEGA, torque, "steer_rate"))  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_transfer_functions_are_equations_11_and_13_of_the_2011_paper(name):
    rider = riders.load(name)
    I_t, k_a, k_t, c_a, c_t = (
        rider.values[n] for n in ("torso_inertia", "arm_stiffness", "waist_stiffness", "arm_damping", "waist_damping")
    )
    resonance = -(OMEGA**2) * I_t + 1j * OMEGA * (c_a + c_t) + k_a + k_t
    arms, waist = 1j * OMEGA * c_a + k_a, 1j * OMEGA * c_t + k_t
    handlebar = -arms * (waist - OMEGA**2 * I_t) / resonance
    assert torque_per_steer_angle(rider, "handlebar_torque") == pytest.approx(handlebar, rel=1e-10)
    assert torque_per_steer_angle(rider, "frame_torque") == pytest.approx(arms * waist / resonance, rel=1e-10)


@pytest.mark.parametrize("name", NAMES)
def test_on_the_rig_it_is_equation_4_of_the_papers(name):
    """M q'' + C q' + K q = (M_s, 0), q = (steer angle, torso angle), also with a cross inertia (2008, eqs 3 and 4)."""
    rider, I_s, I_cc = riders.load(name, cross_inertia=0.03), 0.2, 0.03
    p = rider.values
    M = np.array([[I_s, I_cc], [I_cc, p["torso_inertia"]]])
    C, K = (
        np.array([[a, -a], [-a, a + t]])
        for a, t in ((p["arm_damping"], p["waist_damping"]), (p["arm_stiffness"], p["waist_stiffness"]))
    )
    impedance = -(OMEGA[:, None, None] ** 2) * M + 1j * OMEGA[:, None, None] * C + K
    inertance = -(OMEGA**2) * np.linalg.inv(impedance)[:, 0, 0]
    # The bar's inertia includes what the cross inertia takes from it: port_inertia is -I_cc^2 / I_t for a rider without
    # a share of its own.
    alone = rider.with_values(added_steer_inertia=0)
    share = alone.run(alone.start_values(), NUMERIC)["port_inertia"]
    rig = System("rig", {"bar": Handlebar(steer_inertia=I_s + share), "rider": rider})
    found = linearise(rig).frequency_response(OMEGA, "bar.steer_acceleration", "bar.servo_torque")
    assert found == pytest.approx(inertance, rel=1e-9)


positive = st.floats(0.05, 5.0)


@pytest.mark.slow
@given(factors=st.tuples(*[positive] * 5), cross=st.floats(-0.3, 0.3), motion=st.tuples(*[st.floats(-3, 3)] * 5))
def test_torques_and_momentum_balance(factors, cross, motion):
    """Newton's third law: what the rider puts on bar and frame is what its momentum loses, cross inertia aside."""
    names = ("torso_inertia", "arm_stiffness", "waist_stiffness", "arm_damping", "waist_damping")
    base = riders.load("mean_2011")
    rider = base.with_values(cross_inertia=cross * base.values["torso_inertia"],
                             **{n: base.values[n] * f for n, f in zip(names, factors, strict=True)})  # fmt: skip
    rates, outputs = rider.derivatives(np.array(motion[:2]), np.array(motion[2:]))
    torques = dict(zip(rider.outputs, outputs, strict=True))
    ratio = rider.values["cross_inertia"] / rider.values["torso_inertia"]
    # T_h = T_a + ratio (T_a + T_w) and P' = -(T_a + T_w), so the arm torque alone is T_h + ratio P'.
    total = torques["handlebar_torque"] + ratio * rates[1] + torques["frame_torque"]
    assert total == pytest.approx(-rates[1], rel=1e-9, abs=1e-9)


@given(
    factors=st.tuples(*[positive] * 5),
    frequency=st.floats(0.2, 20),
    frame=st.complex_numbers(max_magnitude=3),
    steer=st.complex_numbers(max_magnitude=3),
)
@pytest.mark.slow
def test_it_takes_energy_over_every_cycle(factors, frequency, frame, steer):
    """Bar and frame both move, in any phase: the mean of T_h (s + w) + T_f w is not positive."""
    names = ("torso_inertia", "arm_stiffness", "waist_stiffness", "arm_damping", "waist_damping")
    base = riders.load("mean_2011")
    space = linearise(base.with_values(**{n: base.values[n] * f for n, f in zip(names, factors, strict=True)}))
    omega = np.array(2 * np.pi * frequency)
    inputs = {"steer_angle": steer / (1j * omega), "steer_rate": steer, "frame_rate": frame}
    T_h, T_f = (
        sum(space.frequency_response(omega, t, n) * x for n, x in inputs.items())
        for t in ("handlebar_torque", "frame_torque")
    )
    power = (T_h * np.conj(steer + frame) + T_f * np.conj(frame)).real / 2
    size = abs(T_h * (steer + frame)) + abs(T_f * frame)
    assert power <= 1e-9 * size


def test_turning_as_a_whole_with_the_frame_is_felt_as_inertia():
    """Bar, frame and rider turn together at w: the rider's torques on both add up to minus its inertia times w'."""
    rider = riders.load("mean_2011").with_values(arm_stiffness=1e6, waist_stiffness=1e6)
    space = linearise(rider)
    omega = 2 * np.pi * 0.05  # rad/s: far below the torso's resonance, which is above 280 Hz with these springs
    total = sum(space.frequency_response(omega, t, "frame_rate") for t in ("handlebar_torque", "frame_torque"))
    assert total == pytest.approx(-1j * omega * rider.values["torso_inertia"], rel=1e-6)


@pytest.mark.parametrize("arm_damping", [26.1, 50.0, 500.0, 1e4])
def test_rider_4_of_2008_holds_for_every_arm_damping_that_overdamps_it(arm_damping):
    from_bound_up = rig_damping(riders.load("4_2008").with_values(arm_damping=arm_damping), 0.193)
    assert from_bound_up[0] == pytest.approx(0.32, abs=0.01)  # one unit of the last printed digit
    assert from_bound_up[1] is None  # two real roots


def test_rider_4_of_2008_oscillates_twice_below_that_bound():
    assert rig_damping(riders.load("4_2008").with_values(arm_damping=25.8), 0.193)[1] is not None


def rig_damping(rider: PassiveRider, steer_inertia):
    """Damping ratios of the slow pair and of the fast one, None for that where it is two real roots."""
    p = rider.values
    M = np.diag([steer_inertia, p["torso_inertia"]])
    C, K = (
        np.array([[a, -a], [-a, a + t]])
        for a, t in ((p["arm_damping"], p["waist_damping"]), (p["arm_stiffness"], p["waist_stiffness"]))
    )
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    pairs = sorted((z for z in np.linalg.eigvals(A) if z.imag > 0), key=abs)
    ratios = [-z.real / abs(z) for z in pairs]
    return ratios[0], ratios[1] if len(ratios) > 1 else None


@pytest.mark.parametrize("name", NAMES)
def test_the_share_of_inertia_at_the_bar_is_the_printed_one_less_the_bare_bar(name):
    contents = riders.contents(name)
    share = contents["printed"]["steer_inertia"]["value"] - contents["about"]["handlebar_inertia"]["value"]
    assert riders.load(name).values["added_steer_inertia"] == pytest.approx(share, abs=1e-12)


def test_assumed_dampings_are_marked():
    assert set(riders.load("1_2008").assumed) == set(riders.load("4_2008").assumed) == {"arm_damping", "waist_damping"}
    assert not any(riders.load(n).assumed for n in NAMES if n not in ("1_2008", "4_2008"))
