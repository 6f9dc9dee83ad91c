"""Newton's method for the states of a trajectory at all samples together.

All pieces take the same steps of the method, or each group of pieces takes its own. A step that is longer than the one
before is halved. Simulation steps whose corrections alternate are solved alone (see `nonlinear_elimination`).

Source: Deuflhard, Newton Methods for Nonlinear Problems (2004), ch. 3; Ascher, Mattheij, Russell (1995).
"""

import numpy as np

from motofmi.gap.models.collocation import LARGEST, Collocation
from motofmi.gap.models.nonlinear_elimination import NonlinearElimination

CONVERGED = 3e-5  # step over a state's rms at convergence: states are in error by about its square, slopes at kinks by itself
STEPS = 40  # at most


def converged(steps: Collocation, x: np.ndarray, begins: np.ndarray, accuracy: float, held: int) -> np.ndarray:
    """The states (n, nx) after Newton's method from a guess (nx, n), which is overwritten. Raises
    DivergenceError.

    begins are the first nodes of groups of pieces. Each group converges by itself: it then keeps its states, and where
    they are no longer finite it returns to its guess and takes no further steps.
    """
    nx, linear, guess = steps.nx, steps.equations.linear, x.copy()
    group = np.repeat(np.arange(len(begins)), np.diff([*begins, steps.n]))  # of each node
    update = np.full(len(begins), np.inf)
    open_, lost = np.ones(len(update), bool), np.zeros(len(update), bool)
    elimination = NonlinearElimination(steps, accuracy)
    for _ in range(STEPS):
        steps.evaluate(x)
        if not nx:
            break
        corrections = steps.corrections()
        if held == nx:  # the guess is the trajectory
            steps.make_matrix()
            break
        corrections[~open_[group[1:]]] = 0.0
        corrections = elimination.corrected(corrections, x, held)
        change = steps.changes(corrections)
        before, update = update, steps.relative(change, x, begins)
        if not np.abs(change).max() < LARGEST:
            infinite = ~steps.finite(corrections)
            if len(begins) == 1:
                raise steps.divergence(infinite)
            lost |= infinite
            open_ &= ~infinite
            if not open_.any():
                raise steps.divergence(lost)
            x[:, infinite[group]] = guess[:, infinite[group]]
            update = before
            continue
        share = np.where(update <= before, 1.0, 0.5)
        x[:, 1:] += share[group[1:]] * change
        open_ &= update > accuracy
        if linear:
            steps.evaluate(x)
            break
        if not open_.any():
            steps.update_outputs(change)
            break
    else:
        lost |= open_
        steps.evaluate(x)
    if lost.any():
        apart = len(begins) == len(steps.begins)
        raise steps.divergence(lost if apart else steps.relative(change, x, steps.begins) > accuracy)
    return x.T
