"""The limitations of a verdict on the recordings of a component: what it rests on, and values that need attention."""

from collections.abc import Iterable, Iterator
from typing import Any

from fmus.declaration.component import Component
from fmus.declaration.units import written
from fmus.effects.measuring_channel import ChannelDelay
from fmus.support.errors import InputError
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import magnitudes_at_bounds
from motofmi.gap.estimation.fit_result import Fit, parameters_of, places_of, sensor_offsets_of, undetermined
from motofmi.gap.experiments.input_output import SLIDING_RATE
from motofmi.gap.experiments.sensor_offset import sensor_offset_parameter
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.input_interpolation import HELD
from motofmi.gap.selection.any_component import Investigation, sentence_on_slow_noise

FLEXIBLE = ("The noise is not known (no repeated runs, no noise in rig.json): it is estimated by the residuals of a "
            "flexible model, so a reduced chi-square of 1 means consistent with that model.")  # fmt: skip
NONE_IS_WEAK = (
    "none means that no effect of the library improves the model; residuals of the flexible model count as noise."
)
NO_UNIT = (
    "A state has the unit 1, so that the laws of mechanics (friction, drag, a further body) are no candidates; where "
    "it is an angle, a displacement or their rate, give its unit in the class and in the columns."
)
NO_ELEMENT = (
    "No state of the component has the unit of a deflection (m, rad) or of its rate (m/s, rad/s), so that the laws of "
    "mechanics (friction, drag, a further body) are no candidates."
)
FROM_REST = (
    "The runs are step responses, and begin at rest: their initial states are known. With free initial states a "
    "constant input would have no influence."
)
DOUBLE_INTEGRATOR = (
    "Spring and damper of the base, if it has any, have no influence over the length of a segment, so that errors of its "
    "simulation grow with the square of time: the runs are compared in segments of at most {:.3g} s, each with its own "
    "initial states."
)
NARROWED = (
    "Dry friction changes its direction within {}, which fits better than the wider transition of the search ({}). In "
    "either of them a body creeps where the real one may stick."
)
NOISE_OF_WIDE = " The noise of the fitted runs, and standard errors with it, are those that the wider one leaves."


def limitations_of(found: Investigation, result: dict[str, Any], component: Component, held: bool) -> list[str]:
    """The limitations of an investigation of a component, in sentences. held: whether there are validation runs."""
    best, criteria = found.verdict.best, found.verdict.criteria
    return [
        *_on_the_noise(found, result),
        *_on_the_base(found),
        *_on_the_transition(found),
        *_on_base_values(best, criteria),
        *_on_bounds(best, found.experiment.own_values),
        *(_on_start_values(best, component, criteria) if found.experiment.own_values else ()),
        *_on_sensor_offsets(best, found.experiment.sensor_offsets, criteria),
        *_on_held_inputs(best),
        *_on_output_offsets(best),
        *_on_validation(found, result, held),
    ]


def offset_like_friction(found: Investigation) -> str | None:
    """The first sentence on an offset of an input that dry friction in a motion of one direction has as well."""
    best = found.verdict.best
    offsets = _on_sensor_offsets(best, found.experiment.sensor_offsets, found.verdict.criteria, one_way=True)
    return next(offsets, None)


def _on_the_noise(found: Investigation, result: dict[str, Any]) -> Iterator[str]:
    """The source of the noise, where it was not known."""
    if result["noise_source"] != "flexible_model":
        return
    yield FLEXIBLE
    compared = found.verdict.comparison
    if result["verdict"] == "none" and not (compared and compared.outcome.verdict == "none"):  # by the tolerance
        yield NONE_IS_WEAK


def _on_the_base(found: Investigation) -> Iterator[str]:
    """What was assumed of the base, what was left out, and how much no model explains."""
    if found.experiment.from_rest:
        yield FROM_REST
    for name in found.fixed_inertias:
        yield f"{name} keeps its value: at the frequencies of these runs it is not distinguishable from a stiffness."
    if limits := [run.longest_of_integrator for run in found.verdict.base.runs if run.longest_of_integrator]:
        yield DOUBLE_INTEGRATOR.format(min(limits))
    yield from found.left_out
    bearing = found.experiment.component
    if not bearing.elements and bearing.states:
        yield NO_UNIT if any(bearing.table[n].unit == "1" for n in bearing.states) else NO_ELEMENT
    slow_noise = sentence_on_slow_noise(found.missed, found.experiment.outputs)
    if found.missed > found.verdict.criteria.slow_noise_share and found.verdict.withheld != slow_noise:
        yield slow_noise


def _on_the_transition(found: Investigation) -> Iterator[str]:
    """The transition of dry friction, where a narrower one than that of the search fits better."""
    models: Any = found.verdict.base.model, found.verdict.best.model
    wide, narrow = (model.experiment.sliding_rate for model in models)
    if narrow < wide:
        unit = models[1].component.table[SLIDING_RATE].unit
        by_chi_square = found.verdict.comparison is None
        said = NARROWED.format(written(f"{narrow:.2g}", unit), written(f"{wide:.2g}", unit))
        yield said + (NOISE_OF_WIDE if by_chi_square else "")


