"""A nonlinear component simulated over a whole recording at once, with its sensitivities to parameters.

Between two nodes the states follow an implicit formula with one inner point (see `implicit_formulas`).
The states at all samples are solved for together by Newton's method. The matrix is block-bidiagonal, so a step is one
banded triangular solve, and the same matrix gives dx/dp of every parameter: cost is linear in samples. Several pieces
of a recording, each with its own initial states, form one trajectory without transitions between them.

All pieces have the same steps of Newton's method. Where many pieces do not converge, each has steps of its own.

Where a mass sticks, the correction of one simulation step alternates from one side of zero rate to the other and
does not decrease. The corrections of such steps are damped one by one, each further as long as it changes its sign. Where
this does not converge, the simulation is tried once more with earlier and gentler damping, which is slower.

Source: Betts, Practical Methods for Optimal Control, 2nd ed. (2010), ch. 4.6; Ascher, Mattheij, Russell (1995);
Deuflhard, Newton Methods for Nonlinear Problems (2004), ch. 3, for damping.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np

from fmus.support.errors import InputError
from motofmi.gap.models.collocation import Collocation, DivergenceError, Motion, inner_times, root_mean_square
from motofmi.gap.models.equations import Equations
from motofmi.gap.models.time_varying_matrices import carried

CONVERGED = 1e-4  # step over a state's rms at convergence; the error after such a step is of the order of its square
STEPS = 30  # of Newton's method
# Steps after which corrections that alternate are damped, and the ratio of their factors from one step to the next: first,
# where a slow convergence ends before, and in the second attempt.
DAMPING = ((12, 2.0), (6, 1.4))
# Pieces from which each converges by itself where they do not converge together: one simulation then shows which of them
# diverge. With fewer pieces, repeated simulations of those that do not diverge take less time.
MANY_PIECES = 16
LEAST_FACTOR = 2.0**-12  # on the correction of a step that alternates
NOT_CONVERGED = 0.1  # step over a state's rms above which the trajectory has not converged
MOST_HALVINGS = 8  # of the step of a continuation: where simulations alternately converge and diverge, it ends


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
             accuracy: float | None = None, held: int = 0) -> Trajectory:  # fmt: skip
    """The trajectory for parameter values by name, from a guess of the states (n, nx), starting at `initial`
    (nx,) or (pieces, nx).

    accuracy is the largest last step of Newton's method over a state's rms; without it CONVERGED, or NOT_CONVERGED
    where the steps become no smaller. The first `held` states keep their guess: the trajectory without the others,
    which do not influence it. Raises DivergenceError where it does not converge, or is not finite.
    """
    n, nx = len(motion.time), len(equations.states)
    x = np.zeros((nx, n)) if start is None else np.array(start.T, order="C")
    if initial is not None:
        x[:, motion.begins] = np.atleast_2d(initial).T
    nodes = {**values, "time": motion.time, **motion.at}
    middles = {**values, "time": inner_times(motion.time, motion.formula), **motion.between}
    steps = Collocation(equations, nodes, middles, motion)
    together = np.zeros(1, int)
    for begins in (together, motion.begins)[: 1 + (len(motion.begins) >= MANY_PIECES)]:
        for each in DAMPING:
            damping = _Damping(n - 1, *each)
            try:
                return Trajectory(_converged(steps, x.copy(), begins, damping, accuracy, held), steps, with_initial)
            except DivergenceError as error:
                diverged = error
                if not damping.alternates:
                    break
    raise diverged


def _converged(
    steps: Collocation, x: np.ndarray, begins: np.ndarray, damping: "_Damping", accuracy: float | None, held: int
) -> np.ndarray:
    """The states (n, nx) after Newton's method from a guess (nx, n), which is overwritten. Errors as `simulate`.

    begins are the first nodes of groups of pieces. Each group converges by itself: it then keeps its states, and where
    they are no longer finite it returns to its guess and takes no further steps.
    """
    nx, linear, guess = steps.nx, steps.equations.linear, x.copy()
    group = np.repeat(np.arange(len(begins)), np.diff([*begins, steps.n]))  # of each node
    update = np.full(len(begins), np.inf)
    open_, lost = np.ones(len(update), bool), np.zeros(len(update), bool)
    for done in range(STEPS):
        steps.evaluate(x)
        if not nx:
            break
        corrections = steps.corrections()
        corrections[:, :held] = 0.0
        corrections[~open_[group[1:]]] = 0.0
        change = carried(steps.band, corrections.copy()).T
        before, update = update, steps.relative(change, x, begins)
        if not np.all(np.isfinite(update)):
            infinite = ~steps.finite(corrections)
            if len(begins) == 1:
                raise steps.divergence(infinite)
            lost |= infinite
            open_ &= ~infinite
            if not done or not open_.any():
                raise steps.divergence(lost)
            x[:, infinite[group]] = guess[:, infinite[group]]
            update = before
            continue
        cycle = open_ & (CONVERGED < update) & (update < NOT_CONVERGED) & (done >= damping.begin)
        if cycle.any() and damping.after(corrections / (root_mean_square(x) + 1e-300)).min() < 1:
            factors = np.where(cycle[group[1:]], damping.factors, 1.0)
            change = carried(steps.band, corrections * factors[:, None]).T
        settled, kink = _ended(update, before, accuracy)
        share = np.where(settled | (update < np.maximum(0.5 * before, NOT_CONVERGED)), 1.0, 0.5)
        x[:, 1:] += share[group[1:]] * change
        changed = linear or bool(np.any(open_ & kink & ~settled))  # by more than to first order
        open_ &= ~(settled | kink)
        if linear or not open_.any():
            if changed:
                steps.evaluate(x)
            else:
                steps.update_outputs(change)
            break
    else:
        lost |= open_ & (bool(accuracy) | (update > NOT_CONVERGED))
        steps.evaluate(x)
    if lost.any():
        apart = len(begins) == len(steps.begins)
        raise steps.divergence(lost if apart else steps.relative(change, x, steps.begins) > NOT_CONVERGED)
    return x.T


def _ended(update: np.ndarray, before: np.ndarray, accuracy: float | None) -> tuple[np.ndarray, np.ndarray]:
    """Whether each group (groups,) has converged, and whether it converges no further since a kink is between samples,
    by its last two steps over the states."""
    kink = (update < 1e-3) & (before < 1e-2) & (update > 0.2 * before) & (not accuracy)
    return update < (accuracy or CONVERGED), kink


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


class _Damping:
    """Factors (steps,) on the corrections of simulation steps, less than 1 where a correction alternates; from step
    `begin` of Newton's method on, they change by `ratio` at each."""

    def __init__(self, count: int, begin: int, ratio: float):
        self.begin, self.ratio, self.alternates = begin, ratio, False
        self.factors, self.last = np.ones(count), np.zeros((count, 0))

    def after(self, corrections: np.ndarray) -> np.ndarray:
        """The factors on these corrections (steps, nx), which are over the size of each state [1].

        A correction alternates where it points against the one before and is longer than half of it.
        """
        if self.last.shape == corrections.shape:
            along = np.einsum("ki,ki->k", corrections, self.last)
            lengths = (np.einsum("ki,ki->k", each, each) for each in (corrections, self.last))
            alternates = (along < 0) & (next(lengths) > 0.25 * next(lengths))
            smaller, larger = np.maximum(self.factors / self.ratio, LEAST_FACTOR), self.factors * self.ratio
            self.factors = np.where(alternates, smaller, np.minimum(larger, 1.0))
            self.alternates = self.alternates or bool(alternates.any())
        self.last = corrections
        return self.factors
