"""A component that is seen through its linearisation over an input (a vehicle over its speed), and what is free in it.

    x' = A(V, p) x + B(V, p) u

Effects join one part of a system, or the component itself.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from fmus.component import Component
from fmus.effects import Effect
from fmus.system import System
from identification.gap.stands.test_stand import Free


@dataclass(frozen=True)
class LinearStand:
    """A component, the part of it that effects join ("" for itself), the input over which it is seen, its free parameters.

    free are those that keep their sign, open those that may be any number, with measured_effects for what is known of
    these (value and error). exact_delays makes of what lags an input, for recorded runs.
    """

    component: Component
    part: str
    over: str
    free: tuple[Free, ...] = ()
    open: tuple[str, ...] = ()
    measured_effects: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    exact_delays: bool = False

    def with_effects(self, effects: Sequence[type[Effect]]) -> Component:
        """The component with effects."""
        inner = self.component
        joined = [e(exact_delays=self.exact_delays) for e in effects]
        if not joined:
            return inner
        if not isinstance(inner, System):
            return inner.with_effects(*joined)
        parts = {n: p.with_effects(*joined) if n == self.part else p for n, p in inner.parts.items()}
        return System(inner.name, parts, inner.wiring, inner.bindings, inner.source)

    def parameter(self, effect: type[Effect], name: str) -> str:
        """The name of an effect's parameter in the component."""
        return f"{self.part}.{effect.family}.{name}" if self.part else f"{effect.family}.{name}"
