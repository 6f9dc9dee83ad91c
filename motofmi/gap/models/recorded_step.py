"""One simulation step of an implicit formula, recorded once and evaluated for all steps of a trajectory together.

    after dx_k+1 = before dx_k - d_k + forcing dp

    d       = x_k+1 - x_k - s (u f_k + v f_m + w f_k+1),   f_m at x_m = a x_k + b x_k+1 + h (p f_k + q f_k+1)
    before  = 1 + s (u A_k + v M (a + h p A_k)),           A = df/dx at the nodes, M = df/dx at x_m
    after   = 1 - s (w A_k+1 + v M (b + h q A_k+1)),       s = h / n
    forcing = s (u P_k + w P_k+1 + v (Q + h M (p P_k + q P_k+1))),   P = df/dp at the nodes, Q = df/dp at x_m

The coefficients are those of the formula (see `implicit_formulas`). As recorded operations, products with zero vanish and
common terms are evaluated once. `after` is near the identity where the simulation converges: it is inverted without
pivoting.

Source: Betts, Practical Methods for Optimal Control, 2nd ed. (2010), ch. 4.6.
"""

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from fmus.equations.numpy_program import Program
from fmus.expressions.forward_ad import Node, Recorder
from motofmi.gap.models.implicit_formulas import ImplicitFormula
from motofmi.gap.models.time_varying_matrices import Entries, Matrix, identity, inverse, product, scaled, total

STEP = "time step"  # name of the value h [s]; like those of matrix entries, it can be no name of a component
Values = dict[str, Any]  # numbers, or arrays over the steps, by the name of a leaf
Pattern = tuple[tuple[tuple[int, int], float | None], ...]  # the places of a matrix, with the numbers that are constant


def pattern_of(entries: Entries) -> Pattern:
    """The pattern of recorded entries, nodes or numbers."""
    return tuple((place, None if isinstance(x, Node) else float(x)) for place, x in entries.items())


def named(kind: str, entries: Entries) -> Values:
    """The entries of a matrix by the names of their leaves."""
    return {f"{kind}{i},{j}": x for (i, j), x in entries.items()}


class RecordedStep:
    """The step of a formula for any component with nx states and these patterns of f (nx, 1) and df/dx (nx, nx).

    The values of its methods have the names of the formulas: `x1`, `f1`, `A1` at the begin of a step, `x2`, `f2`, `A2`
    at its end, `fm` and `M` at its inner point, each as `named` names them, and `STEP`.
    """

    def __init__(self, formula: ImplicitFormula, nx: int, rates: Pattern, by_state: Pattern):
        self.formula, self.recorder = formula, Recorder()
        (a, b, p, q), (u, v, w), h, s = formula.inner, formula.step, *self._steps()
        states = tuple(((i, 0), None) for i in range(nx))
        x1, f1, A1, x2, f2, A2, fm, M = (
            self._leaves(kind, pattern)
            for kind, pattern in zip(
                ("x1", "f1", "A1", "x2", "f2", "A2", "fm", "M"),
                (states, rates, by_state, states, rates, by_state, rates, by_state),
                strict=True,
            )
        )
        unit = identity(nx)
        self._inner = _Matrices(total(total(scaled(a, x1), x2, b), total(scaled(p, f1), f2, q), h))
        defect = total(total(x2, x1, -1.0), total(total(scaled(u, f1), fm, v), f2, w), -s)
        before = total(unit, total(scaled(u, A1), product(M, total(scaled(a, unit), A1, h * p)), v), s)
        after = total(unit, total(scaled(w, A2), product(M, total(scaled(b, unit), A2, h * q)), v), -s)
        solved = inverse(after, nx)
        self._newton = _Matrices(defect, product(solved, scaled(-1.0, defect)), product(solved, before), solved)
        self._solved, self._by_middle = pattern_of(solved), by_state
        self._forced: dict[Pattern, _Matrices] = {}

    def inner(self, values: Values) -> Matrix:
        """x_m (nx, 1) from x and f at the nodes."""
        return self._inner(values)[0]

    def newton(self, values: Values) -> list[Matrix]:
        """The defect d (nx, 1), the correction -after^-1 d (nx, 1), after^-1 before (nx, nx), and after^-1 (nx, nx)."""
        return self._newton(values)

    def forced(self, by_parameter: Pattern, values: Values) -> Matrix:
        """after^-1 forcing (nx, np) from `P1`, `P2` and `Q` of this pattern, `M`, and `inverse`, which is
        after^-1."""
        if by_parameter not in self._forced:
            (_, _, p, q), (u, v, w), h, s = self.formula.inner, self.formula.step, *self._steps()
            P1, P2, Q = (self._leaves(kind, by_parameter) for kind in ("P1", "P2", "Q"))
            solved, M = self._leaves("inverse", self._solved), self._leaves("M", self._by_middle)
            inner = total(Q, product(M, total(scaled(p, P1), P2, q)), h)
            forcing = total(total(scaled(u, P1), P2, w), inner, v)
            self._forced[by_parameter] = _Matrices(product(solved, scaled(s, forcing)))
        return self._forced[by_parameter](values)[0]

    def _steps(self) -> tuple[Node, Any]:
        """h and s."""
        h = self.recorder.leaf(STEP)
        return h, h * (1 / self.formula.divisor)

    def _leaves(self, kind: str, pattern: Pattern) -> Matrix:
        names = named(kind, dict(pattern))
        return {
            place: self.recorder.leaf(name) if number is None else number
            for (place, number), name in zip(pattern, names, strict=True)
        }


# The pattern of a component is that of most effects at its elements: few steps are recorded in a search.
recorded_step = lru_cache(maxsize=256)(RecordedStep)


class _Matrices:
    """Recorded matrices as one program."""

    def __init__(self, *matrices: Matrix):
        self.places = [list(matrix) for matrix in matrices]
        self.program = Program([x for matrix in matrices for x in matrix.values()])

    def __call__(self, values: Mapping[str, Any]) -> list[Matrix]:
        found = iter(self.program(values))
        return [{place: next(found) for place in places} for places in self.places]
