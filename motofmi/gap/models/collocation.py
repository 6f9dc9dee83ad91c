"""All steps of a trajectory together: their corrections, which form a block-bidiagonal system, and its sensitivities.

    dx_k+1 = T_k dx_k + c_k,   T_k = c_k = 0 in the step to the begin of a piece

T_k is the transition of a step and c_k its correction (see `recorded_step`).

Source: Betts, Practical Methods for Optimal Control, 2nd ed. (2010), ch. 4.6; Ascher, Mattheij, Russell (1995).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fmus.support.errors import InputError
from motofmi.gap.models.equations import Equations
from motofmi.gap.models.implicit_formulas import HERMITE_SIMPSON, ImplicitFormula
from motofmi.gap.models.recorded_step import STEP, named, recorded_step
from motofmi.gap.models.time_varying_matrices import Entries, Matrix, carried, chain, is_zero, part, rows

LARGEST = 1e30  # of states, outputs and their derivatives, which are in SI units: larger numbers are those of a divergence
SMALLEST = 1e-12  # root mean square of a state below which it counts as zero


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
    """The steps of a trajectory guess (n, nx): their corrections, and the block-bidiagonal matrix."""

    def __init__(self, equations: Equations, values: Mapping[str, float], motion: Motion):
        self.equations, self.nodes = equations, {**values, "time": motion.time, **motion.at}
        self.step = recorded_step(motion.formula, len(equations.states), *equations.patterns)
        inner = inner_times(motion.time, motion.formula)
        self.middles = {**values, "time": inner, **motion.between, STEP: motion.step}
        self.n, self.nx = len(motion.time), len(equations.states)
        self.begins, self.transitions = motion.begins, motion.begins[1:] - 1
        self.lengths = np.diff([*self.begins, self.n])  # nodes of each piece
        self.at_middle: dict[str, Any] = {}
        self.inverse: dict[str, Any] = {}

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

    def relative(self, change: np.ndarray, x: np.ndarray, begins: np.ndarray) -> np.ndarray:
        """The root mean square of each state's change (nx, n-1) in a group of pieces, over that of the state x (nx, n) and
        of its change: the largest of all states (groups,). begins are the first nodes of the groups.

        That of the state is the one in the group or, where it is larger, the median of all groups: a piece at rest needs
        no further steps, and one that diverges does not end those of the others.
        """
        lengths = np.diff([*begins, self.n])
        size = np.sqrt(np.add.reduceat(change**2, begins, axis=1) / (lengths - 1))
        level = np.sqrt(np.add.reduceat(x**2, begins, axis=1) / lengths)
        level = np.maximum(level, np.median(level, axis=1, keepdims=True))
        return np.max(size / (level + size + SMALLEST), axis=0)

    def evaluate(self, x: np.ndarray) -> None:
        """Rates, outputs and derivatives at the nodes of a trajectory (nx, n)."""
        self.at_nodes = self.nodes | dict(zip(self.equations.states, x, strict=True))
        self.rows, self.slopes = self.equations(self.at_nodes)
        rates = {(i, 0): f for i, f in enumerate(self.rows[: self.nx])}
        states = {(i, 0): each for i, each in enumerate(x)}
        self.at_ends = self._at_ends("x", states) | self._at_ends("f", rates)

    def corrections(self) -> np.ndarray:
        """The correction (n-1, nx) of the end of every step by its own defect."""
        self._evaluate_inner_points()
        rates, slopes = self.equations(self.at_inner)
        self.at_middle = named("M", rows(slopes, 0, self.nx))
        values = self.middles | self.at_ends | self._at_ends("A", rows(self.slopes, 0, self.nx)) | self.at_middle
        self.values = values | named("fm", {(i, 0): f for i, f in enumerate(rates[: self.nx])})
        _, correction, self.transition, inverse = (self._cut(each) for each in self.step.newton(self.values))
        self.inverse = named("inverse", inverse)
        return self._columns(correction, 0)

    def replace_transitions(self, which: np.ndarray, transition: Entries) -> None:
        """Set the transitions of the steps `which` (m,) to these, numbers or arrays (m,)."""
        for place, value in transition.items():
            self.transition[place] = self.transition[place] + np.zeros(self.n - 1)
            self.transition[place][which] = value

    def changes(self, corrections: np.ndarray) -> np.ndarray:
        """The change (nx, n-1) of the states that these corrections (n-1, nx) give; the matrix is made with it."""
        self.make_matrix()
        return carried(self.band, corrections.copy()).T

    def make_matrix(self) -> None:
        """The block-bidiagonal matrix, from the transitions that came with the corrections."""
        self.band = chain(part(self.transition, slice(1, None)), self.nx, self.n - 1)

    def _evaluate_inner_points(self) -> None:
        """The values at the inner points of the steps."""
        inner = self.step.inner(self.middles | self.at_ends)
        self.at_inner = self.middles | {n: inner[i, 0] for i, n in enumerate(self.equations.states)}

    def _at_ends(self, kind: str, entries: Entries) -> dict[str, Any]:
        """A matrix at the nodes at both ends of the steps, by name."""
        first, second = part(entries, slice(None, -1)), part(entries, slice(1, None))
        return named(f"{kind}1", first) | named(f"{kind}2", second)

    def outputs(self) -> np.ndarray:
        """(n, ny)"""
        return np.column_stack([np.broadcast_to(y, self.n) for y in self.rows[self.nx :]])

    def update_outputs(self, change: np.ndarray) -> None:
        """The outputs after a small change (nx, n-1) of the states."""
        for (i, j), c in sorted(self.slopes.items(), key=lambda entry: entry[0]):
            if i >= self.nx and not is_zero(c):
                self.rows[i] = self.rows[i] + np.zeros(self.n)
                self.rows[i][1:] += (c[1:] if np.ndim(c) else c) * change[j]

    def by_parameters(self) -> np.ndarray:
        """Derivatives of the outputs (n, ny, np) by each parameter."""
        self._evaluate_inner_points()
        at_nodes, at_inner = (self.equations.slopes(values) for values in (self.at_nodes, self.at_inner))
        values = self._at_ends("P", rows(at_nodes, 0, self.nx)) | named("Q", rows(at_inner, 0, self.nx))
        values |= self.middles | self.at_middle | self.inverse
        forced = self._cut(self.step.forced(self.equations.pattern_of_parameters, values))
        count = len(self.equations.parameters)
        used = {k for _, k in forced}
        columns = [self._columns(forced, k) if k in used else None for k in range(count)]
        return self._of_outputs(columns, rows(at_nodes, self.nx, len(self.rows)))

    def by_initial_states(self) -> np.ndarray:
        """Derivatives of the outputs (n, ny, nx) by the initial states of each one's piece."""
        result = self._of_outputs([self._first_steps(change) for change in np.eye(self.nx)], {})
        for (i, j), slope in rows(self.slopes, self.nx, len(self.rows)).items():
            result[self.begins, i, j] = slope[self.begins] if np.ndim(slope) else slope
        return result

    def change_after(self, changes: Mapping[int, np.ndarray]) -> np.ndarray:
        """The change (n, nx) of the states, to first order, by changes (nx,) of the initial states of some pieces."""
        of_pieces = np.zeros((len(self.begins), self.nx))
        of_pieces[list(changes)] = list(changes.values())
        result = np.concatenate([np.zeros((1, self.nx)), carried(self.band, self._first_steps(of_pieces))])
        result[self.begins] = of_pieces
        return result

    def _first_steps(self, changes: np.ndarray) -> np.ndarray:
        """The change (n-1, nx) of the end of every piece's first step by changes of its initial states, (pieces, nx) or
        (nx,) for all pieces."""
        column = np.zeros((self.n - 1, self.nx))
        for (i, j), slope in self.transition.items():
            column[self.begins, i] += (slope[self.begins] if np.ndim(slope) else slope) * changes[..., j]
        return column

    def _of_outputs(self, columns: Sequence[np.ndarray | None], direct: Entries) -> np.ndarray:
        """Derivatives of the outputs (n, ny, m) by m quantities, from the change (n-1, nx) of the end of every step that
        each of them makes, or None, and from the direct derivatives (ny, m)."""
        result = np.zeros((len(self.rows) - self.nx, len(columns), self.n))
        for place, slope in direct.items():
            result[place] = slope
        by_state = part(rows(self.slopes, self.nx, len(self.rows)), slice(1, None))
        for k, column in enumerate(columns):
            if column is not None:
                change = carried(self.band, column).T
                for (i, j), slope in sorted(by_state.items(), key=lambda entry: entry[0]):
                    if not is_zero(slope):
                        result[i, k, 1:] += slope * change[j]
        return np.moveaxis(result, 2, 0)

    def _cut(self, steps: Matrix) -> Matrix:
        """Entries over the steps, zero in the steps to the begin of a piece."""
        for place, value in steps.items():
            if len(self.transitions) and not is_zero(value):
                steps[place] = value + np.zeros(self.n - 1)
                steps[place][self.transitions] = 0.0
        return steps

    def _columns(self, steps: Entries, k: int) -> np.ndarray:
        """Column k (n-1, nx) of a matrix over the steps."""
        column = np.zeros((self.n - 1, self.nx))
        for (i, j), value in steps.items():
            if j == k:
                column[:, i] = value
        return column


def root_mean_square(x: np.ndarray) -> np.ndarray:
    """The root mean square (nx,) of each row."""
    return np.sqrt(np.einsum("ij,ij->i", x, x) / x.shape[1])
