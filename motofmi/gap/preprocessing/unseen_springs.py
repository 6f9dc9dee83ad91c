"""Springs of a component that no run can distinguish from friction, as in a coast-down.

    T = k (x - x_0),   x_0 unknown,   x' > 0

With a small stiffness k and a distant x_0 the torque is constant: that of dry friction. Where the deflection is not
recorded and only grows, a spring takes the place of any law of friction, and its stiffness is not identifiable. A rate
that rises and falls without an input is that of a spring, as of a door closer. What turns on by revolutions has no
spring, whether the angle is recorded or not.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fmus.declaration.elements import Element
from motofmi.gap.experiments.input_output import InputOutputExperiment
from motofmi.gap.preprocessing.one_way import keeps_direction, oscillates
from motofmi.gap.preprocessing.sampled_run import SampledRun, excited

NO_SPRING = (
    "{} is not recorded, and its rate has one sign: {} is taken as zero, since the force of a spring may there be that "
    "of dry friction. Where the component has a spring, record {} or give a run with reversals; --free {} fits it."
)
TURNS_ON = "{} turns on by more than a revolution: {} is taken as zero; --free {} fits it."


def without_unseen_springs(
    experiment: InputOutputExperiment, runs: Sequence[SampledRun]
) -> tuple[InputOutputExperiment, list[str]]:
    """The experiment without the free stiffnesses that no run can distinguish from friction, and a sentence on each."""
    component, sentences = experiment.component, list[str]()
    free, zero = {f.name for f in experiment.free}, dict[str, float]()
    for element in component.elements.values():
        name, deflection = element.stiffness, element.deflection
        if name not in free - set(zero) or component.table[name].min != 0:  # of gravity it may be negative
            continue
        if component.table[deflection].unit == "rad" and all(_turns_on(element, run) for run in runs):
            zero[name] = 0.0
            sentences.append(TURNS_ON.format(deflection, name, name))
        elif all(_only_grows(element, run, excited(runs)) for run in runs):
            zero[name] = 0.0
            sentences.append(NO_SPRING.format(deflection, name, deflection, name))
    left = tuple(f for f in experiment.free if f.name not in zero)
    return replace(experiment, component=component.with_values(**zero), free=left), sentences


def _only_grows(element: Element, run: SampledRun, driven: bool) -> bool:
    """Whether a deflection is not recorded, its rate has one sign, and no spring drives it."""
    recorded = element.deflection in run.recording.columns
    if recorded or element.rate not in run.one_way_rates:
        return False
    return driven or not any(map(oscillates, run.recording.parts(element.rate)))


def _turns_on(element: Element, run: SampledRun) -> bool:
    """Whether an angle is recorded that exceeds a revolution and keeps its direction."""
    if element.deflection not in run.recording.columns:
        return False
    parts = run.recording.parts(element.deflection)
    return all(map(keeps_direction, parts)) and max(map(np.ptp, parts)) > 2 * np.pi
