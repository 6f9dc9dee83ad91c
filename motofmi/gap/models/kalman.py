r"""One-step predictions of a linear system with disturbances, with the gain of the stationary Kalman filter.

    x_k+1 = F x_k + G_0 u_k + G_1 u_k+1 + K e_k,     e_k = y_k - C x_k - D u_k
    P = F P F' + Q - K S K',     S = C P C' + R,     K = F P C' S^-1

Where the system depends on the speed, its matrices are interpolated on a grid of speeds.

Source: Kailath, Sayed, Hassibi, Linear Estimation (2000), ch. 9; Van Loan, IEEE Trans. Autom. Control 23 (1978)
395-404, for the sampled matrices.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from motofmi.gap.models.time_varying_matrices import carried, chain

DOUBLINGS, SCALING_DOUBLINGS = 40, 6  # of the Riccati iteration, and of the span over which states are scaled
SETTLED = 1e-9  # relative change of the covariance at convergence


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
    """The system (..., nx, nx), (..., nx, nu) over steps [s], its inputs interpolated linearly, or held."""
    nx, nu = B.shape[-2:]
    block = np.zeros((*A.shape[:-2], nx + 2 * nu, nx + 2 * nu))
    block[..., :nx, :nx], block[..., :nx, nx : nx + nu] = A * step, B * step
    block[..., nx : nx + nu, nx + nu :] = np.eye(nu)
    whole = expm(block)
    F, now, rise = whole[..., :nx, :nx], whole[..., :nx, nx : nx + nu], whole[..., :nx, nx + nu :]
    return Discrete(F, now if held else now - rise, np.zeros_like(rise) if held else rise, C, D)


def sampled_noise(A: np.ndarray, intensity: np.ndarray, step: float) -> np.ndarray:
    """The covariance (..., nx, nx) that white noise of a spectral intensity (..., nx, nx) adds to the states in a
    step, by Simpson's rule."""
    half = expm(A * step / 2)
    middle = half @ intensity @ _transposed(half)
    return step / 6 * (intensity + 4 * middle + half @ middle @ _transposed(half))


