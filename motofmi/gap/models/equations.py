"""A component's equations on whole recordings: rates, outputs and their derivatives, each a number
or an array over time.

Derivatives by states, which every Newton step needs, and those by parameters are computed separately.

    x' = f(x, u, p, t),   y = g(x, u, p, t),   with df/dx, df/dp, dg/dx, dg/dp
"""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from fmus.declaration.component import Component
from fmus.equations.numpy_program import Program, recorded_equations, slopes_of
from fmus.expressions.derivative_rules import JUMPS
from fmus.expressions.forward_ad import Node
from motofmi.gap.models.recorded_step import pattern_of
from motofmi.gap.models.time_varying_matrices import Matrix, rows


class Equations:
    """Rates and outputs of a component, with slopes by its states and by some parameters.

    linear says that they are linear in the states. The slope by the delay of an input needs that input's rate among
    the values, under the name `rate_of(input)`.
    """

    def __init__(self, component: Component, outputs: Sequence[str], parameters: Sequence[str]):
        form = recorded_equations(component)
        self.component, self.outputs, self.parameters = component, tuple(outputs), tuple(parameters)
        self.states = component.states
        self.rows = form.explicit_rates + [
            form.outputs[component.outputs.index(component.sensor_output(n))] for n in self.outputs
        ]
        late = {delay: name for name, (_, delay) in component.delays.items()}
        self.by_state, self.by_parameter = (
            slopes_of(self.rows, unknowns, partial(_slope, late=late)) for unknowns in (self.states, self.parameters)
        )
        nx = len(self.states)
        self.patterns = (
            pattern_of({(i, 0): rate for i, rate in enumerate(self.rows[:nx])}),
            pattern_of(rows(self.by_state, 0, nx)),
        )
        self.pattern_of_parameters = pattern_of(rows(self.by_parameter, 0, nx))
        self.program = Program([*self.rows, *self.by_state.values()])
        self.of_parameters = Program(list(self.by_parameter.values()))
        own = frozenset(self.states)
        nonlinear = [s for s in self.by_state.values() if isinstance(s, Node)]
        jumps = [n for n in (*self.program.nodes, *self.of_parameters.nodes) if n.word in JUMPS]
        self.linear = all(own.isdisjoint(node.depends) for node in (*nonlinear, *jumps))

    def __call__(self, values: Mapping[str, Any]) -> tuple[list[Any], Matrix]:
        """Rates and outputs, and the matrix (nx + ny, nx) of their slopes by the states; entries are
        numbers or arrays (n,)."""
        results = self.program(values)
        return results[: len(self.rows)], dict(zip(self.by_state, results[len(self.rows) :], strict=True))

    def slopes(self, values: Mapping[str, Any]) -> Matrix:
        """The matrix (nx + ny, np) of the slopes of rates and outputs by the parameters; entries are
        numbers or arrays (n,)."""
        return dict(zip(self.by_parameter, self.of_parameters(values), strict=True))


def rate_of(name: str) -> str:
    """The name under which the rate of a delayed input is given."""
    return f"der({name})"


def _slope(row: Node, x: str, late: Mapping[str, str]) -> Any:
    """dr/dx; by the delay of an input that is dr/du times -u'."""
    slope = row.slope(x)
    return slope - row.slope(late[x]) * row.recorder.leaf(rate_of(late[x])) if x in late else slope
