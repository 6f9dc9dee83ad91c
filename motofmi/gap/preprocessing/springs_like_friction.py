"""Springs of a component that no run can distinguish from friction, as in a coast-down.

    T = k (x - x_0),   x_0 unknown,   x' > 0

With a small stiffness k and a distant x_0 the torque is constant: that of dry friction. Where the deflection is not
recorded and only grows, a spring takes the place of any law of friction, and its stiffness is not identifiable. A rate
that rises and falls without an input is that of a spring, as of a door closer. A body that rotates by more than a
revolution in one direction has no spring, also where its angle is recorded; a rate that rises and falls in the same
way in every revolution is that of a pendulum: its synchronous average is not constant.

Source: McFadden, Mechanical Systems and Signal Processing 1 (1987) 83-95, on the synchronous average.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.special import fdtrc

from fmus.declaration.elements import Element
from motofmi.gap.experiments.input_output import InputOutputExperiment
from motofmi.gap.preprocessing.one_way import direction_of, keeps_direction, largest_return, oscillates
from motofmi.gap.preprocessing.sampled_run import SampledRun, excited

NO_SPRING = (
    "{} is not recorded, and its rate has one sign: {} is taken as zero, since the force of a spring may there be that "
    "of dry friction. Where the component has a spring, record {} or give a run with reversals; --free {} fits it."
)
EIGHTHS = 8  # parts of a revolution, over which the rate of an angle is taken
EIGHTH = 2 * np.pi / EIGHTHS  # rad
RISE = 0.1  # return of that rate over its range from which on it is that of a pendulum and no error of the sensor
LEVEL = 0.001  # significance of a rate that rises and falls with the revolutions
FEWEST_REVOLUTIONS = 4  # in which that is tested
ROTATES = "{} increases or decreases by more than a revolution: {} is taken as zero; --free {} fits it."


def without_springs_like_friction(
    experiment: InputOutputExperiment, runs: Sequence[SampledRun]
) -> tuple[InputOutputExperiment, list[str]]:
    """The experiment without the free stiffnesses that no run can distinguish from friction, and a sentence on each."""
    component, sentences = experiment.component, list[str]()
    free, zero = {f.name for f in experiment.free}, dict[str, float]()
    for element in component.elements.values():
        name, deflection = element.stiffness, element.deflection
        if name not in free - set(zero) or component.table[name].min > 0:
            continue
        if all(rotates(element, run) for run in runs):
            zero[name] = 0.0
            sentences.append(ROTATES.format(deflection, name, name))
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


def rotates(element: Element, run: SampledRun) -> bool:
    """Whether an angle is recorded that exceeds a revolution and keeps its direction, while its rate does not rise and
    fall with the revolutions."""
    if element.deflection not in run.recording.columns or run.recording.units[element.deflection] != "rad":
        return False
    parts = run.recording.parts(element.deflection)
    return all(map(keeps_direction, parts)) and all(map(_rotates_freely, parts))


def _rotates_freely(angle: np.ndarray) -> bool:
    """Whether an angle (n,) that keeps its direction exceeds a revolution, and its rate over eighths of a revolution
    does not rise and fall, or does so otherwise in every revolution, as that of a driven body."""
    way = np.maximum.accumulate(direction_of(angle) * angle)
    marks = np.arange(way[0], way[-1], EIGHTH)
    if len(marks) <= EIGHTHS + 1:
        return False
    rate = 1 / np.diff(np.interp(marks, way, np.arange(len(way))))
    return largest_return(rate) < RISE or not _repeats(rate)


def _repeats(rate: np.ndarray) -> bool:
    """Whether a rate (n,) over eighths of a revolution, about its mean over one revolution, differs with the eighth, by
    an analysis of variance; as for fewer than `FEWEST_REVOLUTIONS`."""
    within = rate[EIGHTHS // 2 : len(rate) - EIGHTHS // 2 + 1] - np.convolve(rate, np.full(EIGHTHS, 1 / EIGHTHS), "valid")
    revolutions = len(within) // EIGHTHS
    if revolutions < FEWEST_REVOLUTIONS:
        return True
    by_eighth = within[: revolutions * EIGHTHS].reshape(revolutions, EIGHTHS)
    between, freedom = revolutions * by_eighth.mean(axis=0).var(ddof=1), EIGHTHS * (revolutions - 1)
    within_eighths = by_eighth.var(axis=0, ddof=1).mean()
    # scipy.stats.f_oneway, whose import takes 0.3 s
    return bool(fdtrc(EIGHTHS - 1, freedom, between / max(within_eighths, 1e-300)) < LEVEL)