def stationary(F: np.ndarray, C: np.ndarray, Q: np.ndarray, R: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The gain K (..., nx, ny), the covariances S (..., ny, ny) of the errors and P (..., nx, nx) of the states, by
    doubling. Raises LinAlgError where there is none.

    States are scaled by their standard deviation under the noise after 2^SCALING_DOUBLINGS steps, outputs by their
    noise, since units differ widely.

    Source: Chu, Fan, Lin, Wang, Int. J. Control 77 (2004) 767-788.
    """
    size = _size(F, Q)
    noise = np.sqrt(np.diagonal(R, axis1=-2, axis2=-1))
    A = _transposed(F / size[..., :, None] * size[..., None, :])
    scaled_C = C * size[..., None, :] / noise[..., :, None]
    G, H = _transposed(scaled_C) @ scaled_C, Q / size[..., :, None] / size[..., None, :]
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
                return K, S, P
            break  # an unstable, unobservable mode cannot be predicted
    raise np.linalg.LinAlgError("no stationary prediction")


def _size(F: np.ndarray, Q: np.ndarray) -> np.ndarray:
    """The standard deviation (..., nx) of the states after 2^SCALING_DOUBLINGS steps from rest; never zero."""
    for _ in range(SCALING_DOUBLINGS):
        Q, F = Q + F @ Q @ _transposed(F), F @ F
    deviation = np.sqrt(np.maximum(np.diagonal(Q, axis1=-2, axis2=-1), 0.0))
    return np.maximum(deviation, 1e-12 * deviation.max(axis=-1, keepdims=True) + 1e-300)


def _transposed(matrix: np.ndarray) -> np.ndarray:
    return np.swapaxes(matrix, -1, -2)


@dataclass(frozen=True)
class LinearisedForce:
    """Nonlinear forces linearised about a motion, b(x) = value + slope x, which act as the last inputs.

    value (n + 1, nb) is b extrapolated to x = 0, slope is (n + 1, nb, nx).
    """

    value: np.ndarray
    slope: np.ndarray

    def between(self, first: int, last: int) -> "LinearisedForce":
        """The samples [first, last), with the last one repeated."""
        return LinearisedForce(*(np.concatenate([x[first:last], x[last - 1 : last]]) for x in (self.value, self.slope)))


def errors(made: Discrete, K: np.ndarray, place: np.ndarray, share: np.ndarray, y: np.ndarray, u: np.ndarray,
           force: LinearisedForce | None = None) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """The prediction errors (n, ny) of outputs (n, ny) for inputs (n + 1, nu), from zero states, and the
    predicted states (n, nx).

    Sample k has its matrices at place[k] of the grid, interpolated to the next ones by share[k].
    """
    F, G0, G1, C, D, K = (_along(m, place, share) for m in (*made.parts, K))
    u = u if force is None else np.hstack([u, force.value])
    y = y - _times(D, u[:-1])
    forcing = (_times(G0, u[:-1]) + _times(G1, u[1:]) + _times(K, y))[..., None]
    x = _from_rest(*_with_force(F - K @ C, forcing, G0, G1, force))[..., 0]
    return y - _times(C, x), x


def errors_and_slopes(made: Discrete, changes: Discrete, K: np.ndarray, dK: np.ndarray, place: np.ndarray,
                      share: np.ndarray, y: np.ndarray, u: np.ndarray, du: np.ndarray,
                      force: LinearisedForce | None = None) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """The errors (n, ny), and their slopes (n, ny, np) for slopes (np, ...) of the matrices and gains, and
    (np, n + 1, nu) of the inputs.

        de_k = -C dx_k + (de_k at dx_k = 0),
        dx_k+1 = (F - K C) dx_k + dF x_k + dG_0 u_k + G_0 du_k + ... + dK e_k + K (de_k at dx_k = 0)

    With a force, linearised about the resulting motion, du includes the derivatives of its value.
    """
    e, x = errors(made, K, place, share, y, u, force)
    F, G0, G1, C, D, K = (_along(m, place, share) for m in (*made.parts, K))
    if force is not None:
        u = np.hstack([u, force.value + (force.slope @ np.concatenate([x, x[-1:]])[..., None])[..., 0]])
    direct = -_times_each(np.concatenate([changes.C, changes.D], axis=-1), place, share, np.hstack([x, u[:-1]]))
    forcing_slopes = _times_each(
        np.concatenate([changes.F, changes.G0, changes.G1, dK], axis=-1), place, share, np.hstack([x, u[:-1], u[1:], e])
    )
    for p in np.flatnonzero(np.any(du, axis=(1, 2))):
        direct[..., p] -= _times(D, du[p][:-1])
        forcing_slopes[..., p] += _times(G0, du[p][:-1]) + _times(G1, du[p][1:])
    return e, direct - C @ _from_rest(*_with_force(F - K @ C, forcing_slopes + K @ direct, G0, G1, force))


def _with_force(
    step: np.ndarray, forcing: np.ndarray, G0: np.ndarray, G1: np.ndarray, force: LinearisedForce | None
) -> tuple[np.ndarray, np.ndarray]:
    """Step and forcing of x_k+1 = step x_k + forcing_k + G_0 slope_k x_k + G_1 slope_k+1 x_k+1, solved for x_k+1."""
    if force is None:
        return step, forcing
    nb = force.value.shape[1]
    now, next_ = G0[..., -nb:], G1[..., -nb:]
    after = force.slope[1:]
    step = step + now @ force.slope[:-1]
    small = np.linalg.inv(np.eye(nb) - after @ next_)  # Woodbury's identity: nb is small

    def solved(right: np.ndarray) -> np.ndarray:
        return right + next_ @ (small @ (after @ right))

    return solved(np.broadcast_to(step, (len(forcing), *step.shape[-2:]))), solved(forcing)


def _times_each(matrices: np.ndarray, place: np.ndarray, share: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Of matrices (np, g, rows, columns) on the grid, those at every sample times its vector
    (n, columns): (n, rows, np)."""
    count, grid, rows, columns = matrices.shape
    result = np.zeros((len(vectors), count * rows))
    for node in range(grid):
        weight = np.where(place == node, 1 - share, 0.0) + np.where(place == node - 1, share, 0.0)
        near = np.flatnonzero(weight)
        result[near] += (weight[near, None] * vectors[near]) @ matrices[:, node].reshape(count * rows, columns).T
    return result.reshape(len(vectors), count, rows).transpose(0, 2, 1)


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


def _from_rest(step: np.ndarray, forcing: np.ndarray) -> np.ndarray:
    """x (n, nx, m) with x_k+1 = step_k x_k + forcing_k and x_0 = 0, for one step (nx, nx) or one per
    sample (n, nx, nx)."""
    n, nx, m = forcing.shape
    blocks = {place: step[place] if step.ndim == 2 else step[1 : n - 1, *place] for place in np.ndindex(nx, nx)}
    return np.concatenate([np.zeros((1, nx, m)), carried(chain(blocks, nx, n - 1), forcing[:-1])])
