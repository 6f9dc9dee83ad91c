"""The vehicle-over-speed experiment: a component linearised over one of its inputs, and its free parameters.

    x' = A(V, p) x + B(V, p) u

Effects are added to one part of a system, or to the component itself.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from fmus.composition.system import System
from fmus.declaration.component import Component
from fmus.effects import Effect
from motofmi.gap.experiments.experiment import FreeParameter


@dataclass(frozen=True, repr=False)
class VehicleOverSpeedExperiment:
    """A component, the part of it to which effects are added ("" for itself), the input over which it is linearised.

    free are the fitted parameters that keep their sign, unrestricted those that may change it, measured_effects the
    priors of the latter (value and standard error). exact_delays makes delayed signals inputs, for recorded runs.
    """

    component: Component
    part: str
    over: str
    free: tuple[FreeParameter, ...] = ()
    unrestricted: tuple[str, ...] = ()
    measured_effects: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    exact_delays: bool = False

    def __repr__(self) -> str:
        free = ", ".join([*(p.name for p in self.free), *self.unrestricted]) or "none"
        return f"VehicleOverSpeedExperiment({self.component.name!r}, over {self.over}, free {free})"


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
