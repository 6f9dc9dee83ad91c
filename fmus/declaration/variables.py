"""Variables of components: role, unit, description, symbol, start value and bounds, declared once."""

from dataclasses import dataclass, replace
from math import inf

from fmus.declaration.units import unit

# The usual size of a state by its unit, in the lateral motion of a motorcycle at the limit of its linear range: 0.1 rad
# (6 deg) of steer or roll, at wobble (10 Hz, which is 60 rad/s) a few rad/s. The absolute tolerance of an importer's
# solver in model exchange is its relative tolerance times this number. A declared `nominal` comes first.
NOMINAL = {"rad": 0.1, "rad/s": 1.0, "m": 0.1, "m/s": 1.0, "N": 100.0, "N.m": 10.0, "N.m.s": 1.0}


@dataclass(frozen=True)
class Variable:
    """One variable of a component.

    role is one of `parameter`, `calculated` (a function of the parameters), `input`, `output`, `state` and `local` (an
    intermediate quantity of the equations to which effects can add). unit is an SI unit; start, min, max and nominal
    are in that unit. `exposed` makes a state an output as well. `port` names the port that the variable belongs to;
    `flow` marks a quantity that is summed at a connection (a torque or a force). `tunable=False` marks a parameter
    that is fixed during a simulation.
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
        """A copy with that name."""
        return replace(self, name=name)

    @property
    def typical(self) -> float:
        """The usual size of the variable: its nominal where one is declared, else that of its unit."""
        return self.nominal if self.nominal != 1.0 else NOMINAL.get(self.unit, 1.0)

    @property
    def latex(self) -> str:
        """The LaTeX symbol; the name in upright letters where no symbol is declared."""
        return self.symbol or r"\mathrm{" + self.name.replace("_", r"\_") + "}"


def _row(role: str, si_unit: str, description: str, options: dict) -> Variable:
    assert unit(si_unit).factor == 1.0, f"declare variables in SI, not in [{si_unit}]"
    row = Variable(role, si_unit, description, **options)
    return replace(row, start=min(max(row.start, row.min), row.max))


def parameter(si_unit: str, description: str, **options) -> Variable:
    """A parameter. `start` is the default value, clipped to the bounds; value files (.toml) give others.

    options are `symbol`, `start`, `min`, `max` and `tunable` (False: fixed during a simulation).

        arm_stiffness = parameter("N.m/rad", "Stiffness of the arms", symbol="k_a", min=0, start=1053.4)
    """
    return _row("parameter", si_unit, description, options)


def calculated(si_unit: str, description: str, **options) -> Variable:
    """A calculated parameter: an output of the equations that depends on the parameters alone."""
    return _row("calculated", si_unit, description, options)


def input(si_unit: str, description: str, **options) -> Variable:
    """An input of the component."""
    return _row("input", si_unit, description, options)


def output(si_unit: str, description: str, **options) -> Variable:
    """An output of the component, which its equations return by name."""
    return _row("output", si_unit, description, options)


def state(si_unit: str, description: str, **options) -> Variable:
    """A continuous state; the equations return its `der(name)`. `exposed=True` makes it an output as well."""
    return _row("state", si_unit, description, options)


def local(si_unit: str, description: str, **options) -> Variable:
    """An intermediate quantity that the equations set (`v.arm_torque = ...`); effects may add to it."""
    return _row("local", si_unit, description, options)
