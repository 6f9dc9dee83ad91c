"""Nonlinear least squares within bounds, by the method of Levenberg and Marquardt with an exact Jacobian.

    (D^-1 J'J D^-1 + mu I) D step = -D^-1 J'r,     D = sqrt(diag J'J),     chi2 = |r|^2

mu grows by 6 when a step fails and shrinks by 10 when chi2 falls as the linear model predicts. Parameters at a
bound are left out of a step if the gradient points outwards. Unlike scipy.optimize.least_squares, the caller gives the
largest step of each parameter (`reach`), the least significant change of chi2 (`gain`), the chi2 of a rival that the
fit has to reach (`beat`), and the largest chi2 of a start (`most`). docs/decisions/least_squares.md has the measured
comparison.

Source: Marquardt, J. SIAM 11 (1963) 431-441; Madsen, Nielsen, Tingleff, Methods for Non-Linear Least
Squares Problems (2004).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fmus.support.deadline import time_is_up
from fmus.support.errors import InputError

COARSE = 1e-3  # share of chi2: the least significant change while a fit is far from the data
REMAINING_STEPS = 20.0  # steps with the gain of the next one within which a fit must be able to reach `beat`
TRIES = 8  # attempts at a step, with growing mu
# A simulation that diverges does not say how far the linear model holds: the step becomes much shorter at once, with mu
# at least the first and growing by the second, and after so many divergences the search ends.
DIVERGED, SHORTER, MOST_DIVERGED = 0.03, 36.0, 3


class Problem(Protocol):
    """Residuals and their Jacobian, which is computed at the x of the last residuals."""

    def residuals(self, x: np.ndarray) -> np.ndarray:
        """(m,). Raises InputError where the model cannot be simulated."""

    def slopes(self, x: np.ndarray) -> np.ndarray:
        """(m, len(x))"""

    def accepted(self) -> None:
        """The x of the last residuals is the best one so far."""


@dataclass(frozen=True)
class Solution:
    """The end of a search: x (n,), residuals (m,), their Jacobian (m, n), and chi2, the sum of squares."""

    x: np.ndarray
    chi2: float
    residuals: np.ndarray
    jacobian: np.ndarray


def levenberg_marquardt(problem: Problem, x: np.ndarray, bounds: tuple[np.ndarray, np.ndarray], free: np.ndarray,
                        reach: Callable[[np.ndarray], np.ndarray], gain: float, beat: float,
                        most: float, iterations: int) -> Solution:  # fmt: skip
    """The minimum of the sum of squares from x (n,) over the parameters `free` (indices).

    reach(x) (n,) bounds one step from x. The search ends when a step reduces chi2 by less than the share `gain`, or
    when chi2 is so far above `beat` that the next steps cannot reach it, or at a deadline; it is not begun
    where chi2 is above `most`. Raises InputError where the model cannot be simulated at the start.
    """
    low, high = bounds
    residuals, jacobian = problem.residuals(x), problem.slopes(x)
    problem.accepted()
    chi2, damping = float(residuals @ residuals), 1e-3
    for _ in range(iterations if chi2 <= most else 0):
        gradient = jacobian.T @ residuals
        open_ = [
            i for i in free if not (x[i] <= low[i] and gradient[i] > 0) and not (x[i] >= high[i] and gradient[i] < 0)
        ]
        part = jacobian[:, open_]
        normal = part.T @ part
        scale = np.sqrt(np.diag(normal)) + 1e-9
        largest, accepted, diverged = reach(x)[open_], False, 0
        worth = max(gain, COARSE * chi2) if chi2 > 2 * len(residuals) else gain
        for tries in range(TRIES):
            move = (
                np.linalg.solve(
                    normal / np.outer(scale, scale) + damping * np.eye(len(open_)), -gradient[open_] / scale
                )
                / scale
            )
            steps = [np.clip(x[open_] + each, low[open_], high[open_]) - x[open_] for each in _within(move, largest)]
            gains = [-float(2 * gradient[open_] @ step + step @ normal @ step) for step in steps]
            expected, trial = max(gains), x.copy()
            trial[open_] += steps[gains.index(expected)]
            unlimited = -float(
                2 * gradient[open_] @ move + move @ normal @ move
            )  # the gain of a shortened step does not bound that of the next ones
            if (
                time_is_up()
                or expected < worth
                or (not tries and chi2 - REMAINING_STEPS * max(expected, unlimited) > beat)
            ):
                break
            try:
                new_residuals = problem.residuals(trial)
                new = float(new_residuals @ new_residuals)
            except InputError:
                diverged += 1
                if diverged == MOST_DIVERGED:
                    break
                damping = max(SHORTER * damping, DIVERGED)
                continue
            if new < chi2:
                accepted = True
                break
            damping *= 6
        if not accepted:
            break
        x, residuals, won, chi2 = trial, new_residuals, chi2 - new, new
        problem.accepted()
        if won > gain:  # otherwise the Jacobian has hardly changed
            jacobian = problem.slopes(x)
        if won > 0.75 * expected and not tries:
            damping = max(damping / 10, 1e-9)
        if won < worth:
            break
    return Solution(x, chi2, residuals, jacobian)


def _within(move: np.ndarray, reach: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A move within its reach: every parameter limited by itself, which may change its direction, or all by one
    factor."""
    return np.clip(move, -reach, reach), move * min(1.0, float(np.min(reach / (np.abs(move) + 1e-300), initial=1.0)))