def _on_base_values(best: Fit, criteria: Criteria) -> Iterator[str]:
    """Values of the base that are not distinguishable from zero; where all are, the verdict has a sentence on them."""
    base = {n: p for n, p in parameters_of(best).items() if n in best.model.base}
    vanishing = undetermined(base, criteria.value_errors)
    for name in vanishing if len(vanishing) < len(base) else []:
        value, error, unit = base[name]
        yield (
            f"{name} = {written(f'{value:.3g}', unit)} is not distinguishable from zero (standard error {error:.2g}). "
            "If the component has no such element, set it to 0 in a value file: --component FILE.toml."
        )


def _on_bounds(best: Fit, own_values: bool) -> Iterator[str]:
    """Magnitudes of effects that were fitted to one of their bounds."""
    for name, value in magnitudes_at_bounds(best).items():
        bound = written(f"{value:g}", best.model.component.table[name].unit)
        cause = ", or a column's unit is wrong" if own_values else ""
        yield f"{name} was fitted to its bound {bound}: the effect does not fit well{cause}."


def _on_start_values(best: Fit, component: Component, criteria: Criteria) -> Iterator[str]:
    """Values of the base that were fitted far from those of the component."""
    far = criteria.implausible_factor
    for name, (value, _, unit) in parameters_of(best).items():
        start = abs(component.values.get(name, 0.0))
        if name not in best.model.base or not start or 1 / far < abs(value) / start < far:
            continue
        vanished = best.model.component.table[name].min <= 0 and abs(value) < start / far
        yield f"{name} was fitted to {written(f'{value:.3g}', unit)}, far from its start value {start:.3g}: " + (
            "the data are fitted as well without it." if vanished else "is a column's unit wrong?"
        )


def _on_sensor_offsets(
    best: Fit, columns: Iterable[str], criteria: Criteria, one_way: bool = False
) -> Iterator[str]:
    """Offsets of sensors that are distinguishable from zero, with `one_way` those of runs of one direction alone."""
    common, measured = best.model.experiment.common_offsets, best.model.experiment.outputs
    for run, offsets in zip(best.runs[:1] if common else best.runs, sensor_offsets_of(best), strict=False):
        in_one_direction = bool(run.direction) and not common
        if one_way and not in_one_direction:
            continue
        friction = ", dry friction (the rate has one sign)" if in_one_direction else ""
        for name in columns:
            value, error = offsets[sensor_offset_parameter(name)]
            if abs(value) > criteria.sensor_offset_errors * error:
                acting = -value if name in measured else value  # an output is recorded with its offset
                yield (
                    f"The {name} of {'every run' if common else run.name} is fitted as the recorded values plus "
                    f"{acting:.2g} {run.recording.units[name]} (standard error {error:.1g}): a sensor offset{friction}, "
                    "or another constant input."
                )


def _on_held_inputs(best: Fit) -> Iterator[str]:
    """What a fitted delay is against inputs that are held between their samples, where the chosen interpolation is
    smooth or by lines."""
    experiment, run = best.model.experiment, best.runs[0]
    delay = next((effect for effect in best.model.effects if issubclass(effect, ChannelDelay)), None)
    if delay is None or experiment.imposed or not experiment.driven or run.kind == HELD:
        return
    half, inputs = 0.5 / run.recording.rate, " and ".join(experiment.driven)
    (place,) = places_of(best, delay, ("delay",))
    yield (
        f"The delay is against {inputs} interpolated between its samples. If a controller holds it there, the delay is "
        f"{best.x[place] - half:.3g} s, half a sampling interval ({half:.3g} s) less."
    )


def _on_output_offsets(best: Fit) -> Iterator[str]:
    """Fitted offsets of outputs that are larger than the motion (rms): the simulation alone is far from the recorded
    values then."""
    model: Any = best.model
    if not isinstance(model, FreeInitialStateModel) or model.experiment.imposed:
        return
    for index, run in enumerate(best.runs):
        try:
            offsets = model.offsets_of_outputs(run, best.of_run(index))
        except InputError:  # a model that nearly diverges may do so from other initial states
            continue
        for name, offset, motion in zip(run.experiment.outputs, offsets, run.motion_variance**0.5, strict=True):
            if abs(offset) > motion:
                yield (
                    f"The {name} of {run.name} is compared up to a constant: the recorded values are those of the "
                    f"model plus {offset:.3g} {run.recording.units[name]}, an offset of its sensor or an equilibrium "
                    "that the component does not have."
                )


def _on_validation(found: Investigation, result: dict[str, Any], held: bool) -> Iterator[str]:
    """What the validation runs show of a name by chi-square, or that there are none."""
    if not held:
        yield "No validation run: the verdict is not checked on data that were not used."
        return
    gap, share = result["gap"], found.verdict.criteria.validation_warning_share
    if gap["holdout_after"] is None and not result["ended"]:
        yield (
            "The rms on the validation runs is not stated: with the fitted values no initial states were found from "
            "which the simulation is near them."
        )
        return
    by_chi_square = found.verdict.comparison is None and result["verdict"] == "named"
    if by_chi_square and gap["holdout_after"] - 1 > (1 - share) * (gap["holdout_before"] - 1):
        yield (
            f"On the validation run the effect closes less than {share:.0%} of the gap: it may be specific to the "
            "fitted runs."
        )
