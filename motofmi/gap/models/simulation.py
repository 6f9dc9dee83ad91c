"""A nonlinear component simulated over a whole recording at once, with its sensitivities to parameters.

Between two samples the states follow the Hermite-Simpson rule (fourth order, A-stable):

    x_m     = (x_k + x_k+1) / 2 + h / 8 (f_k - f_k+1)
    x_k+1   = x_k + h / 6 (f_k + 4 f_m + f_k+1)

All samples are unknown together: Newton's method on the trajectory. Its matrix is block-bidiagonal, so one step is
one banded triangular solve, and the same matrix gives dx/dp of every parameter: cost is linear in samples. Several
pieces of a recording, each from initial states of its own, are one trajectory in which nothing is carried on where a piece begins.

Source: Betts, Practical Methods for Optimal Control, 2nd ed. (2010), ch. 4.6; Ascher, Mattheij, Russell (1995).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from fmus.errors import InputError
from identification.gap.models.equations import Equations
from identification.gap.models.over_time import carried, chain, inverse, is_zero, part, product

CONVERGED = 1e-5  # of a state's size (root mean square); what is left after such a step is its square
STEPS = 30
ASTRAY = 0.1  # of a state's size: what still changes by more is no trajectory
SHORTEST = 1 / 256  # share of a value by which it grows where a trajectory is led in
LARGEST = 1e100  # of what is simulated and of its slopes: squares of more, divided by the noise, are no numbers any more
np.empty(4_000_000)  # once freed, the C library keeps what smaller arrays free: handing it back to the system took half of the time


@dataclass(frozen=True)
class Motion:
    """What is told to the component: time (n,) [s] and inputs (n,) by name at the samples, and (n-1,) between them.

    begins (pieces,) are the samples at which pieces begin, the first always among them.
    """

    time: np.ndarray
    at: Mapping[str, np.ndarray]
    between: Mapping[str, np.ndarray]
    begins: np.ndarray = field(default_factory=lambda: np.zeros(1, int))

    @property
    def step(self) -> float:
        return float(self.time[1] - self.time[0])


class Trajectory:
    """States (n, nx) and outputs (n, ny); their slopes are computed when they are asked for."""

    def __init__(self, states: np.ndarray, steps: "_Collocation", with_initial: bool):
        self.states, self._steps = states, steps
        self.outputs = steps.bounded(steps.outputs())
        initial = with_initial and steps.nx
        self.initial_slopes = steps.bounded(steps.initial_sensitivities()) if initial else None  # (n, ny, nx), by the initial states of each one's piece

    @cached_property
    @np.errstate(all="ignore")
    def slopes(self) -> np.ndarray:
        """Of the outputs by the parameters (n, ny, np). Raises InputError where they leave finite numbers."""
        return self._steps.bounded(self._steps.sensitivities(*self._steps.parameter_push()))


@np.errstate(all="ignore")  # what leaves finite numbers on the way is an InputError
def simulate(equations: Equations, values: Mapping[str, float], motion: Motion, start: np.ndarray | None = None,
             initial: np.ndarray | None = None, with_initial: bool = False) -> Trajectory:  # fmt: skip
    """The trajectory for parameter values by name, from a guess of the states (n, nx), starting at `initial` (nx,) or (pieces, nx).

    Raises InputError where it does not converge, or leaves finite numbers.
    """
    n, nx = len(motion.time), len(equations.states)
    x = np.zeros((nx, n)) if start is None else np.array(start.T, order="C")
    if initial is not None:
        x[:, motion.begins] = np.atleast_2d(initial).T
    nodes = {**values, "time": motion.time, **motion.at}
    middles = {**values, "time": (motion.time[1:] + motion.time[:-1]) / 2, **motion.between}
    steps, update = _Collocation(equations, nodes, middles, motion), np.inf
    for _ in range(STEPS):
        steps.look(x)
        if not nx:
            break
        steps.factor()
        change = steps.solve(-steps.defect)
        before, update = update, float(np.max(_size(change) / (_size(x) + _size(change) + 1e-12)))
        if not np.isfinite(update):
            raise steps.diverges
        settled = update < CONVERGED
        x[:, 1:] += change if settled or update < 0.5 * before or update < 0.1 else 0.5 * change
        if settled:
            steps.follow(change)
            break
        kink = update < 1e-3 and before < 1e-2 and update > 0.2 * before  # between samples: as near as it gets
        if kink or equations.linear:
            steps.look(x, again=not equations.linear)
            break
    else:
        if update > ASTRAY:
            raise steps.diverges
        steps.look(x)
    return Trajectory(x.T, steps, with_initial)


def led_in(equations: Equations, values: Mapping[str, float], motion: Motion, sizes: Sequence[str]) -> Trajectory:
    """The trajectory where none is known to begin from: the values named `sizes` grow from nothing, and each trajectory leads to the next.

    Raises InputError where not even short steps do.
    """
    share, step, states = 0.0, 1.0, None
    while True:
        grown = min(share + step, 1.0)
        try:
            made = simulate(equations, {**values, **{n: grown * values[n] for n in sizes}}, motion, states)
        except InputError:
            step /= 2
            if step < SHORTEST:
                raise
            continue
        if grown == 1.0:
            return made
        share, step, states = grown, 2 * step, made.states


class _Collocation:
    """The defects of a trajectory guess (n, nx), and the block-bidiagonal matrix of their slopes.

    before_k dx_k + push_k = after_k dx_k+1,   before_k = push_k = 0 into the begin of a piece
    """

    def __init__(self, equations: Equations, nodes: dict, middles: dict, motion: Motion):
        self.equations, self.nodes, self.middles, self.h = equations, nodes, middles, motion.step
        self.n, self.nx = len(nodes["time"]), len(equations.states)
        self.begins, self.into = motion.begins, motion.begins[1:] - 1
        self.diverges = InputError(f"{equations.component.name}: the simulation diverges")

    def bounded(self, made: np.ndarray) -> np.ndarray:
        """What was made. Raises InputError where it leaves numbers that one can reckon with."""
        if not np.all(np.abs(made) < LARGEST):
            raise self.diverges
        return made

    def look(self, x: np.ndarray, again: bool = True) -> None:
        """Rates, outputs and slopes along a trajectory (nx, n), and its defects; where it is no guess again, these stay as they are."""
        states, h = self.equations.states, self.h
        self.seen = self.nodes | dict(zip(states, x, strict=True))
        self.rows, self.slopes = self.equations(self.seen, self.n)
        first = [f[:-1] if np.ndim(f) else f for f in self.rows[: self.nx]]
        second = [f[1:] if np.ndim(f) else f for f in self.rows[: self.nx]]
        between = {name: (x[i, :-1] + x[i, 1:]) / 2 + h / 8 * (first[i] - second[i]) for i, name in enumerate(states)}
        for i, name in enumerate(states if len(self.into) else ()):
            between[name][self.into] = x[i, self.into]  # anything that can be computed
        self.seen_between = self.middles | between
        if not again:
            return
        middle, self.between = self.equations(self.seen_between, self.n - 1)
        self.defect = np.zeros(self.nx).astype(object)
        for i in range(self.nx):
            self.defect[i] = x[i, 1:] - x[i, :-1] - h / 6 * (first[i] + 4 * middle[i] + second[i])
            self.defect[i][self.into] = 0.0

    def factor(self) -> None:
        """The blocks of the matrix along the trajectory."""
        nx, steps, h, unit = self.nx, self.n - 1, self.h, np.eye(self.nx).astype(object)
        A, M = self.slopes[:nx], self.between[:nx]
        first, second = part(A, slice(None, -1)), part(A, slice(1, None))
        self.inverse = inverse(unit - h / 6 * (second + 4 * product(M, unit / 2 - h / 8 * second)))
        self.before = self._cut(unit + h / 6 * (first + 4 * product(M, unit / 2 + h / 8 * first)))
        self.band = chain(part(product(self.inverse, self.before), slice(1, None)), steps)

    def outputs(self) -> np.ndarray:
        """(n, ny)"""
        return np.column_stack([np.broadcast_to(y, self.n) for y in self.rows[self.nx :]])

    def follow(self, change: np.ndarray) -> None:
        """The outputs after a small change (nx, n-1) of the states."""
        for i in range(self.nx, len(self.rows)):
            for j, c in enumerate(self.slopes[i]):
                if not is_zero(c):
                    self.rows[i] = self.rows[i] + np.zeros(self.n)
                    self.rows[i][1:] += (c[1:] if np.ndim(c) else c) * change[j]

    def parameter_push(self) -> tuple[np.ndarray, np.ndarray]:
        """What a change of each parameter does to each step, before it is carried on: (nx, np), and to the outputs: (ny, np)."""
        slopes, Q = self.equations.slopes(self.seen, self.n), self.equations.slopes(self.seen_between, self.n - 1)[: self.nx]
        P, direct = slopes[: self.nx], slopes[self.nx :]
        first, second = part(P, slice(None, -1)), part(P, slice(1, None))
        return self._cut(self.h / 6 * (first + second + 4 * (Q + self.h / 8 * product(self.between[: self.nx], first - second)))), direct

    def _cut(self, steps: np.ndarray) -> np.ndarray:
        """Blocks over the steps, with nothing into the begin of a piece."""
        for place, value in np.ndenumerate(steps if len(self.into) else ()):
            if not is_zero(value):
                steps[place] = value + np.zeros(self.n - 1)
                steps[place][self.into] = 0.0
        return steps

    def sensitivities(self, push: np.ndarray, direct: np.ndarray) -> np.ndarray:
        """Slopes of the outputs (n, ny, m) by what pushes the states (nx, m) and the outputs themselves (ny, m)."""
        ny, m = direct.shape
        result = np.empty((ny, m, self.n))
        for place, slope in np.ndenumerate(direct):
            result[place] = slope
        by_state = part(self.slopes[self.nx :], slice(1, None))
        for k in range(m):
            if all(is_zero(p) for p in push[:, k]):
                continue
            change = self.solve(push[:, k])
            for (i, j), slope in np.ndenumerate(by_state):
                if not is_zero(slope):
                    result[i, k, 1:] += slope * change[j]
        return np.moveaxis(result, 2, 0)

    def initial_sensitivities(self) -> np.ndarray:
        """Slopes of the outputs (n, ny, nx) by the initial states."""
        push = np.zeros((self.nx, self.nx)).astype(object)
        for place, slope in np.ndenumerate(self.before):
            push[place] = np.zeros(self.n - 1)
            push[place][self.begins] = slope[self.begins] if np.ndim(slope) else slope
        result = self.sensitivities(push, np.zeros((len(self.rows) - self.nx, self.nx)))
        for (i, j), slope in np.ndenumerate(self.slopes[self.nx :]):
            result[self.begins, i, j] = slope[self.begins] if np.ndim(slope) else slope
        return result

    def solve(self, push: np.ndarray) -> np.ndarray:
        """dx (nx, n-1) with after_k dx_k+1 = before_k dx_k + push_k (nx,) and dx_0 = 0: a banded triangular system."""
        right = np.empty((self.n - 1, self.nx))
        for i, value in enumerate(product(self.inverse, push[:, None])[:, 0]):
            right[:, i] = value
        return carried(self.band, right).T


def _size(x: np.ndarray) -> np.ndarray:
    """The root mean square (nx,) of each row."""
    return np.sqrt(np.einsum("ij,ij->i", x, x) / x.shape[1])
