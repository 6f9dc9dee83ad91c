"""Springs of a component whose deflection is not recorded and only grows, as in a coast-down.

    T = k (x - x_0),   x_0 unknown,   x' > 0

With a small stiffness k and a distant x_0 the torque is constant: that of dry friction. In such a run a spring takes
the place of any law of friction, and its stiffness is not identifiable. A rate that rises and falls without an input is
that of a spring, as of a door closer.
"""

from collections.abc import Sequence
from dataclasses import replace

from motofmi.gap.experiments.input_output import InputOutputExperiment
from motofmi.gap.preprocessing.one_way import oscillates
from motofmi.gap.preprocessing.sampled_run import SampledRun, excited

NO_SPRING = (
    "{} is not recorded, and its rate has one sign: {} is taken as zero, since the force of a spring may there be that "
    "of dry friction. Where the component has a spring, record {} or give a run with reversals; --free {} fits it."
)


def without_unseen_springs(
    experiment: InputOutputExperiment, runs: Sequence[SampledRun]
) -> tuple[InputOutputExperiment, list[str]]:
    """The experiment without the free stiffnesses that no run can distinguish from friction, and a sentence on each."""
    component, sentences, driven = experiment.component, list[str](), excited(runs)
    free, zero = {f.name for f in experiment.free}, dict[str, float]()
    for element in component.elements.values():
        name, rate = element.stiffness, element.rate
        seen = any(
            element.deflection in run.recording.columns
            or rate not in run.one_way_rates
            or (not driven and any(map(oscillates, run.recording.parts(rate))))
            for run in runs
        )
        if name in free - set(zero) and component.table[name].min <= 0 and not seen:
            zero[name] = 0.0
            sentences.append(NO_SPRING.format(element.deflection, name, element.deflection, name))
    left = tuple(f for f in experiment.free if f.name not in zero)
    return replace(experiment, component=component.with_values(**zero), free=left), sentences
