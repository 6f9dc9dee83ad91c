"""Placement of laws at the elements, states, inputs and outputs of any component, one effect for each place.

A spring law acts at the element `spring`, a law of large rotation at `rotation`, friction and drag at every element, an
actuator law at inputs and a sensor law at outputs. The family names the law and `element` the place; at another element
than the law's own the form has the place as suffix: `coulomb_drive`, `clip_torque`, `lost_level`. Friction and drag may
also act at several elements at once: `coulomb_shoulder_and_elbow`.

States that belong to no force element have the laws of `state_rate`. A component without a force may be a mechanism
that a motion drives, or no mechanism: its inputs and outputs have the laws of `input_channel` and `output_channel` as well.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations, permutations
from math import inf

from fmus.declaration.component import Component
from fmus.declaration.elements import Element
from fmus.declaration.units import is_force
from fmus.declaration.variables import Variable
from fmus.effects import (
    actuator,
    damping,
    drift,
    hysteresis,
    input_channel,
    output_channel,
    resonance,
    sensor,
    state_rate,
    stiffness,
)
from fmus.effects.effect import Effect
from fmus.effects.late_channel import LateChannel
from fmus.effects.library import declared_by
from fmus.effects.measuring_channel import ChannelDelay
from fmus.effects.several_elements import at_several_elements
from fmus.equations.sympy_form import symbolic
from fmus.expressions.functions import NUMERIC

LAWS = [law for module in (damping, stiffness, hysteresis, drift, resonance) for law in declared_by(module)]
EVERYWHERE = declared_by(damping)
# Lowest frequency [Hz] of a motion to which starting values of frequencies and times are scaled. With lower starting
# values a slow further body takes the place of friction, and of other errors that grow over long times.
LEAST_FREQUENCY = 2.0
BEYOND = 10.0  # ratio of the upper bound of a frequency to its largest starting value
MOST_DELAY = 0.25  # as a share of the motion's period

Range = tuple[float, float]


def laws_at(component: Component, largest_rate: float = 1.0, inputs: Mapping[str, float] | None = None,
            outputs: Mapping[str, float] | None = None, states: Mapping[str, Range] | None = None,
            period: float = inf, largest: float = 1.0) -> list[type[Effect]]:  # fmt: skip
    """The effects that can act on a component, with starting values and bounds scaled to the motion.

    largest and largest_rate are the largest deflection and rate of the elements; inputs and outputs are those with an
    actuator or a sensor, with their largest values; states are those that may have further rates, with their ranges;
    period is that of the motion [s]. By default every input has an actuator, of the largest value 1, no output has a
    sensor, and the threshold of a state, a delay and the time constant of a lag have no bounds.
    """
    levels = dict.fromkeys(component.inputs, 1.0) if inputs is None else dict(inputs)
    readings = dict(outputs or {})
    # Without a force the component may be a mechanism that a motion drives, or no mechanism.
    other = not any(is_force(component.table[e.force].unit) for e in component.elements.values())
    at_inputs = [*declared_by(actuator), *(declared_by(input_channel) if other else [])]
    at_outputs = [*declared_by(sensor), *(declared_by(output_channel) if other else [])]
    found = _at_elements(component, largest, largest_rate, period)
    found += [_at_signal(law, component, n, level, period) for n, level in levels.items() for law in at_inputs]
    found += [_at_signal(law, component, n, level, period) for n, level in readings.items() for law in at_outputs]
    found += _at_states(component, states)
    # Where a motion is imposed, a spring whose deflection is recorded late has the force of a spring and a damper.
    late = delay_in_motion(period, LateChannel if levels else ChannelDelay)
    return [*(effect for effect in found if _can_act(component, effect)), late]


def _at_elements(component: Component, largest: float, largest_rate: float, period: float) -> list[type[Effect]]:
    found: list[type[Effect]] = []
    for law in LAWS:
        known = {law.element: law.form} if law.element in component.elements else {}
        if law in EVERYWHERE:
            forces = {element.force for name, element in component.elements.items() if name in known}
            for name, element in component.elements.items():
                if element.force not in forces:
                    forces.add(element.force)
                    known[name] = f"{law.form}_{name}"
        frequency, rates = max(1 / period, LEAST_FREQUENCY), dict.fromkeys(law.relative_to_rate, largest_rate)
        times = dict.fromkeys(law.times, LEAST_FREQUENCY / frequency)
        starts = _scaled(law, rates | times | dict.fromkeys(law.relative_to_frequency, frequency))
        spans = rates | dict.fromkeys(law.relative, largest) | dict.fromkeys(law.times if period < inf else (), period)
        rows = {n: _widened(law.declared[n], by) for n, by in spans.items()} | _with_bounds_beyond(law, starts)
        places = {n: form for n, form in known.items() if _suits(law, component.elements[n])}
        at_one = [_placed(law, name, form, starts, **rows) for name, form in places.items()]
        found += at_one
        if law in EVERYWHERE and len(law.magnitudes()) == 1 and not (law.both_ways or law.has_states()):
            together = dict.fromkeys((*combinations(at_one, 2), tuple(at_one)))  # every two, and all
            found += [at_several_elements(law, some) for some in together if _move_apart(some, component)]
    return found


def _move_apart(at_one: Sequence[type[Effect]], component: Component) -> bool:
    """Whether these are several elements whose rates differ and whose forces have one unit."""
    elements = [component.elements[effect.element] for effect in at_one]
    units = {component.table[e.force].unit for e in elements}
    return len(elements) > 1 and len(units) == 1 and len({e.rate for e in elements}) == len(elements)


def _suits(law: type[Effect], element: Element) -> bool:
    """Whether a law can act at an element. A law whose starting values are shares of the largest deflection, as the
    width of a hysteresis, needs a deflection; `Effect.of_stiffness` says which elements it suits."""
    suits = law.of_stiffness is None or law.of_stiffness == bool(element.stiffness)
    return suits and bool(element.deflection or not law.relative)


def _at_signal(law: type[Effect], component: Component, name: str, level: float, period: float) -> type[Effect]:
    """A law at an input or an output whose largest value is `level`.

    A time constant is at most a period: a slower lag integrates, and the data determine the ratio of its share to its
    time constant alone.
    """
    scale = dict.fromkeys(law.relative_to_level, level)
    scale |= dict.fromkeys(law.relative_to_period if period < inf else (), period)
    times = {n: replace(row, max=period, start=min(row.start, period))
             for n, row in law.declared.items() if n in law.relative_to_period}  # fmt: skip
    return _placed(law, name, f"{law.form}_{name}", _scaled(law, scale),
                   **_rows(law, component.table[name].unit, level), **times)


def _at_states(component: Component, ranges: Mapping[str, Range] | None) -> list[type[Effect]]:
    """The laws of states that belong to no element and are no rate of another state, at each of them."""
    found: list[type[Effect]] = []
    states = [n for n in states_of_no_element(component) if ranges is None or n in ranges]
    for law in declared_by(state_rate):
        pairs = permutations(states, 2) if issubclass(law, state_rate.Transfer) else [(n, "") for n in states]
        for state, to in pairs:
            unit = component.table[state].unit
            if to and component.table[to].unit != unit:
                continue
            low, high = (0.0, 1.0) if ranges is None else ranges[state]
            rows = _rows(law, unit, max(abs(low), abs(high)))
            bounds = {} if ranges is None else {n: replace(rows[n], min=low, max=high, start=high)
                                                for n in law.within_range}
            starts = {n: tuple(low + s * (high - low) if n in law.within_range else s for s in values)
                      for n, values in law.starts.items()}  # fmt: skip
            place = f"{state}_to_{to}" if to else state
            found.append(_placed(law, place, f"{law.form}_{place}", starts, **rows | bounds))
    return found


def states_of_no_element(component: Component) -> list[str]:
    """The states that no force element has as deflection or rate, whose derivative is no state, and that the mass
    matrix does not couple."""
    form = symbolic(component)
    of_elements = {n for e in component.elements.values() for n in (e.deflection, e.rate)}
    return [
        n
        for i, (n, rate) in enumerate(zip(component.states, form.rates, strict=True))
        if n not in of_elements and str(rate) not in component.states and i not in form.coupled
    ]


def _rows(law: type[Effect], unit: str, level: float) -> dict[str, Variable]:
    """The variables of a law that depend on the signal at which it acts: its unit, and its largest value as
    reference or in a bound."""
    rows = {n: replace(law.declared[n], unit=unit) for n in law.in_its_unit}
    rows |= {n: replace(rows[n], min=share * level, start=max(rows[n].start, share * level))
             for n, share in law.at_least_of_level.items()}  # fmt: skip
    return rows | ({"reference": replace(rows["reference"], start=level)} if "reference" in rows else {})


def _scaled(law: type[Effect], scale: Mapping[str, float]) -> dict[str, tuple[float, ...]]:
    return {n: tuple(s * scale.get(n, 1.0) for s in values) for n, values in law.starts.items()}


def _widened(row: Variable, scale: float) -> Variable:
    """A variable whose bounds include the declared ones multiplied by a scale."""
    return replace(row, min=min(row.min, row.min * scale), max=max(row.max, row.max * scale))


def _with_bounds_beyond(law: type[Effect], starts: Mapping[str, tuple[float, ...]]) -> dict[str, Variable]:
    """The frequencies of a law, with upper bounds beyond its starting values."""
    return {n: replace(law.declared[n], max=max(law.declared[n].max, BEYOND * starts[n][-1]))
            for n in law.relative_to_frequency}  # fmt: skip


def _placed(law: type[Effect], element: str, form: str, starts: Mapping[str, tuple[float, ...]],
            **rows: Variable) -> type[Effect]:  # fmt: skip
    own = {"__doc__": law.__doc__, "__module__": law.__module__, "element": element, "form": form, "starts": starts}
    return type(law.__name__, (law,), {**own, **rows})


def delay_in_motion(period: float, law: type[ChannelDelay] = LateChannel) -> type[Effect]:
    """A delay of at most `MOST_DELAY` of the motion's period [s], or as its law has it where that is more."""
    row = law.declared["delay"]
    most = max(row.max, MOST_DELAY * period)
    return _placed(law, law.element, law.form, law.starts, delay=replace(row, min=-most if row.min < 0 else 0, max=most))


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
