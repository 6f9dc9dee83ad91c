"""The bicycle against the printed numbers of the benchmark paper, and the work of the torques at its handlebar."""

import numpy as np
import pytest

from fmus import linearise
from fmus.support.published import table
from vehicle_fmu import modes, motorcycles, over_speed, ridden
from vehicle_fmu.published import MEIJAARD_2007_EIGENVALUES

# Meijaard et al. 2007, eq. 6.2 ff.: the coefficient matrices of the benchmark bicycle as printed.
M = np.array([[80.81722, 2.31941332208709], [2.31941332208709, 0.29784188199686]])
K0 = np.array([[-80.95, -2.59951685249872], [-2.59951685249872, -0.80329488458618]])
K2 = np.array([[0.0, 76.59734589573222], [0.0, 2.65431523794604]])
C1 = np.array([[0.0, 33.86641391492494], [-0.85035641456978, 1.68540397397560]])
GRAVITY = 9.81


def bicycle():
    return motorcycles.load("benchmark_bicycle")


@pytest.mark.slow
@pytest.mark.parametrize("row", table(MEIJAARD_2007_EIGENVALUES), ids=lambda row: f"{row['speed_m_per_s']} m/s")
def test_eigenvalues_are_those_of_the_benchmark(row):
    speed = float(row["speed_m_per_s"])
    weave = float(row["weave_real"]) + 1j * float(row["weave_imag"])
    printed = np.sort_complex([float(row["caster"]), float(row["capsize"]), weave, weave.conjugate()])
    found = np.sort_complex(np.linalg.eigvals(linearise(bicycle(), speed=speed).A))
    assert found == pytest.approx(printed, abs=1e-11)  # printed to 14 decimals; LAPACK's rounding is about 1e-12 here
    weave_of_ours = modes(over_speed(ridden(bicycle())), [speed])["weave"].eigenvalue[0]
    assert weave_of_ours == pytest.approx(weave, abs=1e-11)


def test_modes_at_rest_are_those_of_an_inverted_pendulum():
    """Meijaard et al. 2007, Table 2: at rest two pairs of real eigenvalues, opposite and equal in each pair."""
    found = modes(over_speed(ridden(bicycle())), [0.0, 1.0])
    assert np.sort(found.eigenvalues[0].real) == pytest.approx([-5.53094371765393, -3.13164324790656, 3.13164324790656, 5.53094371765393], abs=1e-11)
    assert found["weave"].eigenvalue[0] == pytest.approx(5.53094371765393, abs=1e-11)
    assert found.unstable["weave"] and not found.unstable["capsize"]


@pytest.mark.parametrize("speed", [0.0, 1.0, 4.6, 12.0])
def test_matrices_are_those_of_the_benchmark(speed):
    space = linearise(bicycle(), speed=speed)
    rates = [space.states.index(n) for n in ("roll_rate", "steer_rate")]
    angles = [space.states.index(n) for n in ("roll_angle", "steer_angle")]
    assert space.A[np.ix_(rates, rates)] == pytest.approx(-np.linalg.solve(M, speed * C1), abs=1e-10)
    assert space.A[np.ix_(rates, angles)] == pytest.approx(-np.linalg.solve(M, GRAVITY * K0 + speed**2 * K2), abs=1e-10)
    torques = [space.inputs.index(n) for n in ("roll_torque", "steer_torque")]
    assert space.B[np.ix_(rates, torques)] == pytest.approx(np.linalg.inv(M), abs=1e-10)


@pytest.mark.slow
def test_it_is_self_stable_between_the_printed_speeds():
    found = modes(over_speed(ridden(bicycle())), np.linspace(1, 10, 91), reference_speed=10.0)
    # Printed: weave speed 4.29238253634111 m/s, capsize speed 6.02426201538837 m/s; edges are refined to 0.01 m/s.
    (weave,) = found.unstable["weave"]
    (capsize,) = found.unstable["capsize"]
    assert weave[1] == pytest.approx(4.29238253634111, abs=0.01)
    assert capsize[0] == pytest.approx(6.02426201538837, abs=0.01)


def test_without_damper_and_at_rest_energy_is_kept():
    space = linearise(bicycle(), speed=0.0)
    # x' M x + x' K0 g x = const for a standing bicycle; its derivative along every motion vanishes.
    order = [space.states.index(n) for n in ("roll_rate", "steer_rate", "roll_angle", "steer_angle")]
    A = space.A[np.ix_(order, order)]
    energy = np.block([[M, np.zeros((2, 2))], [np.zeros((2, 2)), GRAVITY * K0]])
    assert energy @ A + A.T @ energy == pytest.approx(np.zeros((4, 4)), abs=1e-9)  # of entries of about 1e3


@pytest.mark.parametrize(
    "torque, rates", [("handlebar_torque", ("steer_rate", "frame_rate")), ("frame_torque", ("frame_rate",))]
)
def test_torques_at_the_handlebar_do_the_work_of_the_port(torque, rates):
    """The generalised force of a torque is the rate that it works on, per generalised rate: T_h (s + w) + T_f w."""
    space = linearise(bicycle(), speed=0.0)
    columns = [space.states.index(n) for n in ("roll_rate", "steer_rate")]
    work = sum(space.C[space.outputs.index(rate), columns] for rate in rates)
    accelerations = space.B[columns, space.inputs.index(torque)]
    assert M @ accelerations == pytest.approx(work, abs=1e-10)


def test_a_riders_share_of_inertia_is_an_inertia_about_the_steer_axis_of_the_front_frame():
    share = 3.0  # kg.m2: large, so that no part of it hides
    p = bicycle().values
    S, c = np.sin(p["caster_angle"]), np.cos(p["caster_angle"])
    heavier = bicycle().with_values(front_frame_xx=p["front_frame_xx"] + share * S**2, front_frame_zz=p["front_frame_zz"] + share * c**2,
                                    front_frame_xz=p["front_frame_xz"] + share * S * c)  # fmt: skip
    expected, found = (linearise(b, speed=6.0) for b in (heavier, bicycle().with_values(added_steer_inertia=share)))
    np.testing.assert_allclose(found.A, expected.A, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(found.B, expected.B, rtol=1e-12, atol=1e-12)
