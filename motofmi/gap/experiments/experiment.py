"""The imposed-motion experiment: the base component, its free parameters with their priors, and how effects are added.

The parameters of a rider change from run to run: in each run they may deviate by `spread` (relative)
from the common value.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from fmus.composition.imposed_motion import ImposedMotion, ImposedThroughSpring
from fmus.composition.system import System
from fmus.declaration.component import Component
from fmus.effects import Effect

SERIES = "shaft_compliance"


@dataclass(frozen=True)
class FreeParameter:
    """A fitted parameter of the base: its relative deviation from run to run, and its prior (value
    and standard error)."""

    name: str
    spread: float = 0.0
    known: float | None = None
    standard_error: float = 0.0


@dataclass(frozen=True)
class Sensor:
    """An output of the component that a column may measure, and the standard deviation of its white
    noise in planned runs."""

    output: str
    noise: float


def with_imposed_state(
    component: Component, state: str, effort: str, effects: Sequence[type[Effect]], also: Sequence[str] = ()
) -> Component:
    """The component with a state imposed and its effort (and further outputs) as outputs, with effects of
    device and channel."""
    joined = [e(exact_delays=True) for e in effects if e.part == "device"]
    if joined and isinstance(component, System):
        parts = {n: p.with_effects(*joined) if n == "device" else p for n, p in component.parts.items()}
        component = System(component.name, parts, component.wiring, component.bindings, component.source)
    elif joined:
        component = component.with_effects(*joined)
    channel = tuple(e() for e in effects if e.part == "channel" and e.family != SERIES)
    wrapper = ImposedThroughSpring if any(e.family == SERIES for e in effects) else ImposedMotion
    return wrapper(component, state, effort, channel, tuple(also))


def parameter_of(component: Component, effect: type[Effect], name: str) -> str:
    """The name of an effect's parameter in a component, or in a system whose device has the effect."""
    prefix = "device." if effect.part == "device" and isinstance(component, System) else ""
    return f"{prefix}{effect.family}.{name}"


@dataclass(frozen=True, repr=False)
class ImposedMotionExperiment:
    """A component with one state imposed and its effort measured.

    columns maps the roles `imposed`, `measured` and `command` to columns of the recordings; further holds, by
    column, sensors that not every run has. measured_effects holds values and standard errors of effects that
    another experiment measured.
    """

    component: Component
    imposed: str
    measured: str
    free: tuple[FreeParameter, ...]
    columns: Mapping[str, str]
    measured_effects: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    further: Mapping[str, Sensor] = field(default_factory=dict)

    def __repr__(self) -> str:
        free = ", ".join(p.name for p in self.free) or "none"
        return (
            f"ImposedMotionExperiment({self.component.name!r}, imposed {self.imposed}, measured {self.measured}, "
            f"free {free})"
        )


    def with_effects(self, effects: Sequence[type[Effect]]) -> Component:
        """The component with effects, its motion as input and its effort as output."""
        return with_imposed_state(
            self.component,
            self.imposed,
            self.measured,
            effects,
            tuple(sensor.output for sensor in self.further.values()),
        )

    @property
    def unrestricted(self) -> tuple[str, ...]:
        """The parameters besides the free ones that are fitted without a fixed sign: none."""
        return ()

    @property
    def outputs(self) -> tuple[str, ...]:
        """The measured outputs."""
        return (self.measured,)

    @property
    def device(self) -> Component:
        """The component in which effects of the part `device` act."""
        return self.component.parts["device"] if isinstance(self.component, System) else self.component

    def parameter(self, effect: type[Effect], name: str) -> str:
        """The name of an effect's parameter in the component under test."""
        return parameter_of(self.component, effect, name)
