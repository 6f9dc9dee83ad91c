"""Simulation steps that are solved alone, without the rest of the trajectory: the end of each from its begin.

Where a mass sticks, or a hysteresis reverses, the correction of a simulation step by its linearised defect alternates
from one side to the other, and Newton's method for the whole trajectory does not converge. The equations of such a step,

    d(x_k, y) = 0,   x_k fixed,

are solved for its end y by a Newton method of its own. The correction of the step is y - x_k+1, and its transition
that at (x_k, y): multiple shooting in these steps, collocation in the others. Where the begin of a step no longer
changes, its end is exact.

A correction alternates where it points against the one before and is longer than half of it. In the Newton method of a
simulation step, a correction is halved until the defect decreases (Armijo).

Source: Lanzkron, Rose, Wilkes, SIAM J. Sci. Comput. 17 (1996) 538-559, nonlinear elimination; Bock, Plitt, Proc. 9th IFAC
World Congress (1984) 1603-1608, multiple shooting; Deuflhard, Newton Methods for Nonlinear Problems (2004), ch. 3.
"""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from motofmi.gap.models.collocation import SMALLEST, Collocation, root_mean_square
from motofmi.gap.models.recorded_step import named
from motofmi.gap.models.time_varying_matrices import Entries, rows

MOST_CORRECTIONS = 10  # of the end of a simulation step, before the next correction of the whole trajectory
DECREASE = 0.25  # of the defect, over that of its linearisation, with which a correction is accepted
BEGIN = ("x1", "f1", "A1")  # values at the begin of a step, as `RecordedStep` names them


class NonlinearElimination:
    """The simulation steps of a trajectory whose corrections have alternated; they are solved alone from then on."""

    def __init__(self, steps: Collocation, accuracy: float):
        self.steps, self.accuracy = steps, accuracy
        self.alternating = np.zeros(steps.n - 1, bool)
        self.last: np.ndarray | None = None

    def corrected(self, corrections: np.ndarray, x: np.ndarray, held: int) -> np.ndarray:
        """The corrections (n-1, nx) of a trajectory (nx, n) with those of the steps that are solved alone. The transitions
        of these steps are replaced as well. The first `held` states have no corrections.
        """
        corrections[:, :held] = 0.0
        last, self.last = self.last, corrections
        if last is None:
            return corrections
        scale = root_mean_square(x)[:, None] + SMALLEST
        scaled, last = corrections.T / scale, last.T / scale
        length = _length(scaled)
        opposite = np.einsum("ik,ik->k", scaled, last) < 0
        self.alternating |= opposite & (length > np.maximum(_length(last) / 2, self.accuracy))
        which = np.flatnonzero(self.alternating & (length > 0))
        if len(which):
            corrections = corrections.copy()
            corrections[which], transition = _solved_alone(self.steps, which, x, scale, self.accuracy)
            corrections[:, :held] = 0.0
            self.steps.replace_transitions(which, transition)
        return corrections


def _solved_alone(
    steps: Collocation, which: np.ndarray, x: np.ndarray, scale: np.ndarray, accuracy: float
) -> tuple[np.ndarray, Entries]:
    """Corrections (m, nx) and transitions of the steps `which` (m,) of a trajectory (nx, n) whose corrections have been
    computed.

    scale (nx, 1) is the size of each state; accuracy is that of the ends over it.
    """
    step = _StepsAlone(steps, which)
    end = x[:, which + 1]
    defect, correction, transition = step.newton(end)
    size, share = _length(defect / scale), np.ones(len(which))
    for _ in range(MOST_CORRECTIONS):
        open_ = _length(correction / scale) > accuracy
        if not open_.any():
            break
        trial = end + share * correction
        defect, next_correction, next_transition = step.newton(trial)
        next_size = _length(defect / scale)
        accepted = open_ & (next_size <= (1.0 - DECREASE * share) * size)
        end, correction = np.where(accepted, trial, end), np.where(accepted, next_correction, correction)
        transition = {place: np.where(accepted, value, transition[place]) for place, value in next_transition.items()}
        size = np.where(accepted, next_size, size)
        share = np.where(accepted, np.minimum(2.0 * share, 1.0), share / 2.0)
    return (end + correction - x[:, which + 1]).T, transition


class _StepsAlone:
    """The equations of some steps (m,) as functions of their ends (nx, m)."""

    def __init__(self, steps: Collocation, which: np.ndarray):
        self.steps, self.count = steps, len(which)
        self.at_end = _at(which + 1, steps.nodes)
        self.middles = _at(which, steps.middles)
        self.begin = _at(which, {n: value for n, value in steps.values.items() if n.startswith(BEGIN)})

    def newton(self, end: np.ndarray) -> tuple[np.ndarray, np.ndarray, Entries]:
        """The defect (nx, m), the correction (nx, m) of the end, and the transition."""
        equations, step, nx = self.steps.equations, self.steps.step, self.steps.nx
        found, slopes = equations(self.at_end | dict(zip(equations.states, end, strict=True)))
        values = self.middles | self.begin | named("x2", _column(end)) | named("f2", _column(found[:nx]))
        inner = step.inner(values)
        at_inner = {name: inner[i, 0] for i, name in enumerate(equations.states)}
        found_inner, slopes_inner = equations(self.middles | at_inner)
        values |= named("A2", rows(slopes, 0, nx)) | named("M", rows(slopes_inner, 0, nx))
        defect, correction, transition, _ = step.newton(values | named("fm", _column(found_inner[:nx])))
        return self._rows(defect), self._rows(correction), transition

    def _rows(self, column: Entries) -> np.ndarray:
        """A column of entries as an array (nx, m)."""
        made = np.zeros((self.steps.nx, self.count))
        for (i, _), value in column.items():
            made[i] = value
        return made


def _at(indices: np.ndarray, values: Mapping[str, Any]) -> dict[str, Any]:
    """Values at some nodes or steps."""
    return {name: value[indices] if np.ndim(value) else value for name, value in values.items()}


def _column(values: Iterable[Any]) -> Entries:
    """A value of each state as a column."""
    return {(i, 0): value for i, value in enumerate(values)}


def _length(vectors: np.ndarray) -> np.ndarray:
    """Of each column (m,)."""
    return np.sqrt(np.einsum("ij,ij->j", vectors, vectors))
