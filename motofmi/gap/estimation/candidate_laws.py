"""The laws that are candidates on sampled runs, with a sentence for each rule that leaves some out.

A law is no candidate where the recorded motion does not distinguish it from others:

- While a mass moves one way (see `one_way`), a hysteresis or an asymmetry of damping has no meaning: without a reversal
  its force is that of friction and drag.
- The start of a deflection that is not recorded is unknown, and while its rate has one sign it only grows: its laws can
  be any function of the distance covered.
- The motion is taken about its mean in each run. Where the means differ by more than the motion itself and the base has
  no spring, a law of the deflection would have another centre in each run, and a spring has one.
- A body that rotates by more than a revolution in one direction has no spring: where the base has none, the forces of
  springs are no candidates.
- Without an input the amplitude falls with the time: a damper or spring that changes over time has the response of one
  that depends on the amplitude. So has a hysteresis: for a slowly changing amplitude it is a stiffness and a damping
  that depend on it (Caughey, J. Appl. Mech. 27 (1960) 640-643). While a rate keeps its sign, a sensor that drifts
  steadily has the response of dry friction, and one whose gain depends on the reading that of a drag: for v' = -f(v)
  and y = g(v), y' = -h(y) with h = g' f.
- The torque of gravity follows the sine of an angle, whose linear part is a stiffness. Where nothing in the base
  depends on the angle, that part is missing as well. The angle is counted from the vertical. Where it is imposed, and
  moves by a quarter of a revolution or more, the vertical is unknown as well: over less, its torque is that of a spring
  that hardens or is stiffer to one side. Of an angle that is an output, an unknown offset has that place.
- The error of an angle's sensor repeats with every revolution, where the laws of a sensor grow with the reading.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from fmus.declaration.component import Component
from fmus.effects import Effect, sensor
from fmus.effects.drift import Drift
from fmus.effects.hysteresis import DahlHysteresis
from fmus.effects.library import declared_by
from fmus.effects.output_channel import ClippedSensor, SensorDrift
from fmus.effects.placement import laws_at
from fmus.effects.stiffness import GravityTorque, TurnedGravityTorque
from fmus.linear_analysis.linearisation import linearise
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.experiments.input_output import InputOutputExperiment
from motofmi.gap.preprocessing.one_way import is_one_way, keeps_direction
from motofmi.gap.preprocessing.sampled_run import SampledRun, excited
from motofmi.gap.preprocessing.springs_like_friction import rotates

ONE_WAY = (
    "{}: the motion is never reversed. Not candidates there: {}; they are not distinguishable from friction and "
    "drag. A run with reversals would distinguish them."
)
UNSEEN = (
    "{} is not recorded, and its rate has one sign. Not candidates there: {}; they can be any "
    "function of the distance covered. A run in the other direction would distinguish them."
)
HYSTERESIS = DahlHysteresis.family
QUARTER = np.pi / 2  # rad
CENTRES = (
    "{}: the means of the runs, {:.3g} to {:.3g} {}, differ by more than the motion about them, and the base has no "
    "spring. Not candidates there: {}; they would have another centre in each run."
)
NO_SPRINGS = (
    "{}: the angle increases or decreases by more than a revolution, and the base has no spring. Not candidates there: "
    "{}; they are the forces of springs."
)
NO_RESTORING = (
    "{}: nothing in the base depends on it. Not a candidate there: {}; the torque of gravity has a linear part, which "
    "the base does not have either."
)
REVOLUTIONS = (
    "{}: the angle exceeds a revolution. Laws of its sensor are no candidates: the error of an encoder repeats with "
    "every revolution."
)
UNDRIVEN = (
    "No run has an input that varies, so that the amplitude falls with the time. Not candidates: {}; they are not "
    "distinguishable from friction, drag and springs whose stiffness changes with the deflection. A run with an input "
    "would distinguish them."
)


def candidate_laws(experiment: InputOutputExperiment, found: Fit) -> tuple[list[type[Effect]], list[str]]:
    """The laws at the places of the component that the runs of a fit can distinguish, and the sentences on the others.

    experiment holds the fitted component, and the largest deflection and rate of its first element.
    """
    runs = found.runs
    inputs, outputs = _largest(runs, experiment.driven), _largest(runs, experiment.outputs)
    table = experiment.component.table
    turning = [n for n, level in outputs.items() if table[n].unit == "rad" and level > 2 * np.pi]
    for name in turning:
        del outputs[name]
    states = {} if experiment.imposed else _ranges(found)
    period = float(np.median([1 / run.middle_frequency for run in runs]))
    library = laws_at(
        experiment.component, experiment.largest_rate, inputs, outputs, states, period, experiment.largest
    )
    if not _turns_by_a_quarter(runs):
        library = [effect for effect in library if not issubclass(effect, TurnedGravityTorque)]
    kept, sentences = _distinguishable(library, found)
    kept, rotating = _without_springs_of_rotating_bodies(kept, found)
    kept, centres = _with_one_centre(kept, found)
    kept, free = _with_restoring_force(kept, experiment.component)
    kept, undriven = _without_those_of_driven_runs(kept, runs)
    return kept, [*sentences, *rotating, *centres, *free, *undriven, *(REVOLUTIONS.format(name) for name in turning)]


def _turns_by_a_quarter(runs: Sequence[SampledRun]) -> bool:
    """Whether an imposed state moves by a quarter of a revolution or more in a run."""
    imposed = [run.recording[run.experiment.imposed] for run in runs if run.experiment.imposed]
    return any(np.ptp(angle) >= QUARTER for angle in imposed)


def _distinguishable(library: Sequence[type[Effect]], found: Fit) -> tuple[list[type[Effect]], list[str]]:
    """The laws without those that a motion in one direction does not distinguish from others, and a sentence for each
    motion whose elements lose some."""
    elements = found.model.experiment.component.elements
    recorded = {name for run in found.runs for name in run.recording.columns}
    left_out: dict[tuple[str, str], list[type[Effect]]] = {}  # by sentence and motion
    for name in sorted(_one_way_elements(found)):
        at_element = [effect for effect in library if effect.element == name]
        motion = elements[name].deflection or elements[name].rate
        unseen = elements[name].deflection not in recorded
        both_ways = [effect for effect in at_element if effect.both_ways]
        of_deflection = [e for e in at_element if unseen and "deflection" in e.reads() and e not in both_ways]
        for sentence, laws in ((ONE_WAY, both_ways), (UNSEEN, of_deflection)):
            if laws:
                left_out.setdefault((sentence, motion), []).extend(laws)
    every = [effect for laws in left_out.values() for effect in laws]
    kept = [effect for effect in library if effect not in every]
    return kept, [s.format(motion, _listed(laws, kept)) for (s, motion), laws in left_out.items()]


def _without_springs_of_rotating_bodies(
    library: Sequence[type[Effect]], found: Fit
) -> tuple[list[type[Effect]], list[str]]:
    """The laws without the forces of springs on an angle that rotates in every run where the base has no spring, and a
    sentence for each angle that loses some."""
    experiment, left_out = found.model.experiment, dict[str, list[type[Effect]]]()  # by angle
    component, free = experiment.component, {f.name for f in experiment.free}
    for name, element in component.elements.items():
        spring = element.stiffness and (element.stiffness in free or component.values[element.stiffness])
        laws = [e for e in library if e.element == name and _is_spring(e)]
        if laws and not spring and all(rotates(element, run) for run in found.runs):
            left_out.setdefault(element.deflection, []).extend(laws)
    every = [effect for laws in left_out.values() for effect in laws]
    kept = [effect for effect in library if effect not in every]
    return kept, [NO_SPRINGS.format(angle, _listed(laws, kept)) for angle, laws in left_out.items()]


def _is_spring(law: type[Effect]) -> bool:
    """Whether the force of a law follows from the deflection alone."""
    return "deflection" in law.reads() and "rate" not in law.reads() and not law.has_states()


def _with_one_centre(library: Sequence[type[Effect]], found: Fit) -> tuple[list[type[Effect]], list[str]]:
    """The laws without those of a deflection that has another centre in each run, and a sentence for each element that
    loses some. Laws with states, as a hysteresis, have no centre."""
    experiment, left_out, sentences = found.model.experiment, list[type[Effect]](), list[str]()
    for name, element in experiment.component.elements.items():
        recorded = [run.recording[element.deflection] for run in found.runs
                    if not element.stiffness and element.deflection in run.recording.columns]  # fmt: skip
        means = [float(np.mean(y)) for y in recorded] or [0.0]
        largest = max((float(np.max(np.abs(y - np.mean(y)))) for y in recorded), default=0.0)
        laws = [e for e in library if e.element == name and "deflection" in e.reads() and not e.has_states()]
        if max(means) - min(means) > 2 * largest and laws:
            left_out += laws
            unit, kept = experiment.component.table[element.deflection].unit, [e for e in library if e not in laws]
            sentences.append(CENTRES.format(element.deflection, min(means), max(means), unit, _listed(laws, kept)))
    return [effect for effect in library if effect not in left_out], sentences


def _with_restoring_force(
    library: Sequence[type[Effect]], component: Component
) -> tuple[list[type[Effect]], list[str]]:
    """The laws without the torque of gravity on a deflection on which nothing in the component depends, as the heading
    of a ship, and a sentence for each."""
    states, slopes, kept, sentences = list(component.states), linearise(component).A, list(library), list[str]()
    for name, element in component.elements.items():
        laws = [e for e in kept if e.element == name and issubclass(e, (GravityTorque, TurnedGravityTorque))]
        if laws and element.deflection in states and not np.any(slopes[:, states.index(element.deflection)]):
            kept = [effect for effect in kept if effect not in laws]
            sentences.append(NO_RESTORING.format(element.deflection, _listed(laws, kept)))
    return kept, sentences


def _without_those_of_driven_runs(
    library: Sequence[type[Effect]], runs: Sequence[SampledRun]
) -> tuple[list[type[Effect]], list[str]]:
    """The laws without those that free runs do not distinguish from others, and a sentence where there are any."""
    if excited(runs):
        return list(library), []
    confounded: list[type[Effect]] = [Drift, *(e for e in library if e.family == HYSTERESIS)]
    if all(run.direction for run in runs):
        confounded += [SensorDrift, ClippedSensor, *declared_by(sensor)]
    left_out = [effect for effect in library if issubclass(effect, tuple(confounded))]
    kept = [effect for effect in library if effect not in left_out]
    return kept, [UNDRIVEN.format(_listed(left_out, kept))] if left_out else []


def _listed(left_out: Sequence[type[Effect]], kept: Sequence[type[Effect]]) -> str:
    """The families of laws that are left out; of a family with other laws that are kept, the forms."""
    others = {effect.family for effect in kept}
    names = [f"{e.family} ({e.form})" if e.family in others else e.family for e in left_out]
    return ", ".join(dict.fromkeys(names))


def _one_way_elements(found: Fit) -> set[str]:
    """The elements whose rate has one sign in every run: the recorded one, else that of the fit; that of an imposed
    motion has one in every segment.

    Where the deflection is recorded, it must keep its direction as well: a free base without stiffness never turns
    back, and the machine may have a spring.
    """
    model: Any = found.model
    one_way = set(model.moving)
    for index, run in enumerate(found.runs):
        if imposed := run.experiment.imposed:
            one_way = {each for each in one_way if each[0] == imposed and 0.0 not in run.directions}
            continue
        _, _, rates, _ = model.residuals_and_motion(run, found.of_run(index))
        recorded, parts = run.recording.columns, run.recording.parts
        one_way &= {
            (deflection, name)
            for (deflection, name), rate in zip(model.moving, rates, strict=False)  # without elements rates are zero
            if (name in run.one_way_rates if name in recorded else is_one_way(rate))
            and (deflection == name or deflection not in recorded or all(map(keeps_direction, parts(deflection))))
        }
    elements = model.experiment.component.elements.items()
    return {name for name, e in elements if (e.deflection or e.rate, e.rate) in one_way}


def _largest(runs: Sequence[SampledRun], names: Sequence[str]) -> dict[str, float]:
    """The 99.9 % quantiles of the moduli of recorded signals by name, the largest of all runs; zeros are left out."""
    levels = {n: max(float(np.quantile(np.abs(run.recording[n]), 0.999)) for run in runs) for n in names}
    return {n: level for n, level in levels.items() if level > 0}


def _ranges(found: Fit) -> dict[str, tuple[float, float]]:
    """The ranges of the states in the runs, without those that stay constant."""
    model: Any = found.model
    every = [model.ranges_of_states(run, found.of_run(index)) for index, run in enumerate(found.runs)]
    ranges = {n: (min(r[n][0] for r in every), max(r[n][1] for r in every)) for n in every[0]}
    return {n: (low, high) for n, (low, high) in ranges.items() if high > low}
