"""A nonlinear component simulated over a whole recording at once, with its sensitivities to parameters.

Between two samples the states follow the Hermite-Simpson rule (fourth order, A-stable):

    x_m     = (x_k + x_k+1) / 2 + h / 8 (f_k - f_k+1)
    x_k+1   = x_k + h / 6 (f_k + 4 f_m + f_k+1)

All samples are unknown together: Newton's method on the trajectory. Its matrix is block-bidiagonal, so one step is
one banded triangular solve, and the same matrix gives dx/dp of every parameter: cost is linear in samples.

Source: Betts, Practical Methods for Optimal Control, 2nd ed. (2010), ch. 4.6; Ascher, Mattheij, Russell (1995).
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.linalg import lapack

from fmus.errors import InputError
from identification.gap.equations import Equations

CONVERGED = 1e-7  # of a state's largest value
STEPS = 30


@dataclass(frozen=True)
class Motion:
    """What is told to the component: time (n,) [s] and inputs (n,) by name at the samples, and (n-1,) between them."""

    time: np.ndarray
    at: Mapping[str, np.ndarray]
    between: Mapping[str, np.ndarray]

    @property
    def step(self) -> float:
        return float(self.time[1] - self.time[0])


@dataclass
class Trajectory:
    """States (n, nx), outputs (n, ny), their slopes by parameters (n, ny, np) and by initial states (n, ny, nx)."""

    states: np.ndarray
    outputs: np.ndarray
    slopes: np.ndarray
    initial_slopes: np.ndarray | None = None


def simulate(equations: Equations, values: Mapping[str, float], motion: Motion, start: np.ndarray | None = None,
             initial: np.ndarray | None = None, with_initial: bool = False) -> Trajectory:  # fmt: skip
    """The trajectory for parameter values by name, from a guess of the states (n, nx), starting at `initial` (nx,).

    Raises InputError where it does not converge, or leaves finite numbers.
    """
    n, nx, h = len(motion.time), len(equations.states), motion.step
    x = np.zeros((n, nx)) if start is None else start.copy()
    if initial is not None:
        x[0] = initial
    nodes = {**values, "time": motion.time, **motion.at}
    middles = {**values, "time": (motion.time[1:] + motion.time[:-1]) / 2, **motion.between}
    if not nx:
        rows, slopes = equations(nodes, n)
        return Trajectory(x, rows.T, np.moveaxis(slopes, 2, 0))
    update = np.inf
    for _ in range(STEPS):
        collocation = _Collocation(equations, nodes, middles, x, h)
        change = collocation.solve(-collocation.defect[:, :, None])[:, :, 0]
        before, update = update, float(np.max(np.abs(change) / (np.abs(x).max(axis=0) + np.abs(change).max(axis=0) + 1e-12)))
        if not np.isfinite(update):
            raise InputError(f"{equations.component.name}: the simulation diverges")
        x[1:] += change if update < 0.5 * before or update < 0.1 else 0.5 * change
        if update < CONVERGED:
            break
        if update < 1e-3 and before < 1e-2 and update > 0.2 * before:  # a kink between samples: as near as it gets
            break
    rows, slopes = equations(nodes | dict(zip(equations.states, x.T, strict=True)), n)
    outputs, by_state, by_parameter = rows[nx:].T, slopes[nx:, :nx], slopes[nx:, nx:]
    pushed = collocation.solve(collocation.parameter_push())
    total = np.moveaxis(by_parameter, 2, 0).copy()
    total[1:] += np.einsum("ijn,njp->nip", by_state[:, :, 1:], pushed)
    made = Trajectory(x, outputs, total)
    if with_initial:
        drift = np.concatenate([np.eye(nx)[None], collocation.solve(collocation.initial_push())])
        made.initial_slopes = np.einsum("ijn,njp->nip", by_state, drift)
    return made


class _Collocation:
    """The defects of a trajectory guess, and the block-bidiagonal matrix of their slopes."""

    def __init__(self, equations: Equations, nodes: dict, middles: dict, x: np.ndarray, h: float):
        nx, n = x.shape[1], len(x)
        self.nx, self.h = nx, h
        rows, slopes = equations(nodes | dict(zip(equations.states, x.T, strict=True)), n)
        f = rows[:nx].T
        middle = (x[:-1] + x[1:]) / 2 + h / 8 * (f[:-1] - f[1:])
        rows, self.middle_slopes = equations(middles | dict(zip(equations.states, middle.T, strict=True)), n - 1)
        self.node_slopes = slopes
        self.defect = x[1:] - x[:-1] - h / 6 * (f[:-1] + 4 * rows[:nx].T + f[1:])
        A = np.moveaxis(slopes[:nx, :nx], 2, 0)
        M = np.moveaxis(self.middle_slopes[:nx, :nx], 2, 0)
        self.M = M
        unit = np.eye(nx)
        after = unit - h / 6 * (A[1:] + 4 * M @ (unit / 2 - h / 8 * A[1:]))
        before = unit + h / 6 * (A[:-1] + 4 * M @ (unit / 2 + h / 8 * A[:-1]))
        self.inverse = _inverse(after)
        self.transition = self.inverse @ before

    def parameter_push(self) -> np.ndarray:
        """What a change of each parameter does to each step (n-1, nx, np), before it is carried on."""
        nx, h = self.nx, self.h
        P = np.moveaxis(self.node_slopes[:nx, nx:], 2, 0)
        Q = np.moveaxis(self.middle_slopes[:nx, nx:], 2, 0)
        return h / 6 * (P[:-1] + P[1:] + 4 * (Q + h / 8 * self.M @ (P[:-1] - P[1:])))

    def initial_push(self) -> np.ndarray:
        push = np.zeros((len(self.defect), self.nx, self.nx))
        push[0] = np.linalg.solve(self.inverse[0], self.transition[0])
        return push

    def solve(self, push: np.ndarray) -> np.ndarray:
        """dx (n-1, nx, m) with dx_k+1 = transition_k dx_k + inverse_k push_k, dx_0 = 0: a banded triangular system."""
        steps, nx, m = push.shape
        if not m:
            return push
        right = np.asfortranarray((self.inverse @ push).reshape(steps * nx, m))
        band = np.zeros((2 * nx, steps * nx), order="F")
        band[0] = 1.0
        for i in range(nx):
            for j in range(nx):
                band[nx + i - j, j : (steps - 1) * nx : nx] = -self.transition[1:, i, j]
        solution, _ = lapack.dtbtrs(band, right, uplo="L", overwrite_b=1)
        return solution.reshape(steps, nx, m)


def _inverse(blocks: np.ndarray) -> np.ndarray:
    """The inverses of (n, nx, nx); in closed form up to two states."""
    nx = blocks.shape[-1]
    if nx == 1:
        return 1 / blocks
    if nx > 2:
        return np.linalg.inv(blocks)
    a, b, c, d = blocks[:, 0, 0], blocks[:, 0, 1], blocks[:, 1, 0], blocks[:, 1, 1]
    return np.stack([np.stack([d, -b], -1), np.stack([-c, a], -1)], -2) / (a * d - b * c)[:, None, None]
