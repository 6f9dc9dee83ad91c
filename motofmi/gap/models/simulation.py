"""A nonlinear component simulated over a whole recording at once, with its sensitivities to parameters.

Between two nodes the states follow an implicit formula with one inner point (see `implicit_formulas`).
The states at all samples are solved for together by Newton's method. The matrix is block-bidiagonal, so a step is one
banded triangular solve, and the same matrix gives dx/dp of every parameter: cost is linear in samples. Several pieces
of a recording, each with its own initial states, form one trajectory without transitions between them.

Where a mass sticks, the correction of one simulation step alternates from one side of zero rate to the other and
does not decrease. The corrections of such steps are damped one by one: each by half as long as it changes its sign.

Source: Betts, Practical Methods for Optimal Control, 2nd ed. (2010), ch. 4.6; Ascher, Mattheij, Russell (1995); Deuflhard,
Newton Methods for Nonlinear Problems (2004), ch. 3, for damping.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from fmus.support.errors import InputError
from motofmi.gap.models.equations import Equations
from motofmi.gap.models.implicit_formulas import HERMITE_SIMPSON, ImplicitFormula
from motofmi.gap.models.time_varying_matrices import (
    Entries,
    Matrix,
    carried,
    chain,
    identity,
    inverse,
    is_zero,
    part,
    product,
    rows,
    scaled,
    total,
)

CONVERGED = 1e-4  # step over a state's rms at convergence; the error after such a step is of the order of its square
STEPS = 30  # of Newton's method
UNDAMPED_STEPS = 12  # after which corrections that alternate are damped; a slow convergence ends before
LEAST_DAMPING = 2.0**-12  # factor on the correction of a step that alternates
NOT_CONVERGED = 0.1  # step over a state's rms above which the trajectory has not converged
SHORTEST = 1 / 256  # least step of the continuation, as a share of the magnitude
LARGEST = 1e100  # of states and derivatives: squares of larger numbers over the noise overflow


@dataclass(frozen=True)
class Motion:
    """The inputs of a simulation: time (n,) [s] and inputs (n,) by name at the nodes, and (n-1,) between them.

    between are at the inner points of the formula (see `inner_times`).
    begins (pieces,) are the samples at which pieces begin, the first always among them.
    """

    time: np.ndarray
    at: Mapping[str, np.ndarray]
    between: Mapping[str, np.ndarray]
    begins: np.ndarray = field(default_factory=lambda: np.zeros(1, int))
    formula: ImplicitFormula = HERMITE_SIMPSON

    @property
    def step(self) -> float:
        return float(self.time[1] - self.time[0])


def inner_times(time: np.ndarray, formula: ImplicitFormula = HERMITE_SIMPSON) -> np.ndarray:
    """The times (n-1,) of the inner points between nodes at times (n,) [s]."""
    return (1 - formula.place) * time[:-1] + formula.place * time[1:]


class Trajectory:
    """States (n, nx) and outputs (n, ny); their derivatives are computed on demand."""

    def __init__(self, states: np.ndarray, steps: "_Collocation", with_initial: bool):
        self.states, self._steps = states, steps
        self.outputs = steps.bounded(steps.outputs())
        initial = with_initial and steps.nx
        self.initial_slopes = (
            steps.bounded(steps.initial_sensitivities()) if initial else None
        )  # (n, ny, nx), by the initial states of each one's piece

    @cached_property
    @np.errstate(all="ignore")
    def slopes(self) -> np.ndarray:
        """Of the outputs by the parameters (n, ny, np). Raises InputError where they are not finite."""
        return self._steps.bounded(self._steps.sensitivities(*self._steps.parameter_forcing()))


@np.errstate(all="ignore")  # divergence raises an InputError
def simulate(equations: Equations, values: Mapping[str, float], motion: Motion, start: np.ndarray | None = None,
             initial: np.ndarray | None = None, with_initial: bool = False,
             accuracy: float | None = None) -> Trajectory:  # fmt: skip
    """The trajectory for parameter values by name, from a guess of the states (n, nx), starting at `initial`
    (nx,) or (pieces, nx).

    accuracy is the largest last step of Newton's method over a state's rms; without it CONVERGED, or NOT_CONVERGED
    where the steps become no smaller. Raises InputError where it does not converge, or is not finite.
    """
    n, nx = len(motion.time), len(equations.states)
    x = np.zeros((nx, n)) if start is None else np.array(start.T, order="C")
    if initial is not None:
        x[:, motion.begins] = np.atleast_2d(initial).T
    nodes = {**values, "time": motion.time, **motion.at}
    middles = {**values, "time": inner_times(motion.time, motion.formula), **motion.between}
    steps, update, damping = _Collocation(equations, nodes, middles, motion), np.inf, _Damping(n - 1)
    for done in range(STEPS):
        steps.evaluate(x)
        if not nx:
            break
        steps.factor()
        corrections = steps.corrections()
        change = carried(steps.band, corrections.copy()).T
        before, update = update, float(np.max(_size(change) / (_size(x) + _size(change) + 1e-12)))
        if not np.isfinite(update):
            raise steps.divergence
        settled = update < (accuracy or CONVERGED)
        cycle = done >= UNDAMPED_STEPS and CONVERGED < update < NOT_CONVERGED
        if cycle and damping.after(corrections / (_size(x) + 1e-300)).min() < 1:
            change = carried(steps.band, corrections * damping.factors[:, None]).T
        x[:, 1:] += change if settled or update < max(0.5 * before, NOT_CONVERGED) else 0.5 * change
        if settled:
            steps.update_outputs(change)
            break
        # With a kink between samples Newton's method converges no further.
        kink = not accuracy and update < 1e-3 and before < 1e-2 and update > 0.2 * before
        if kink or equations.linear:
            steps.evaluate(x, again=not equations.linear)
            break
    else:
        if accuracy or update > NOT_CONVERGED:
            raise steps.divergence
        steps.evaluate(x)
    return Trajectory(x.T, steps, with_initial)


def simulate_by_continuation(
    equations: Equations, values: Mapping[str, float], motion: Motion, sizes: Sequence[str]
) -> Trajectory:
    """The trajectory without a good guess, by continuation in the magnitudes `sizes`, which grow from zero.

    Raises InputError where the shortest step diverges.
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


