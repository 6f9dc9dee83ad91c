r"""The defects of a trajectory between its nodes, the block-bidiagonal matrix of their slopes, and its sensitivities.

    x_k+1 - x_k - h (u f_k + v f_m + w f_k+1) / d,   f_m at x_m = a x_k + b x_k+1 + h (p f_k + q f_k+1)

The coefficients are those of the implicit formula (see `implicit_formulas`), f the rates of the states.

Source: Betts, Practical Methods for Optimal Control, 2nd ed. (2010), ch. 4.6; Ascher, Mattheij, Russell (1995).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

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


class DivergenceError(InputError):
    """A simulation that diverges, with the indices of the pieces that do."""

    def __init__(self, message: str, pieces: np.ndarray):
        super().__init__(message)
        self.pieces = pieces


class Collocation:
    """The defects of a trajectory guess (n, nx), and the block-bidiagonal matrix of their slopes.

    before_k dx_k + forcing_k = after_k dx_k+1,   before_k = forcing_k = 0 in the step to the begin of a piece
    """

    def __init__(self, equations: Equations, nodes: dict, middles: dict, motion: Motion):
        self.equations, self.nodes, self.middles, self.h = equations, nodes, middles, motion.step
        formula = motion.formula
        self.inner, self.step, self.share = formula.inner, formula.step, motion.step / formula.divisor
        self.n, self.nx = len(nodes["time"]), len(equations.states)
        self.begins, self.transitions = motion.begins, motion.begins[1:] - 1
        self.lengths = np.diff([*self.begins, self.n])  # nodes of each piece

    def divergence(self, pieces: np.ndarray) -> DivergenceError:
        """The error that these pieces (pieces,), true or false, diverge; all, where none is found to."""
        found = np.flatnonzero(pieces if pieces.any() else ~pieces)
        return DivergenceError(f"{self.equations.component.name}: the simulation diverges", found)

    def bounded(self, made: np.ndarray) -> np.ndarray:
        """The array (n, ...) itself. Raises DivergenceError where it exceeds LARGEST."""
        within = np.abs(made) < LARGEST
        if not np.all(within):
            raise self.divergence(~np.logical_and.reduceat(within.reshape(self.n, -1).all(axis=1), self.begins))
        return made

    def finite(self, corrections: np.ndarray) -> np.ndarray:
        """Whether the change of the states that these corrections (n-1, nx) give is finite in each piece (pieces,).

        Each piece is computed without the others, since an infinite value times zero is not zero.
        """
        found = []
        for begin, length in zip(self.begins.tolist(), self.lengths.tolist(), strict=True):
            end = begin + length - 1
            band = np.asfortranarray(self.band[:, begin * self.nx : end * self.nx])
            found.append(bool(np.all(np.abs(carried(band, corrections[begin:end].copy())) < LARGEST)))
        return np.array(found)

    def relative(self, change: np.ndarray, x: np.ndarray) -> np.ndarray:
        """The root mean square of each state's change (nx, n-1) in a piece, over that of the state x (nx, n) and of its
        change in all pieces: the largest of all states (pieces,)."""
        power = np.add.reduceat(change**2, self.begins, axis=1) / (self.lengths - 1)
        return np.max(np.sqrt(power) / (root_mean_square(x) + root_mean_square(change) + 1e-12)[:, None], axis=0)

    def evaluate(self, x: np.ndarray, again: bool = True) -> None:
        """Rates, outputs and derivatives along a trajectory (nx, n); its defects too, unless `again` is False."""
        states, (a, b, p, q), (u, v, w) = self.equations.states, self.inner, self.step
        self.at_nodes = self.nodes | dict(zip(states, x, strict=True))
        self.rows, self.slopes = self.equations(self.at_nodes, self.n)
        first = [f[:-1] if np.ndim(f) else f for f in self.rows[: self.nx]]
        second = [f[1:] if np.ndim(f) else f for f in self.rows[: self.nx]]
        between = {
            name: a * x[i, :-1] + b * x[i, 1:] + self.h * (p * first[i] + q * second[i])
            for i, name in enumerate(states)
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


def root_mean_square(x: np.ndarray) -> np.ndarray:
    """The root mean square (nx,) of each row."""
    return np.sqrt(np.einsum("ij,ij->i", x, x) / x.shape[1])
