"""A nonlinear component simulated over a whole recording at once, with its sensitivities to parameters.

Between two nodes the states follow an implicit formula with one inner point (see `implicit_formulas`).
The states at all samples are solved for together by Newton's method. The matrix is block-bidiagonal, so a step is one
banded triangular solve, and the same matrix gives dx/dp of every parameter: cost is linear in samples. Several pieces
of a recording, each with its own initial states, form one trajectory without transitions between them.

All pieces have the same steps of Newton's method. Where many pieces do not converge, each has steps of its own. A step
that is longer than the one before is halved. Where a mass sticks or a hysteresis reverses, the corrections of simulation
steps alternate: those are solved alone (see `nonlinear_elimination`).

Source: Betts, Practical Methods for Optimal Control, 2nd ed. (2010), ch. 4.6; Ascher, Mattheij, Russell (1995);
Deuflhard, Newton Methods for Nonlinear Problems (2004), ch. 3.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np

from fmus.support.errors import InputError
from motofmi.gap.models.collocation import Collocation, DivergenceError, Motion
from motofmi.gap.models.equations import Equations
from motofmi.gap.models.newton_method import CONVERGED, converged

MOST_HALVINGS = 8  # of the step of a continuation: where simulations alternately converge and diverge, it ends
# Pieces from which each converges by itself where they do not converge together: one simulation then shows which of them
# diverge. With fewer pieces, repeated simulations of those that do not diverge take less time.
MANY_PIECES = 16


class Trajectory:
    """States (n, nx) and outputs (n, ny); their derivatives are computed on demand."""

    def __init__(self, states: np.ndarray, steps: Collocation, with_initial: bool):
        self.states, self._steps = states, steps
        self.outputs = steps.bounded(steps.outputs())
        initial = with_initial and steps.nx
        self.initial_slopes = (
            steps.bounded(steps.by_initial_states()) if initial else None
        )  # (n, ny, nx), by the initial states of each one's piece

    @np.errstate(all="ignore")
    def states_after(self, changes: Mapping[int, np.ndarray]) -> np.ndarray:
        """The states (n, nx), to first order, after changes (nx,) of the initial states of pieces, by the first node of
        each."""
        begins = self._steps.begins.tolist()
        return self.states + self._steps.change_after({begins.index(first): x for first, x in changes.items()})

    @cached_property
    @np.errstate(all="ignore")
    def slopes(self) -> np.ndarray:
        """Of the outputs by the parameters (n, ny, np). Raises DivergenceError where they are not finite."""
        return self._steps.bounded(self._steps.by_parameters())


@np.errstate(all="ignore")  # divergence raises an InputError
def simulate(equations: Equations, values: Mapping[str, float], motion: Motion, start: np.ndarray | None = None,
             initial: np.ndarray | None = None, with_initial: bool = False,
             accuracy: float = CONVERGED, held: int = 0) -> Trajectory:  # fmt: skip
    """The trajectory for parameter values by name, from a guess of the states (n, nx), starting at `initial`
    (nx,) or (pieces, nx).

    accuracy is the largest last step of Newton's method over a state's rms. The first `held` states keep their guess: the
    trajectory without the others, which do not influence it. Raises DivergenceError where it does not converge, or is
    not finite.
    """
    n, nx = len(motion.time), len(equations.states)
    x = np.zeros((nx, n)) if start is None else np.array(start.T, order="C")
    if initial is not None:
        x[:, motion.begins] = np.atleast_2d(initial).T
    steps, together = Collocation(equations, values, motion), np.zeros(1, int)
    try:
        states = converged(steps, x.copy(), together, accuracy, held)
    except DivergenceError:
        if len(motion.begins) < MANY_PIECES:
            raise
        states = converged(steps, x, motion.begins, accuracy, held)
    return Trajectory(states, steps, with_initial)


def simulate_by_continuation(
    equations: Equations, values: Mapping[str, float], motion: Motion, sizes: Sequence[str]
) -> Trajectory:
    """The trajectory without a good guess, by continuation in the magnitudes `sizes`, which grow from zero.

    The step is halved where a simulation diverges, and doubled where it does not. Raises InputError where it was halved
    MOST_HALVINGS times in all and the simulation diverges again.
    """
    share, step, states, halvings = 0.0, 1.0, None, 0
    while True:
        grown = min(share + step, 1.0)
        try:
            made = simulate(equations, {**values, **{n: grown * values[n] for n in sizes}}, motion, states)
        except InputError:
            step, halvings = step / 2, halvings + 1
            if halvings > MOST_HALVINGS:
                raise
            continue
        if grown == 1.0:
            return made
        share, step, states = grown, 2 * step, made.states
