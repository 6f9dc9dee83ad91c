"""What is tested, and how: the base component, its free parameters with what is known of them, and how effects join.

A parameter of a rider is never twice the same: each run may deviate by `spread` (relative) from the common value.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from fmus.component import Component
from fmus.effects import Effect
from fmus.imposed import Imposed, ThroughSpring
from fmus.system import System

SERIES = "shaft_compliance"


@dataclass(frozen=True)
class Free:
    """A parameter of the base that is fitted: by what it may change from run to run, and what is known of it."""

    name: str
    spread: float = 0.0
    known: float | None = None
    standard_error: float = 0.0


@dataclass(frozen=True)
class Sensor:
    """An output of the component that a column may show, and the deviation of its white noise in runs that are planned."""

    output: str
    noise: float


def imposed_on(component: Component, state: str, effort: str, effects: Sequence[type[Effect]], also: Sequence[str] = ()) -> Component:
    """A component whose state is imposed, its effort and other outputs answered, with effects: of the device, and of what lies between."""
    joined = [e(exact_delays=True) for e in effects if e.part == "device"]
    if joined and isinstance(component, System):
        parts = {n: p.with_effects(*joined) if n == "device" else p for n, p in component.parts.items()}
        component = System(component.name, parts, component.wiring, component.bindings, component.source)
    elif joined:
        component = component.with_effects(*joined)
    channel = tuple(e() for e in effects if e.part == "channel" and e.family != SERIES)
    wrapper = ThroughSpring if any(e.family == SERIES for e in effects) else Imposed
    return wrapper(component, state, effort, channel, tuple(also))


def parameter_of(component: Component, effect: type[Effect], name: str) -> str:
    """The name that an effect's parameter has in a component, or in a system that the effect joins at its device."""
    prefix = "device." if effect.part == "device" and isinstance(component, System) else ""
    return f"{prefix}{effect.family}.{name}"


@dataclass(frozen=True)
class TestStand:
    """A component, imposed at one of its states, with its measured effort.

    parts maps the part of an effect (`device`) to that of the system; "" is the component itself.
    columns maps the roles imposed, measured and command to columns of the recordings; further are sensors by column that
    not every run has.
    """

    __test__ = False  # not a test of pytest's

    component: Component
    imposed: str
    measured: str
    free: tuple[Free, ...]
    columns: Mapping[str, str]
    measured_effects: Mapping[str, tuple[float, float]] = field(default_factory=dict)  # size and its error, from another test
    further: Mapping[str, Sensor] = field(default_factory=dict)

    def with_effects(self, effects: Sequence[type[Effect]]) -> Component:
        """The component seen from the test: its motion told, its effort answered, with effects."""
        return imposed_on(self.component, self.imposed, self.measured, effects, tuple(sensor.output for sensor in self.further.values()))

    @property
    def open(self) -> tuple[str, ...]:
        """The parameters that are fitted as they are, beside the free ones: none."""
        return ()

    @property
    def outputs(self) -> tuple[str, ...]:
        """The outputs of the component seen from the test that are measured."""
        return (self.measured,)

    @property
    def device(self) -> Component:
        """The component in which effects of the part `device` act."""
        return self.component.parts["device"] if isinstance(self.component, System) else self.component

    def parameter(self, effect: type[Effect], name: str) -> str:
        """The name of an effect's parameter in the component under test."""
        return parameter_of(self.component, effect, name)
