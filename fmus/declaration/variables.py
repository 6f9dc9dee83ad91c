"""Variables of components: role, unit, description, symbol, start value and bounds, declared once."""

from dataclasses import dataclass, replace
from math import inf

from fmus.declaration.units import unit
from fmus.support.errors import InputError

# The usual size of a state by its unit, in the lateral motion of a motorcycle at the limit of its linear range: 0.1 rad
# (6 deg) of steer or roll, at wobble (10 Hz, which is 60 rad/s) a few rad/s. The absolute tolerance of an importer's
# solver in model exchange is its relative tolerance times this number. A declared `nominal` comes first.
NOMINAL = {"rad": 0.1, "rad/s": 1.0, "m": 0.1, "m/s": 1.0, "N": 100.0, "N.m": 10.0, "N.m.s": 1.0}


@dataclass(frozen=True)
class Variable:
    r"""One variable of a component.

    role is one of `parameter`, `calculated` (a function of the parameters), `input`, `output`, `state` and `local` (an
    intermediate quantity of the equations to which effects can add). unit is an SI unit; start, min, max and nominal
    are in that unit. `exposed` makes a state an output as well. `port` names the port that the variable belongs to;
    `flow` marks a quantity that is summed at a connection (a torque or a force). `tunable=False` marks a parameter
    that is fixed during a simulation.

        >>> angle = mf.state("rad", "Angle of the torso", symbol=r"\theta").named("torso_angle")
        >>> angle.name, angle.latex, angle.typical
        ('torso_angle', '\\theta', 0.1)
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
    if unit(si_unit).factor != 1.0:
        raise InputError(f"{description!r} is declared in [{si_unit}]: declare variables in SI units, as in [rad]")
    row = Variable(role, si_unit, description, **options)
    return replace(row, start=min(max(row.start, row.min), row.max))


def parameter(si_unit: str, description: str, **options) -> Variable:
    """A parameter in an SI unit. `start` is the default value, clipped to the bounds; value files (.toml) give others.

    options are `symbol`, `start`, `min`, `max` (in the unit) and `tunable` (False: fixed during a simulation). Raises
    InputError for a unit that is unknown or not in SI, as every declaration does.

        >>> mf.parameter("N.m/rad", "Stiffness of the arms", symbol="k_a", min=0, start=1053.4).start
        1053.4
        >>> mf.parameter("deg", "Caster angle")
        Traceback (most recent call last):
        fmus.support.errors.InputError: 'Caster angle' is declared in [deg]: declare variables in SI units, as in [rad]
    """
    return _row("parameter", si_unit, description, options)


def calculated(si_unit: str, description: str, **options) -> Variable:
    """A calculated parameter: an output of the equations, in an SI unit, that depends on the parameters alone.

    options and errors as of `parameter`: Raises InputError for a unit that is unknown or not in SI.

        >>> mf.calculated("kg.m2", "Inertia that moves with the handlebar", symbol="I_p").role
        'calculated'
    """
    return _row("calculated", si_unit, description, options)


def input(si_unit: str, description: str, **options) -> Variable:
    r"""An input of the component, in an SI unit.

    options as of `parameter`. Raises InputError for a unit that is unknown or not in SI.

        >>> mf.input("rad", "Steer angle", symbol=r"\delta").unit
        'rad'
    """
    return _row("input", si_unit, description, options)


def output(si_unit: str, description: str, **options) -> Variable:
    """An output of the component, in an SI unit, which its equations return by name.

    options as of `parameter`. Raises InputError for a unit that is unknown or not in SI.

        >>> mf.output("N.m", "Torque on the handlebar", symbol="T_h").unit
        'N.m'
    """
    return _row("output", si_unit, description, options)


def state(si_unit: str, description: str, **options) -> Variable:
    """A continuous state, in an SI unit; the equations return its `der(name)`.

    options as of `parameter`; `exposed=True` makes it an output as well. Raises InputError for a unit that is unknown
    or not in SI.

        >>> mf.state("rad", "Angle of the torso", exposed=True).exposed
        True
    """
    return _row("state", si_unit, description, options)


def local(si_unit: str, description: str, **options) -> Variable:
    """An intermediate quantity, in an SI unit, that the equations set (`v.arm_torque = ...`); effects may add to it.

    options as of `parameter`. Raises InputError for a unit that is unknown or not in SI.

        >>> mf.local("N.m", "Torque of the arms", symbol="T_a").role
        'local'
    """
    return _row("local", si_unit, description, options)
