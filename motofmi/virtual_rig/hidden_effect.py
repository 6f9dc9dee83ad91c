"""A simulated rig with a hidden effect: draws a rider and an effect, and writes recordings that do not mention it.

    python -m motofmi.virtual_rig.hidden_effect SEED FOLDER TRUTH.json

It shares no code with the gap workflow: it integrates the rider on an imposed angle by Runge-Kutta steps,

    I_t theta'' = -T_a - k_t theta - c_t theta',    T_a = -F(d, d'),    d = delta - theta
    M_s = I_s delta'' + F + friction

with F = k_a d + c_a d' and the effect in it. Noise and converters are those of a 12-bit rig.
"""

import json
import sys
from math import copysign, tanh
from pathlib import Path

import numpy as np

from motofmi.frequency_response.excitation import Excitation, stepped_sine, sweep
from rider_fmu.rigs.handlebar import HANDLEBAR_INERTIA

RATE, FINER = 128, 8  # sampling rate [Hz], integration steps per sample
MEAN = {"It": 0.6441, "ka": 1053.4, "kt": 75.8, "ca": 19.28, "ct": 4.79}  # 2011, Table 2
BETWEEN_RIDERS, BETWEEN_RUNS = 0.2, 0.03
ANGLE_NOISE, TORQUE_NOISE, REMNANT = np.radians(0.03), 0.2, 0.4  # rad, N.m, N.m below 2 Hz
ANGLE_STEP, TORQUE_STEP = np.radians(40) / 4096, 400 / 4096
# The effects that may be hidden: name in the library, parameter, and the range from which its value is drawn.
HIDDEN = {
    "coulomb_friction": ("friction_torque", 0.3, 0.8),
    "hardening_stiffness": ("cubic_stiffness", 3e3, 1.5e4),
    "progressive_damping": ("coefficient", 0.3, 1.0),
    "backlash": ("half_gap", 5e-4, 2e-3),
    "asymmetry": ("ratio", 0.01, 0.05),
}


def main(seed: int, folder: Path, truth: Path) -> None:
    """Write three recordings and rig.json into the folder, and the hidden effect with its values into `truth`."""
    rng = np.random.default_rng(seed)
    name = str(rng.choice(list(HIDDEN)))
    parameter, low, high = HIDDEN[name]
    size = float(rng.uniform(low, high))
    rider = {k: v * np.exp(BETWEEN_RIDERS * rng.standard_normal()) for k, v in MEAN.items()}
    folder.mkdir(parents=True, exist_ok=True)
    tests = {"sweep_up_2deg": sweep(0.5, 12, 90, np.radians(2)),
             "stepped_4deg": stepped_sine(np.arange(0.5, 8.1, 1.5), seconds=10.0),
             "holdout_sweep_down_3deg": sweep(12, 0.5, 80, np.radians(3))}  # fmt: skip
    for test, excitation in tests.items():
        today = {k: v * np.exp(BETWEEN_RUNS * rng.standard_normal()) for k, v in rider.items()}
        record(folder / f"{test}.csv", excitation, today, name, size, rng)
    (folder / "rig.json").write_text(
        json.dumps(
            {
                "handlebar_inertia": {
                    "value": HANDLEBAR_INERTIA,
                    "standard_error": 0.01 * HANDLEBAR_INERTIA,
                    "unit": "kg.m2",
                }
            }
        )
    )
    truth.write_text(json.dumps({"name": name, "parameter": parameter, "value": size, "rider": rider}))


def record(
    path: Path, excitation: Excitation, rider: dict[str, float], name: str, size: float, rng: np.random.Generator
) -> None:
    """Simulate one run and write the recorded channels."""
    fine = RATE * FINER
    time = np.arange(round(excitation.duration * RATE) * FINER) / fine
    angle, rate = excitation.motion(time)
    half = excitation.motion(time + 0.5 / fine)
    torque = device_torque(
        angle.tolist(), rate.tolist(), half[0].tolist(), half[1].tolist(), 1 / fine, rider, name, size
    )
    measured = HANDLEBAR_INERTIA * np.gradient(rate, 1 / fine)[::FINER] + np.array(torque[::FINER])
    n = len(measured)
    spectrum = np.fft.rfft(rng.standard_normal(n)) * (np.fft.rfftfreq(n, 1 / RATE) < 2)
    remnant = np.fft.irfft(spectrum, n)
    measured += REMNANT * remnant / remnant.std() + TORQUE_NOISE * rng.standard_normal(n)
    shown = angle[::FINER] + ANGLE_NOISE * rng.standard_normal(n)
    table = np.column_stack(
        [
            time[::FINER],
            angle[::FINER],
            ANGLE_STEP * np.round(shown / ANGLE_STEP),
            TORQUE_STEP * np.round(measured / TORQUE_STEP),
        ]
    )
    np.savetxt(
        path,
        table,
        "%.9g",
        ",",
        header="time [s],steer_angle_command [rad],steer_angle [rad],steer_torque [N.m]",
        comments="",
    )


def device_torque(
    angle: list,
    rate: list,
    angle_half: list,
    rate_half: list,
    h: float,
    rider: dict[str, float],
    name: str,
    size: float,
) -> list:
    """The torque that the rider opposes to the bar at every time (n,), besides the bar's own inertia [N.m]."""
    It, ka, kt, ca, ct = (float(rider[k]) for k in ("It", "ka", "kt", "ca", "ct"))
    cubic = size if name == "hardening_stiffness" else 0.0
    square = size if name == "progressive_damping" else 0.0
    gap = size if name == "backlash" else 0.0
    lopsided = size * ka if name == "asymmetry" else 0.0
    friction = size if name == "coulomb_friction" else 0.0

    def arm(d: float, dd: float) -> float:
        felt = d - copysign(min(abs(d), gap), d) if gap else d
        return ka * felt + ca * dd + cubic * d**3 + square * abs(dd) * dd + lopsided * abs(d)

    def slope(theta: float, omega: float, a: float, r: float) -> float:
        return (arm(a - theta, r - omega) - kt * theta - ct * omega) / It

    theta = omega = 0.0
    torque = []
    for k in range(len(angle)):
        a, r = angle[k], rate[k]
        torque.append(arm(a - theta, r - omega) + friction * tanh(r / 0.02))
        am, rm = angle_half[k], rate_half[k]
        ae, re = (angle[k + 1], rate[k + 1]) if k + 1 < len(angle) else (am, rm)
        k1 = slope(theta, omega, a, r)
        w2 = omega + h / 2 * k1
        k2 = slope(theta + h / 2 * omega, w2, am, rm)
        w3 = omega + h / 2 * k2
        k3 = slope(theta + h / 2 * w2, w3, am, rm)
        w4 = omega + h * k3
        k4 = slope(theta + h * w3, w4, ae, re)
        theta += h / 6 * (omega + 2 * w2 + 2 * w3 + w4)
        omega += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return torque


if __name__ == "__main__":
    main(int(sys.argv[1]), Path(sys.argv[2]), Path(sys.argv[3]))
