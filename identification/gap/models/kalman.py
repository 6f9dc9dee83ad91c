r"""One-step predictions of a linear system that disturbances drive, its gain that of the stationary Kalman filter.

    x_k+1 = F x_k + G_0 u_k + G_1 u_k+1 + K e_k,     e_k = y_k - C x_k - D u_k
    P = F P F' + Q - K S K',     S = C P C' + R,     K = F P C' S^-1

Where the system changes with the speed, its matrices are interpolated between those on a grid of speeds.

Source: Kailath, Sayed, Hassibi, Linear Estimation (2000), ch. 9; Van Loan, IEEE Trans. Autom. Control 23 (1978) 395-404,
for the sampled matrices.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from identification.gap.models.over_time import carried, chain

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
        """All of them."""
        return self.F, self.G0, self.G1, self.C, self.D


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


def errors(made: Discrete, K: np.ndarray, place: np.ndarray, share: np.ndarray, y: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The prediction errors (n, ny) of outputs (n, ny) for inputs (n + 1, nu), from zero states, and the predicted states (n, nx).

    Sample k has its matrices at place[k] of the grid, mixed with the next ones by share[k].
    """
    F, G0, G1, C, D, K = (_along(m, place, share) for m in (*made.parts, K))
    seen = y - _times(D, u[:-1])
    x = _from_rest(F - K @ C, (_times(G0, u[:-1]) + _times(G1, u[1:]) + _times(K, seen))[..., None])[..., 0]
    return seen - _times(C, x), x


def errors_and_slopes(made: Discrete, changes: Discrete, K: np.ndarray, place: np.ndarray, share: np.ndarray, y: np.ndarray, u: np.ndarray,
                      du: np.ndarray) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """The errors (n, ny), and their slopes (n, ny, np) for slopes (np, ...) of the matrices and (np, n + 1, nu) of the inputs.

        dx_k+1 = (F - K C) dx_k + dF x_k + dG_0 u_k + G_0 du_k + ... + K (de_k at dx_k = 0)
    """
    e, x = errors(made, K, place, share, y, u)
    F, G0, G1, C, D, K = (_along(m, place, share) for m in (*made.parts, K))
    direct, pushed = np.zeros((*e.shape, len(du))), np.zeros((*x.shape, len(du)))
    for p, told in enumerate(du):
        dF, dG0, dG1, dC, dD = (_along(m[p], place, share) for m in changes.parts)
        direct[..., p] = -(_times(dC, x) + _times(dD, u[:-1]) + _times(D, told[:-1]))
        pushed[..., p] = (_times(dF, x) + _times(dG0, u[:-1]) + _times(dG1, u[1:]) + _times(G0, told[:-1]) + _times(G1, told[1:])
                          + _times(K, direct[..., p]))  # fmt: skip
    return e, direct - C @ _from_rest(F - K @ C, pushed)


def _along(matrix: np.ndarray, place: np.ndarray, share: np.ndarray) -> np.ndarray:
    """The matrices at every sample (n, ...); one for all (...) where the grid has one."""
    if len(matrix) == 1:
        return matrix[0]
    after = np.minimum(place + 1, len(matrix) - 1)
    share = share.reshape(-1, 1, 1)
    return (1 - share) * matrix[place] + share * matrix[after]


def _times(matrix: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """matrix_k vector_k (n, rows) of vectors (n, columns)."""
    return vectors @ matrix.T if matrix.ndim == 2 else (matrix @ vectors[..., None])[..., 0]


def _from_rest(step: np.ndarray, push: np.ndarray) -> np.ndarray:
    """x (n, nx, m) with x_k+1 = step_k x_k + push_k and x_0 = 0, for one step (nx, nx) or one per sample (n, nx, nx)."""
    n, nx, m = push.shape
    blocks = np.empty((nx, nx), object)
    for place in np.ndindex(nx, nx):
        blocks[place] = step[place] if step.ndim == 2 else step[1 : n - 1, *place]
    return np.concatenate([np.zeros((1, nx, m)), carried(chain(blocks, n - 1), push[:-1])])