class _Damping:
    """Factors (steps,) on the corrections of simulation steps, less than 1 where a correction alternates."""

    def __init__(self, count: int):
        self.factors, self.last = np.ones(count), np.zeros((count, 0))

    def after(self, corrections: np.ndarray) -> np.ndarray:
        """The factors on these corrections (steps, nx), which are over the size of each state [1].

        A correction alternates where it points against the one before and is longer than half of it.
        """
        if self.last.shape == corrections.shape:
            along = np.einsum("ki,ki->k", corrections, self.last)
            lengths = (np.einsum("ki,ki->k", each, each) for each in (corrections, self.last))
            alternates = (along < 0) & (next(lengths) > 0.25 * next(lengths))
            self.factors = np.where(
                alternates, np.maximum(self.factors / 2, LEAST_DAMPING), np.minimum(2 * self.factors, 1.0)
            )
        self.last = corrections
        return self.factors


class _Collocation:
    """The defects of a trajectory guess (n, nx), and the block-bidiagonal matrix of their slopes.

    before_k dx_k + forcing_k = after_k dx_k+1,   before_k = forcing_k = 0 in the step to the begin of a piece
    """

    def __init__(self, equations: Equations, nodes: dict, middles: dict, motion: Motion):
        self.equations, self.nodes, self.middles, self.h = equations, nodes, middles, motion.step
        self.inner, self.step, self.share = motion.formula.inner, motion.formula.step, motion.step / motion.formula.divisor
        self.n, self.nx = len(nodes["time"]), len(equations.states)
        self.begins, self.transitions = motion.begins, motion.begins[1:] - 1
        self.divergence = InputError(f"{equations.component.name}: the simulation diverges")

    def bounded(self, made: np.ndarray) -> np.ndarray:
        """The array itself. Raises InputError where it exceeds LARGEST."""
        if not np.all(np.abs(made) < LARGEST):
            raise self.divergence
        return made

    def evaluate(self, x: np.ndarray, again: bool = True) -> None:
        """Rates, outputs and derivatives along a trajectory (nx, n); its defects too, unless `again` is False."""
        states, (a, b, p, q), (u, v, w) = self.equations.states, self.inner, self.step
        self.at_nodes = self.nodes | dict(zip(states, x, strict=True))
        self.rows, self.slopes = self.equations(self.at_nodes, self.n)
        first = [f[:-1] if np.ndim(f) else f for f in self.rows[: self.nx]]
        second = [f[1:] if np.ndim(f) else f for f in self.rows[: self.nx]]
        between = {
            name: a * x[i, :-1] + b * x[i, 1:] + self.h * (p * first[i] + q * second[i]) for i, name in enumerate(states)
        }
        for i, name in enumerate(states if len(self.transitions) else ()):
            between[name][self.transitions] = x[i, self.transitions]  # any finite value: these defects are set to zero
        self.at_middles = self.middles | between
        if not again:
            return
        middle, self.between = self.equations(self.at_middles, self.n - 1)
        self.defect = {}
        for i in range(self.nx):
            self.defect[i, 0] = x[i, 1:] - x[i, :-1] - self.share * (u * first[i] + v * middle[i] + w * second[i])
            self.defect[i, 0][self.transitions] = 0.0

    def factor(self) -> None:
        """The blocks of the matrix along the trajectory."""
        nx, h, unit, (a, b, p, q), (u, v, w) = self.nx, self.h, identity(self.nx), self.inner, self.step
        A, M = rows(self.slopes, 0, nx), rows(self.between, 0, nx)
        first, second = part(A, slice(None, -1)), part(A, slice(1, None))
        by_end = total(scaled(w, second), product(M, total(scaled(b, unit), second, q * h)), v)
        self.inverse = inverse(total(unit, by_end, -self.share), nx)
        by_begin = total(scaled(u, first), product(M, total(scaled(a, unit), first, p * h)), v)
        self.before = self._cut(total(unit, by_begin, self.share))
        self.band = chain(part(product(self.inverse, self.before), slice(1, None)), nx, self.n - 1)

    def outputs(self) -> np.ndarray:
        """(n, ny)"""
        return np.column_stack([np.broadcast_to(y, self.n) for y in self.rows[self.nx :]])

    def update_outputs(self, change: np.ndarray) -> None:
        """The outputs after a small change (nx, n-1) of the states."""
        for (i, j), c in sorted(self.slopes.items(), key=lambda entry: entry[0]):
            if i >= self.nx and not is_zero(c):
                self.rows[i] = self.rows[i] + np.zeros(self.n)
                self.rows[i][1:] += (c[1:] if np.ndim(c) else c) * change[j]

    def parameter_forcing(self) -> tuple[Matrix, Matrix, int]:
        """The derivatives by each parameter of every step (nx, np), before propagation, and of the outputs (ny, np)."""
        slopes, Q = (
            self.equations.slopes(self.at_nodes, self.n),
            rows(self.equations.slopes(self.at_middles, self.n - 1), 0, self.nx),
        )
        (_, _, p, q), (u, v, w) = self.inner, self.step
        P, direct = rows(slopes, 0, self.nx), rows(slopes, self.nx, len(self.rows))
        first, second = part(P, slice(None, -1)), part(P, slice(1, None))
        curved = product(rows(self.between, 0, self.nx), total(scaled(p, first), second, q))
        outer = total(scaled(u, first), second, w)
        forcing = scaled(self.share, total(outer, total(Q, curved, self.h), v))
        return self._cut(forcing), direct, len(self.equations.parameters)

    def _cut(self, steps: Matrix) -> Matrix:
        """Blocks over the steps, zero in the steps to the begin of a piece."""
        for place, value in steps.items():
            if len(self.transitions) and not is_zero(value):
                steps[place] = value + np.zeros(self.n - 1)
                steps[place][self.transitions] = 0.0
        return steps

    def sensitivities(self, forcing: Entries, direct: Entries, m: int) -> np.ndarray:
        """Derivatives of the outputs (n, ny, m) by m quantities, from the direct derivatives by them of every step
        (nx, m), as of `parameter_forcing`, and of the outputs (ny, m)."""
        ny = len(self.rows) - self.nx
        result = np.zeros((ny, m, self.n))
        for place, slope in direct.items():
            result[place] = slope
        by_state = part(rows(self.slopes, self.nx, len(self.rows)), slice(1, None))
        for k in range(m):
            column = {(i, 0): p for (i, j), p in forcing.items() if j == k and not is_zero(p)}
            if not column:
                continue
            change = self.solve(column)
            for (i, j), slope in sorted(by_state.items(), key=lambda entry: entry[0]):
                if not is_zero(slope):
                    result[i, k, 1:] += slope * change[j]
        return np.moveaxis(result, 2, 0)

    def initial_sensitivities(self) -> np.ndarray:
        """Slopes of the outputs (n, ny, nx) by the initial states."""
        forcing: Matrix = {}
        for place, slope in self.before.items():
            forcing[place] = np.zeros(self.n - 1)
            forcing[place][self.begins] = slope[self.begins] if np.ndim(slope) else slope
        result = self.sensitivities(forcing, {}, self.nx)
        for (i, j), slope in rows(self.slopes, self.nx, len(self.rows)).items():
            result[self.begins, i, j] = slope[self.begins] if np.ndim(slope) else slope
        return result

    def corrections(self) -> np.ndarray:
        """The correction (n-1, nx) of the end of every step by its own defect."""
        return self._solved(scaled(-1.0, self.defect))

    def solve(self, forcing: Entries) -> np.ndarray:
        """dx (nx, n-1) with after_k dx_k+1 = before_k dx_k + forcing_k (nx,) and dx_0 = 0: a banded triangular
        system."""
        return carried(self.band, self._solved(forcing)).T

    def _solved(self, forcing: Entries) -> np.ndarray:
        """after_k^-1 forcing_k (n-1, nx)."""
        right = np.zeros((self.n - 1, self.nx))
        for (i, _), value in product(self.inverse, forcing).items():
            right[:, i] = value
        return right


def _size(x: np.ndarray) -> np.ndarray:
    """The root mean square (nx,) of each row."""
    return np.sqrt(np.einsum("ij,ij->i", x, x) / x.shape[1])
