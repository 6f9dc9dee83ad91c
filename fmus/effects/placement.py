"""Placement of the laws of mechanics at the elements, inputs and outputs of any component, one effect for each place.

A spring law acts at the element `spring`, a law of large rotation at `rotation`, friction and drag at every element, an
actuator law at inputs and a sensor law at outputs. The family names the law and `element` the place; at another element
than the law's own the form has the place as suffix: `coulomb_drive`, `clip_torque`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from fmus.declaration.component import Component
from fmus.declaration.variables import Variable
from fmus.effects import actuator, damping, drift, hysteresis, resonance, sensor, stiffness
from fmus.effects.effect import Effect
from fmus.effects.library import declared_by
from fmus.effects.measuring_channel import ChannelDelay
from fmus.expressions.functions import NUMERIC

LAWS = [law for module in (damping, stiffness, hysteresis, drift, resonance) for law in declared_by(module)]
EVERYWHERE = declared_by(damping)


def laws_at(component: Component, largest_rate: float = 1.0, inputs: Mapping[str, float] | None = None,
            outputs: Mapping[str, float] | None = None) -> list[type[Effect]]:  # fmt: skip
    """The effects that can act on a component, with starting values scaled to the motion.

    largest_rate is the largest rate of the elements; inputs and outputs are those with an actuator or a sensor, with
    their largest values. By default every input has an actuator, of the largest value 1, and no output has a sensor.
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
    levels = dict.fromkeys(component.inputs, 1.0) if inputs is None else inputs
    found += [
        _placed(law, name, f"{law.form}_{name}", largest_rate, level)
        for name, level in levels.items()
        for law in declared_by(actuator)
    ]
    found += [
        _at_sensor(law, component, name, level)
        for name, level in (outputs or {}).items()
        for law in declared_by(sensor)
    ]
    return [effect for effect in found if _can_act(component, effect)] + [ChannelDelay]


def _placed(
    law: type[Effect], element: str, form: str, largest_rate: float, level: float, **rows: Variable
) -> type[Effect]:
    scale = dict.fromkeys(law.relative_to_rate, largest_rate) | dict.fromkeys(law.relative_to_level, level)
    starts = {n: tuple(s * scale.get(n, 1.0) for s in values) for n, values in law.starts.items()}
    return type(
        law.__name__,
        (law,),
        {
            "__doc__": law.__doc__,
            "__module__": law.__module__,
            "element": element,
            "form": form,
            "starts": starts,
            **rows,
        },
    )


def _at_sensor(law: type[Effect], component: Component, output: str, level: float) -> type[Effect]:
    reference = replace(law.declared["reference"], unit=component.table[output].unit, start=level)
    return _placed(law, output, f"{law.form}_{output}", 1.0, level, reference=reference)


def _can_act(component: Component, effect: type[Effect]) -> bool:
    """Whether the element has the stiffness or damping that the law reads."""
    try:
        joined = component.with_effects(effect())
        joined.run(joined.start_values(), NUMERIC)
    except AttributeError:
        return False
    return True


def by_name(effects: Sequence[type[Effect]]) -> dict[str, type[Effect]]:
    """The effects by `family.form`, as value files name them."""
    return {f"{e.family}.{e.form}": e for e in effects}
