"""The laws of mechanics at the elements of any component: which of them can act there, each as an effect of its own.

A law of a spring acts at the element `spring`, one of large rotation at `rotation`; friction and drag wherever
something moves. At another element than its own a law's form says where it acts: `coulomb_drive`.
"""

from collections.abc import Sequence

from fmus.component import Component
from fmus.effects import change, channel, damping, memory, resonance, stiffness
from fmus.effects.effect import Effect
from fmus.effects.library import declared_by
from fmus.mathematics import NUMERIC

LAWS = [law for module in (damping, stiffness, memory, change, resonance) for law in declared_by(module)]
EVERYWHERE = declared_by(damping)


def laws_at(component: Component, largest_rate: float = 1.0) -> list[type[Effect]]:
    """The effects that the laws make at the component's elements, shapes in rates as shares of the largest rate."""
    found: list[type[Effect]] = []
    for law in LAWS:
        known = {law.element: law.form} if law.element in component.elements else {}
        if law in EVERYWHERE:
            forces = {element.force for name, element in component.elements.items() if name in known}
            for name, element in component.elements.items():
                if element.force not in forces:
                    forces.add(element.force)
                    known[name] = f"{law.form}_{name}"
        found += [_placed(law, name, form, largest_rate) for name, form in known.items()]
    return [effect for effect in found if _can_act(component, effect)] + [channel.ChannelDelay]


def _placed(law: type[Effect], element: str, form: str, largest_rate: float) -> type[Effect]:
    starts = {n: tuple(s * largest_rate for s in values) if n in law.relative_to_rate else values for n, values in law.starts.items()}
    return type(law.__name__, (law,), {"__doc__": law.__doc__, "__module__": law.__module__, "element": element, "form": form, "starts": starts})


def _can_act(component: Component, effect: type[Effect]) -> bool:
    """Whether the element has what the law reads: a stiffness, a damping."""
    try:
        joined = component.with_effects(effect())
        joined.run(joined.start_values(), NUMERIC)
    except AttributeError:
        return False
    return True


def by_name(effects: Sequence[type[Effect]]) -> dict[str, type[Effect]]:
    """The effects by `family.form`, as value files name them."""
    return {f"{e.family}.{e.form}": e for e in effects}
