"""The laws of mechanics at the elements of any component: which of them can act there, each as an effect of its own.

A law of a spring acts at the element `spring`, one of large rotation at `rotation`; friction and drag wherever
something moves; that of an actuator at an input, that of a sensor at an output. At another element than its own a law's
form says where it acts: `coulomb_drive`, `clip_torque`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from fmus.component import Component
from fmus.effects import actuator, change, channel, damping, memory, resonance, sensor, stiffness
from fmus.effects.effect import Effect
from fmus.effects.library import declared_by
from fmus.mathematics import NUMERIC
from fmus.variables import Variable

LAWS = [law for module in (damping, stiffness, memory, change, resonance) for law in declared_by(module)]
EVERYWHERE = declared_by(damping)


def laws_at(component: Component, largest_rate: float = 1.0, told: Mapping[str, float] | None = None,
            shown: Mapping[str, float] | None = None) -> list[type[Effect]]:  # fmt: skip
    """The effects that the laws make at the component's elements, shapes in rates as shares of the largest rate.

    told and shown are the inputs that actuators give and the outputs that sensors show, with their largest values;
    without them actuators give every input, and there are no sensors.
    """
    found: list[type[Effect]] = []
    for law in LAWS:
        known = {law.element: law.form} if law.element in component.elements else {}
        if law in EVERYWHERE:
            forces = {element.force for name, element in component.elements.items() if name in known}
            for name, element in component.elements.items():
                if element.force not in forces:
                    forces.add(element.force)
                    known[name] = f"{law.form}_{name}"
        found += [_placed(law, name, form, largest_rate, 1.0) for name, form in known.items()]
    levels = dict.fromkeys(component.inputs, 1.0) if told is None else told
    found += [_placed(law, name, f"{law.form}_{name}", largest_rate, level) for name, level in levels.items() for law in declared_by(actuator)]
    found += [_at_sensor(law, component, name, level) for name, level in (shown or {}).items() for law in declared_by(sensor)]
    return [effect for effect in found if _can_act(component, effect)] + [channel.ChannelDelay]


def _placed(law: type[Effect], element: str, form: str, largest_rate: float, level: float, **rows: Variable) -> type[Effect]:
    scale = dict.fromkeys(law.relative_to_rate, largest_rate) | dict.fromkeys(law.relative_to_level, level)
    starts = {n: tuple(s * scale.get(n, 1.0) for s in values) for n, values in law.starts.items()}
    return type(law.__name__, (law,), {"__doc__": law.__doc__, "__module__": law.__module__, "element": element, "form": form, "starts": starts, **rows})


def _at_sensor(law: type[Effect], component: Component, output: str, level: float) -> type[Effect]:
    reference = replace(law.declared["reference"], unit=component.table[output].unit, start=level)
    return _placed(law, output, f"{law.form}_{output}", 1.0, level, reference=reference)


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
