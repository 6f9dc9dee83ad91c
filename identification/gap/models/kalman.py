r"""One-step predictions of a linear system that disturbances drive, its gain that of the stationary Kalman filter.

    x_k+1 = F x_k + G_0 u_k + G_1 u_k+1 + K e_k,     e_k = y_k - C x_k - D u_k
    P = F P F' + Q - K S K',     S = C P C' + R,     K = F P C' S^-1

Where the system changes with the speed, its matrices are interpolated between those on a grid of speeds.

Source: Kailath, Sayed, Hassibi, Linear Estimation (2000), ch. 9; Van Loan, IEEE Trans. Autom. Control 23 (1978) 395-404,
for the sampled matrices.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.linalg import expm

DOUBLINGS, WHILE = 40, 6
SETTLED = 1e-9  # change of the covariance, relative


@dataclass(frozen=True)
class Discrete:
    """Matrices per step on a grid (g, ...): F (nx, nx), G0 and G1 (nx, nu), C (ny, nx), D (ny, nu)."""

    F: np.ndarray
    G0: np.ndarray
    G1: np.ndarray
    C: np.ndarray
    D: np.ndarray

    @property
    def parts(self) -> tuple[np.ndarray, ...]:
        """All, as the compiled functions take them."""
        return tuple(np.ascontiguousarray(m) for m in (self.F, self.G0, self.G1, self.C, self.D))


def sampled(A: np.ndarray, B: np.ndarray, C: np.ndarray, D: np.ndarray, step: float, held: bool = False) -> Discrete:
    """The system (..., nx, nx), (..., nx, nu) over steps [s], its inputs joined by lines, or held."""
    nx, nu = B.shape[-2:]
    block = np.zeros((*A.shape[:-2], nx + 2 * nu, nx + 2 * nu))
    block[..., :nx, :nx], block[..., :nx, nx : nx + nu] = A * step, B * step
    block[..., nx : nx + nu, nx + nu :] = np.eye(nu)
    whole = expm(block)
    F, now, rise = whole[..., :nx, :nx], whole[..., :nx, nx : nx + nu], whole[..., :nx, nx + nu :]
    return Discrete(F, now if held else now - rise, np.zeros_like(rise) if held else rise, C, D)


def sampled_noise(A: np.ndarray, intensity: np.ndarray, step: float) -> np.ndarray:
    """The covariance (..., nx, nx) that white noise of a spectral intensity (..., nx, nx) adds to the states in a step, by Simpson's rule."""
    half = expm(A * step / 2)
    middle = half @ intensity @ _transposed(half)
    return step / 6 * (intensity + 4 * middle + half @ middle @ _transposed(half))


