r"""Disturbances of a vehicle besides its recorded inputs, and its sensor noise, by maximum likelihood.

    w_j = white + slow,   slow' = -2 pi f_j slow + 2 pi f_j sqrt(1 / (pi f_j)) sigma_j xi,     y_i = ... + r_i white
    -2 ln L = sum_k e_k' S^-1 e_k + n ln det S + |(psi - psi_0) / spread|^2

w_j act at inputs of the vehicle: a roll torque, a side force, a torque about the steer axis. psi holds the
logarithms of the spectral intensity of the white part of each, of the standard deviation sigma and corner frequency
f of its slow part (wind, road, rider), and of the standard deviation of each sensor's noise. A wide prior keeps
parameters finite that are not identifiable.

The result is the start of a fit. In the fit, factors on all of these are parameters of the base (`factors_of`), so that
no candidate is compared under the disturbances of another.

Source: Ljung, System Identification, 2nd ed. (1999), ch. 7.4; Jategaonkar, Flight Vehicle System
Identification (2006), ch. 5.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from fmus.declaration.variables import parameter
from fmus.effects import Effect
from motofmi.gap.models.kalman import Discrete, errors, sampled, sampled_noise, stationary
from motofmi.gap.preprocessing.predicted_run import PredictedRun
from motofmi.recordings.resampling import white_noise

FAMILY = "disturbance"
CORNER = 0.5  # Hz, first guess of the corner frequency
FORCES = ("roll_torque", "lateral_force", "steer_torque")  # inputs at which disturbances act
SPREAD = 3.0  # prior standard deviation of the logarithms around the first guess
CORNER_SPREAD = 1.0  # the same of corner frequencies
SCAN = np.arange(-6.0, 3.0)  # logarithms of a common factor from which the search starts
DIFFERENCE_STEP = 1e-4  # of the finite differences
NO_PREDICTION = 1e12  # -2 ln L where there is no stationary prediction


def factors_of(forces: Sequence[str], outputs: Sequence[str]) -> type[Effect]:
    """The factors of psi as parameters of an effect, in the order of psi; no equation uses them."""
    descriptions = {
        "white": "intensity of the white part of",
        "slow": "deviation of the slow part of",
        "corner": "corner of the slow part of",
    }
    rows = {
        f"{part}_{force}": f"{sentence} the disturbance {force}"
        for part, sentence in descriptions.items()
        for force in forces
    }
    rows |= {f"noise_{output}": f"noise of the sensor of {output}" for output in outputs}
    made = {
        n: parameter("1", f"Factor of the {sentence}", min=1e-12, max=1e12, start=1.0) for n, sentence in rows.items()
    }
    return type(
        "Disturbances", (Effect,), {"__doc__": "Magnitudes of disturbances and sensor noise.", "family": FAMILY, **made}
    )


@dataclass(frozen=True)
class DisturbedVehicle:
    """A vehicle on a grid of speeds (g, ...): A, B, C, D, and the input matrix of its disturbances, W (g, nx, j)."""

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    W: np.ndarray

    @property
    def forces(self) -> int:
        return self.W.shape[-1]

    def with_slow(self, corner: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """A, B and C with the states of the slow disturbances, of corners (j,) or (g, j) [Hz]."""
        grid, nx, j = self.W.shape
        A = np.zeros((grid, nx + j, nx + j))
        A[:, :nx, :nx], A[:, :nx, nx:], A[:, range(nx, nx + j), range(nx, nx + j)] = self.A, self.W, -2 * np.pi * corner
        return A, np.pad(self.B, ((0, 0), (0, j), (0, 0))), np.pad(self.C, ((0, 0), (0, 0), (0, j)))

    def discrete(self, noise: np.ndarray, step: float, held: bool) -> Discrete:
        """The matrices per step, states of slow disturbances last, for psi (k,) or (g, k)."""
        A, B, C = self.with_slow(np.exp(noise[..., 2 * self.forces : 3 * self.forces]))
        return sampled(A, B, C, self.D, step, held)

    def gains(self, noise: np.ndarray, step: float, made: Discrete) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """K (g, nx + j, ny), S (g, ny, ny) and P (g, nx + j, nx + j)."""
        j = self.forces
        white, slow, corner, sensor = np.split(np.exp(noise), [j, 2 * j, 3 * j], axis=-1)
        A, _, _ = self.with_slow(corner)
        R = sensor[..., None] ** 2 * np.eye(sensor.shape[-1])
        intensity = np.zeros_like(A)
        nx = self.A.shape[-1]
        intensity[:, :nx, :nx] = (self.W * white[..., None, :]) @ np.swapaxes(self.W, 1, 2)
        intensity[:, nx:, nx:] = (4 * np.pi * corner * slow**2)[..., None] * np.eye(j)
        return stationary(made.F, made.C, sampled_noise(A, intensity, step), R)


def first_guess(run: PredictedRun, driven: DisturbedVehicle) -> np.ndarray:
    """psi for which each force alone would cause the measured variation of the outputs."""
    y = np.concatenate([run.measured[a:b] for a, b in run.intervals])
    sensor = np.array([white_noise(c) for c in y.T]) + 1e-6 * y.std(axis=0)
    fastest = np.max(np.abs(driven.A[0]))
    size = np.array(
        [
            1.0 / max(np.max(np.abs(driven.C[0] @ w) + np.max(np.abs(driven.C[0] @ driven.A[0] @ w)) / fastest), 1e-12)
            for w in driven.W[0].T
        ]
    )
    size = size * y.std()
    return np.concatenate([np.log(size**2), np.log(size), np.full(len(size), np.log(CORNER)), np.log(sensor)])


@np.errstate(all="ignore")  # a diverging prediction has a low likelihood
def estimated(run: PredictedRun, driven: DisturbedVehicle, inputs: np.ndarray) -> np.ndarray:
    """psi of a run with inputs (n, nu), for a given vehicle."""
    guess, j = first_guess(run, driven), driven.forces
    spread = np.concatenate([np.full(2 * j, SPREAD), np.full(j, CORNER_SPREAD), np.full(len(guess) - 3 * j, SPREAD)])

    def minus_twice_log_likelihood(noise: np.ndarray) -> float:
        made = driven.discrete(noise, run.step, run.exactly_held)
        try:
            K, S, _ = driven.gains(noise, run.step, made)
        except np.linalg.LinAlgError:
            return NO_PREDICTION
        left = predicted(run, made, K, inputs)[0][run.compared]
        mean = S.mean(axis=0)
        value = float(np.einsum("ki,ij,kj->", left, np.linalg.inv(mean), left)) + len(left) * float(
            np.linalg.slogdet(mean)[1]
        )
        return value + float(np.sum(((noise - guess) / spread) ** 2)) if np.isfinite(value) else NO_PREDICTION

    shift = np.concatenate([np.full(j, 2.0), np.ones(j), np.zeros(len(guess) - 2 * j)])
    start = min((guess + s * shift for s in SCAN), key=minus_twice_log_likelihood)
    options = {"maxiter": 60, "ftol": 2e-6, "eps": DIFFERENCE_STEP}
    return minimize(minus_twice_log_likelihood, start, method="L-BFGS-B", options=options).x


def predicted(run: PredictedRun, made: Discrete, K: np.ndarray, inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The prediction errors (n, ny) and predicted states (n, nx) of a run; zero outside of its intervals."""
    _, place, share = run.speeds
    left, states = np.zeros_like(run.measured), np.zeros((len(run.measured), K.shape[1]))
    for first, last in run.intervals:
        y, u = centred(run, inputs, first, last)
        left[first:last], states[first:last] = errors(made, K, place[first:last], share[first:last], y, u)
    return left, states


def centred(run: PredictedRun, inputs: np.ndarray, first: int, last: int) -> tuple[np.ndarray, np.ndarray]:
    """Outputs (n, ny) and inputs (n + 1, nu) of a stretch without their means: offsets are not compared."""
    y, u = run.measured[first:last], inputs[first:last]
    u = np.concatenate([u, u[-1:]])
    return y - y.mean(axis=0), np.ascontiguousarray(u - u.mean(axis=0))
