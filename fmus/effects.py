"""An effect: a physical phenomenon that adds to named quantities of a component, with its own variables.

    class HardeningStiffness(Effect):
        cubic_stiffness = parameter("N.m/rad3", "Stiffness that grows with the square of the deflection", min=0)

        @adds_to("arm_torque")
        def cubic(self, v, m):
            return v.cubic_stiffness * v.arm_deflection**3

A target is a local variable, an input as the component sees it, an output, `der(state)` (before the mass
matrix) or `mass(row, column)`. What is added may read everything that the equations have set by then.
"""

from collections.abc import Callable
from typing import Any, ClassVar

from fmus.component import Component
from fmus.errors import InputError
from fmus.variables import Variable


def adds_to(target: str) -> Callable[[Callable], Callable]:
    """Marks a method of an effect as the addition to a target."""

    def mark(method: Callable) -> Callable:
        method.target = target  # type: ignore[attr-defined]
        return method

    return mark


class Effect:
    """Base of the effects. Its variables join the table of the component that it is added to."""

    declared: ClassVar[dict[str, Variable]] = {}

    def __init_subclass__(cls, **options) -> None:
        super().__init_subclass__(**options)
        rows = dict(cls.declared)
        rows.update({n: row.named(n) for n, row in vars(cls).items() if isinstance(row, Variable)})
        cls.declared = rows

    @property
    def structure(self) -> Any:
        return type(self)

    def join(self, component: Component) -> None:
        """Put this effect's variables and additions into the component. Raises InputError on a clash."""
        clash = component.table.keys() & self.declared.keys()
        if clash:
            raise InputError(f"effect {type(self).__name__} and {component.title} both declare {', '.join(sorted(clash))}")
        component.table.update(self.declared)
        for name in dir(type(self)):
            target = getattr(getattr(type(self), name), "target", None)
            if target is not None:
                component.additions.setdefault(target, []).append(getattr(self, name))