def stationary(F: np.ndarray, C: np.ndarray, Q: np.ndarray, R: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The gain K (..., nx, ny) and the covariance S (..., ny, ny) of the errors, by doubling. Raises LinAlgError where there is none.

    States are measured by how far the noise drives them in a while, outputs by their noise: newtons and radians are far apart.

    Source: Chu, Fan, Lin, Wang, Int. J. Control 77 (2004) 767-788.
    """
    size = _size(F, Q)
    noise = np.sqrt(np.diagonal(R, axis1=-2, axis2=-1))
    A = _transposed(F / size[..., :, None] * size[..., None, :])
    seen = C * size[..., None, :] / noise[..., :, None]
    G, H = _transposed(seen) @ seen, Q / size[..., :, None] / size[..., None, :]
    unit = np.eye(A.shape[-1])
    for _ in range(DOUBLINGS):
        inverse = np.linalg.inv(unit + G @ H)
        more = _transposed(A) @ H @ inverse @ A
        A, G, H = A @ inverse @ A, G + A @ inverse @ G @ _transposed(A), H + (more + _transposed(more)) / 2
        if np.max(np.abs(more)) <= SETTLED * np.max(np.abs(H)):
            P = H * size[..., :, None] * size[..., None, :]
            S = C @ P @ _transposed(C) + R
            K = F @ P @ _transposed(C) @ np.linalg.inv(S)
            if np.max(np.abs(np.linalg.eigvals(F - K @ C))) < 1:
                return K, S
            break  # what is unstable and does not show cannot be predicted
    raise np.linalg.LinAlgError("no stationary prediction")


def _size(F: np.ndarray, Q: np.ndarray) -> np.ndarray:
    """The deviation (..., nx) of the states after 2^WHILE steps from rest; never zero."""
    for _ in range(WHILE):
        Q, F = Q + F @ Q @ _transposed(F), F @ F
    deviation = np.sqrt(np.maximum(np.diagonal(Q, axis1=-2, axis2=-1), 0.0))
    return np.maximum(deviation, 1e-12 * deviation.max(axis=-1, keepdims=True) + 1e-300)


def _transposed(matrix: np.ndarray) -> np.ndarray:
    return np.swapaxes(matrix, -1, -2)


@njit(cache=True, fastmath={"contract"})
def _add(result, matrix, vector, share):
    """result += share matrix vector, without a temporary array."""
    for i in range(matrix.shape[0]):
        total = 0.0
        for j in range(matrix.shape[1]):
            total += matrix[i, j] * vector[j]
        result[i] += share * total


@njit(cache=True)
def errors(F, G0, G1, C, D, K, place, share, y, u):
    """The prediction errors (n, ny) of outputs (n, ny) for inputs (n + 1, nu), from zero states, and the predicted states (n, nx).

    Sample k has its matrices at place[k] of the grid, mixed with the next ones by share[k].
    """
    e, states = y.copy(), np.empty((len(y), F.shape[1]))
    x, new = np.zeros(F.shape[1]), np.zeros(F.shape[1])
    for k in range(len(y)):
        new[:], states[k] = 0.0, x
        for beside in range(2 if share[k] > 0 else 1):
            i, part = place[k] + beside, share[k] if beside else 1 - share[k]
            _add(e[k], C[i], x, -part)
            _add(e[k], D[i], u[k], -part)
        for beside in range(2 if share[k] > 0 else 1):
            i, part = place[k] + beside, share[k] if beside else 1 - share[k]
            _add(new, F[i], x, part)
            _add(new, G0[i], u[k], part)
            _add(new, G1[i], u[k + 1], part)
            _add(new, K[i], e[k], part)
        x[:] = new
    return e, states


@njit(cache=True)
def errors_and_slopes(F, G0, G1, C, D, dF, dG0, dG1, dC, dD, K, place, share, y, u, du):
    """The errors (n, ny), and their slopes (n, ny, np) for slopes (np, ...) of the matrices and (np, n + 1, nu) of the inputs."""
    count, nx, ny = len(dF), F.shape[1], y.shape[1]
    e = y.copy()
    slopes = np.zeros((len(y), ny, count))
    x, new = np.zeros(nx), np.zeros(nx)
    dx, dnew, de = np.zeros((count, nx)), np.zeros(nx), np.zeros(ny)
    for k in range(len(y)):
        sides = 2 if share[k] > 0 else 1
        new[:] = 0.0
        for beside in range(sides):
            i, part = place[k] + beside, share[k] if beside else 1 - share[k]
            _add(e[k], C[i], x, -part)
            _add(e[k], D[i], u[k], -part)
        for beside in range(sides):
            i, part = place[k] + beside, share[k] if beside else 1 - share[k]
            _add(new, F[i], x, part)
            _add(new, G0[i], u[k], part)
            _add(new, G1[i], u[k + 1], part)
            _add(new, K[i], e[k], part)
        for p in range(count):
            de[:], dnew[:] = 0.0, 0.0
            for beside in range(sides):
                i, part = place[k] + beside, share[k] if beside else 1 - share[k]
                _add(de, C[i], dx[p], -part)
                _add(de, dC[p, i], x, -part)
                _add(de, D[i], du[p, k], -part)
                _add(de, dD[p, i], u[k], -part)
            for beside in range(sides):
                i, part = place[k] + beside, share[k] if beside else 1 - share[k]
                _add(dnew, F[i], dx[p], part)
                _add(dnew, dF[p, i], x, part)
                _add(dnew, G0[i], du[p, k], part)
                _add(dnew, G1[i], du[p, k + 1], part)
                _add(dnew, dG0[p, i], u[k], part)
                _add(dnew, dG1[p, i], u[k + 1], part)
                _add(dnew, K[i], de, part)
            slopes[k, :, p] = de
            dx[p] = dnew
        x[:] = new
    return e, slopes
