"""The case of most hosts: a rider holding a bar with an initial rate. Its exact motion, and errors relative to it.

    I_s s' = T_h,   delta' = s,   w = 0,   and the rider's two equations

Linear, so the samples of any of its co-simulations obey x_(k+1) = P x_k in what is sampled, x = (delta, s, theta,
theta', T_h). P follows from the samples by least squares, the modes as the host has them are ln(eig P) / H
(Schmid, J. Fluid Mech. 656 (2010), dynamic mode decomposition): the coupling's errors are obtained without a fit.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fmus import Component, StateSpace, System, linearise
from fmus.export.build import build
from rider_fmu import Handlebar, riders

STEER_INERTIA = 0.6  # kg.m2, bar and arms
STRIKE = 1.0  # rad/s, rate of the bar at the start
STARTING = 3
SAMPLED = (
    "vehicle.steer_angle",
    "vehicle.steer_rate",
    "device.torso_angle",
    "device.torso_rate",
    "device.handlebar_torque",
)
AT_START = [STRIKE if name == "vehicle.steer_rate" else 0.0 for name in SAMPLED]
# (from, to, signal)
CONNECTIONS = (
    *(("vehicle", "device", n) for n in ("steer_angle", "steer_rate", "frame_rate")),
    ("device", "vehicle", "handlebar_torque"),
)


def parts() -> dict[str, Component]:
    """The bar and the mean rider of the 2011 paper."""
    return {"vehicle": Handlebar("bar", steer_inertia=STEER_INERTIA), "device": riders.load("mean_2011")}


def archives(folder: str | Path) -> dict[str, Path]:
    """Both as FMUs of FMI 2 in the folder."""
    return {name: build(part, folder).path for name, part in parts().items()}


def exact() -> StateSpace:
    """Both as one linear system, without any coupling."""
    return linearise(System("rider_on_a_bar", parts()))


def exact_motion(times: np.ndarray) -> np.ndarray:
    """The samples (n, 5) at the times (n,) [s], SI: a sum of the modes."""
    space = exact()
    start = np.array([STRIKE if name == "vehicle.steer_rate" else 0.0 for name in space.states])
    eigenvalues, shapes = np.linalg.eig(space.A)
    states = np.exp(np.multiply.outer(times, eigenvalues)) * np.linalg.solve(shapes, start) @ shapes.T
    return states.real @ space.C[[space.outputs.index(name) for name in SAMPLED]].T


def measured_eigenvalues(samples: np.ndarray, step: float, exact_ones: np.ndarray) -> np.ndarray:
    """Of the samples (n, channels) of a free motion: the eigenvalues [1/s] nearest to the exact ones.

    Channels are scaled to their largest values; what is smaller than the rounding of the samples is no direction.
    The first STARTING samples are left out: until then hosts exchange zeros, and solvers guess accelerations.
    """
    scaled = samples[STARTING:] / np.abs(samples).max(0)
    update = np.linalg.pinv(scaled[:-1], rcond=1e-11) @ scaled[1:]
    multipliers = np.linalg.eigvals(update).astype(complex)
    found = np.log(multipliers[np.abs(multipliers) > 1e-6]) / step
    return np.array([found[np.argmin(np.abs(found - each))] for each in exact_ones])


@dataclass(frozen=True)
class ModeError:
    """An oscillatory mode of a host's motion against the exact one; errors as fractions of the exact values."""

    frequency: float  # Hz, damped, exact
    damping_ratio: float  # exact
    frequency_error: float
    damping_error: float


def mode_errors(samples: np.ndarray, step: float) -> dict[str, ModeError]:
    """The slow and the fast mode of samples (n, 5) of a host."""
    eigenvalues = np.linalg.eigvals(exact().A)
    modes = eigenvalues[eigenvalues.imag > 0]
    modes = modes[np.argsort(modes.imag)]
    errors = {}
    for name, true, found in zip(("slow", "fast"), modes, measured_eigenvalues(samples, step, modes), strict=True):
        ratio, found_ratio = -true.real / abs(true), -found.real / abs(found)
        errors[name] = ModeError(true.imag / (2 * np.pi), ratio, found.imag / true.imag - 1, found_ratio / ratio - 1)
    return errors


def trajectory_error(times: np.ndarray, steer_angle: np.ndarray) -> float:
    """Largest error of the steer angle (n,) at the times (n,) over its largest exact value."""
    true = exact_motion(times)[:, 0]
    return float(np.abs(steer_angle - true).max() / np.abs(true).max())


def errors(samples: np.ndarray, step: float) -> dict:
    """Errors of modes and trajectory of samples (n, 5) at the multiples of a step [s]."""
    times = np.arange(len(samples)) * step
    return {**mode_errors(samples, step), "trajectory_error": trajectory_error(times, samples[:, 0])}

