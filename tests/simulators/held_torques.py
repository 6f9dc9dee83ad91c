"""The rider on a bar by scipy, from the printed equations, and with torques that are held over a step as masters hold them."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from motofmi.scenarios.hosts.rider_on_a_bar import STEER_INERTIA, STRIKE, ModeError, mode_errors
from rider_fmu import riders

STEP = 1e-3  # s


def struck_bar(times: np.ndarray) -> np.ndarray:
    """Steer angle, its rate, torso angle and rate by scipy from the equations as the 2011 paper prints them."""
    p = riders.load("mean_2011").values

    def rates(t, x):
        delta, s, theta, torso_rate = x
        arms = p["arm_stiffness"] * (theta - delta) + p["arm_damping"] * (torso_rate - s)
        waist = p["waist_stiffness"] * theta + p["waist_damping"] * torso_rate
        return s, arms / STEER_INERTIA, torso_rate, -(arms + waist) / p["torso_inertia"]

    return solve_ivp(rates, (0, times[-1]), [0, STRIKE, 0, 0], "DOP853", times, rtol=1e-12, atol=1e-14).y.T


def held_torque_samples(step: float, count: int, scheme: str) -> np.ndarray:
    """Samples of both parts solved exactly, with what they exchange held over a step as the scheme has it."""
    p = riders.load("mean_2011").values
    stiffness, damping, inertia = p["arm_stiffness"], p["arm_damping"], p["torso_inertia"]
    A = np.array([[0, 1], [-(stiffness + p["waist_stiffness"]) / inertia, -(damping + p["waist_damping"]) / inertia]])
    B = np.array([[0, 0], [stiffness / inertia, damping / inertia]])
    arms = np.array([stiffness, damping])
    held = expm(step * np.block([[A, B], [np.zeros((2, 4))]]))[:2]
    torso, bar, bar_input, torque, rows = np.zeros(2), np.array([0.0, STRIKE]), np.zeros(2), 0.0, []

    def bar_after_step(torque):
        return np.array(
            [bar[0] + step * bar[1] + step**2 * torque / (2 * STEER_INERTIA), bar[1] + step * torque / STEER_INERTIA]
        )

    for _ in range(count):
        if scheme == "refreshed jacobi":
            torque = arms @ (torso - bar)
        rows.append([*bar, *torso, torque])
        after = bar_after_step(torque)
        bar_input = bar if "jacobi" in scheme else after
        if scheme == "iterated":  # both with what holds at the end; contracts by H c_a / I = 0.03 an iteration
            for _ in range(15):
                bar_input = after
                after = bar_after_step(arms @ (held @ [*torso, *bar_input] - bar_input))
        torso = held @ [*torso, *bar_input]
        bar, torque = after, arms @ (torso - bar_input)
    return np.array(rows)


def expected(scheme: str) -> dict[str, ModeError]:
    return mode_errors(held_torque_samples(STEP, 1000, scheme), STEP)


def agree(found: dict, scheme: str, within: float = 1e-6) -> bool:
    """The modes of a host are those of the scheme.

    What is only in the memory of a coupling has decayed to 1e-8 in the samples, their rounding is 1e-15: 1e-7, and a
    factor for the two modes' condition. The schemes themselves differ by 1e-2 and more.
    """
    pairs = [(found[name], true) for name, true in expected(scheme).items()]
    return all(
        abs(f.frequency_error - t.frequency_error) < within and abs(f.damping_error - t.damping_error) < within
        for f, t in pairs
    )


def relative_errors(found: dict) -> list[float]:
    """The errors of measured eigenvalues of modes over their exact values [1]."""
    return [abs(mode["error"] / mode["exact"]) for mode in found.values() if isinstance(mode, dict)]
