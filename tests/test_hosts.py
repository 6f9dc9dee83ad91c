"""Other people's simulators with our FMUs inside, against exact solutions and the theory of their couplings."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from fmus.errors import InputError
from rider_fmu import riders
from scenarios.hosts import fmpy_on_a_bar, plain_c_on_a_bar
from scenarios.hosts.rider_on_a_bar import STEER_INERTIA, STRIKE, ModeError, exact_motion, mode_errors, trajectory_error

STEP = 1e-3


def struck_bar(times: np.ndarray) -> np.ndarray:
    """Steer angle, its rate, torso angle and rate by scipy from the equations as the 2011 paper prints them."""
    p = riders.load("mean_2011").values

    def rates(t, x):
        delta, s, theta, torso_rate = x
        arms = p["arm_stiffness"] * (theta - delta) + p["arm_damping"] * (torso_rate - s)
        waist = p["waist_stiffness"] * theta + p["waist_damping"] * torso_rate
        return s, arms / STEER_INERTIA, torso_rate, -(arms + waist) / p["torso_inertia"]

    return solve_ivp(rates, (0, times[-1]), [0, STRIKE, 0, 0], "DOP853", times, rtol=1e-12, atol=1e-14).y.T


def held_torque_samples(step: float, count: int, late: bool) -> np.ndarray:
    """Samples of both parts solved exactly with what they exchange held; the torque late by a step, or of the moment."""
    p = riders.load("mean_2011").values
    stiffness, damping, inertia = p["arm_stiffness"], p["arm_damping"], p["torso_inertia"]
    A = np.array([[0, 1], [-(stiffness + p["waist_stiffness"]) / inertia, -(damping + p["waist_damping"]) / inertia]])
    B = np.array([[0, 0], [stiffness / inertia, damping / inertia]])
    C, D = np.array([stiffness, damping]), -np.array([stiffness, damping])
    torso = expm(step * np.block([[A, B], [np.zeros((2, 4))]]))[:2]
    state, bar, told, torque, rows = np.zeros(2), np.array([0.0, STRIKE]), np.zeros(2), 0.0, []
    for _ in range(count):
        torque = C @ state + D @ (told if late else bar)
        rows.append([*bar, *state, torque])
        told = bar
        state = torso @ [*state, *bar]
        bar = np.array([bar[0] + step * bar[1] + step**2 * torque / (2 * STEER_INERTIA), bar[1] + step * torque / STEER_INERTIA])
    return np.array(rows)


def same_errors(found: ModeError, expected: ModeError) -> bool:
    # 1e-8 is what is left of the rounding of the samples in the eigenvalues of their update.
    return abs(found.frequency_error - expected.frequency_error) < 1e-8 and abs(found.damping_error - expected.damping_error) < 1e-8


def test_the_exact_motion_is_that_of_the_printed_equations():
    times = np.arange(501) * STEP
    # rtol 1e-12 of the integration, accumulated over 500 samples.
    np.testing.assert_allclose(exact_motion(STEP, 501)[:, :4], struck_bar(times), atol=1e-10)


@pytest.mark.parametrize("late", [True, False])
def test_the_modes_of_samples_are_the_eigenvalues_of_what_made_them(late):
    errors = mode_errors(held_torque_samples(STEP, 1000, late), STEP)
    # A held torque is on average H / 2 late, one that comes late 3 H / 2; the arms are stiff, so that H k_a / 2 of
    # their stiffness acts as negative damping beside the waist's (first order, the next is (H k_a / c_a)^2 = 0.3 %).
    p = riders.load("mean_2011").values
    expected = p["arm_stiffness"] * STEP / (2 * p["waist_damping"]) * (-1 if late else 1)
    assert errors["slow"].damping_error == pytest.approx(expected, rel=0.15)


@pytest.fixture(scope="module", autouse=True)
def cache_of_module(cache):
    """Runs that serve several tests keep to the cache of the tests, too."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MOTOFMI_CACHE", str(cache))
        yield


@pytest.fixture(scope="module")
def fmpys():
    return fmpy_on_a_bar.run(STEP)


class TestFmpy:
    def test_simulate_fmu_records_what_follows_an_input_at_once_one_step_late(self, fmpys):
        # The rest of the response is known to 1e-16, so that only rounding is left: 1e-9 of a step.
        assert fmpys["simulate_fmu"]["lag_in_steps"] == pytest.approx(1, abs=1e-9)
        # Stiffness and damping of the arms, a step late, are 20 rad/s * 1 ms = 2 % off; the torque left of them and
        # the torso's is smaller, so more than that.
        assert fmpys["simulate_fmu"]["torque_error"] > 0.02

    @pytest.mark.parametrize(("name", "late"), [("ssp", True), ("loop", False)])
    @pytest.mark.parametrize("mode", ["slow", "fast"])
    def test_modes_are_those_of_the_coupling(self, fmpys, name, late, mode):
        expected = mode_errors(held_torque_samples(STEP, 1000, late), STEP)
        assert same_errors(fmpys[name][mode], expected[mode])


class TestPlainC:
    def test_rows_are_near_the_exact_solution(self):
        rows = plain_c_on_a_bar.rows(STEP, 1.0)
        np.testing.assert_array_equal(rows[:, 0], np.arange(1001) * STEP)
        true = struck_bar(rows[:, 0])
        # Second order: what is left out is T'' H^3 / 6 I in the rate, 0.03 ms of phase at most; measured 4.5e-5.
        assert np.abs(rows[:, 1] - true[:, 0]).max() < 1e-4 * np.abs(true[:, 0]).max()

    def test_the_error_falls_with_the_square_of_the_step(self):
        coarse, fine = (trajectory_error(plain_c_on_a_bar.rows(h, 1.0)[:, 1:], h) for h in (2e-3, 1e-3))
        # The third order adds H |lambda| = 6 % of the error at 1 ms and twice that at 2 ms.
        assert coarse / fine == pytest.approx(4, rel=0.15)

    def test_the_slow_mode_is_a_thousand_times_nearer_than_with_torques_exchanged_alone(self):
        slow = plain_c_on_a_bar.run(STEP)["plain_c"]["slow"]
        held = mode_errors(held_torque_samples(STEP, 1000, late=False), STEP)["slow"]
        assert abs(slow.damping_error) < 1e-3 * abs(held.damping_error)

    def test_without_the_source_it_says_where_it_is(self, monkeypatch, tmp_path):
        monkeypatch.setattr(plain_c_on_a_bar, "SOURCE", tmp_path / "rider_on_a_bar.c")
        with pytest.raises(InputError, match="checkout"):
            plain_c_on_a_bar.run()
