"""The rows of a component's table: one variable each, everything that is known of it said once."""

from dataclasses import dataclass, replace
from math import inf

from fmus.units import unit


@dataclass(frozen=True)
class Variable:
    """One row of a component's table.

    role is one of `parameter`, `calculated` (follows from the parameters), `input`, `output`, `state`,
    `local` (a named point of the equations where an effect can add something).
    `exposed` makes a state an output as well. `port` names the port that the variable belongs to and
    `flow` marks what sums up there (torques), as `inflow` does in an FMI 3 terminal.
    """

    role: str
    unit: str
    description: str
    symbol: str = ""
    start: float = 0.0
    min: float = -inf
    max: float = inf
    nominal: float = 1.0
    exposed: bool = False
    port: str = ""
    flow: bool = False
    tunable: bool = True
    name: str = ""

    def named(self, name: str) -> "Variable":
        """The same row under a name."""
        return replace(self, name=name)

    @property
    def latex(self) -> str:
        """The symbol for a formula; the name itself where no symbol is declared."""
        return self.symbol or r"\mathrm{" + self.name.replace("_", r"\_") + "}"


def _row(role: str, si_unit: str, description: str, options: dict) -> Variable:
    assert unit(si_unit).factor == 1.0, f"declare variables in SI, not in [{si_unit}]"
    row = Variable(role, si_unit, description, **options)
    return replace(row, start=min(max(row.start, row.min), row.max))


def parameter(si_unit: str, description: str, **options) -> Variable:
    """A constant of the component. Its values live in .toml files; `start` is the default, moved into the bounds.

    `tunable=False` marks one that may not change while a simulation runs.
    """
    return _row("parameter", si_unit, description, options)


def calculated(si_unit: str, description: str, **options) -> Variable:
    """A number that follows from the parameters alone."""
    return _row("calculated", si_unit, description, options)


def input(si_unit: str, description: str, **options) -> Variable:
    """What the component is told."""
    return _row("input", si_unit, description, options)


def output(si_unit: str, description: str, **options) -> Variable:
    """What the component answers."""
    return _row("output", si_unit, description, options)


def state(si_unit: str, description: str, **options) -> Variable:
    """A continuous state; the equations return its `der(name)`."""
    return _row("state", si_unit, description, options)


def local(si_unit: str, description: str, **options) -> Variable:
    """A named point of the equations: they set it (`v.arm_torque = ...`), effects may add to it."""
    return _row("local", si_unit, description, options)
