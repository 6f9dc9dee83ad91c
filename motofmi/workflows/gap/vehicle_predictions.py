"""The gap of a vehicle from runs in which only some states are recorded, by one-step prediction."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fmus.declaration.component import Component
from fmus.effects import Effect
from fmus.support.errors import InputError
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import Candidate, one_each
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.experiments.experiment import FreeParameter
from motofmi.gap.experiments.vehicle_over_speed import VehicleOverSpeedExperiment
from motofmi.gap.localisation.predicted_places import cells
from motofmi.gap.models.disturbances import CORNER_SPREAD, FORCES, SPREAD, factors_of
from motofmi.gap.models.one_step_prediction import PredictorModel
from motofmi.gap.preprocessing.predicted_run import LOWEST_FREQUENCY, PredictedRun, prepare_predicted_run
from motofmi.gap.preprocessing.undisturbed_intervals import BLOCK
from motofmi.gap.selection.model_selection import select_model
from motofmi.gap.selection.result import Verdict
from motofmi.gap.verdict import as_result
from motofmi.recordings.recording import Recording
from motofmi.reports.gap_report import Pictures
from motofmi.reports.gap_vehicle import prediction_spectra
from motofmi.workflows.gap.augmented_vehicle import fitted_of
from motofmi.workflows.gap.given import Given
from motofmi.workflows.gap.vehicle import (
    LIKE_HANDS,
    NONLINEAR,
    free_parameters_of,
    vehicle_effects,
    vehicle_runs_experiment,
)
from motofmi.workflows.gap.vehicle_runs import OnVehicle, notes_of, with_matrix_entries
from vehicle_fmu import ridden

RIDER_ERROR = 0.2  # relative standard error of the parameters of the device at the handlebar
STEERING_HEAD = "steering_head"  # the element between handlebar and frame
DISTURBANCE_SPREAD = 0.5  # standard deviation between runs of the logarithm of a disturbance's level
RUN_TO_RUN = 0.3  # standard deviation of a parameter between runs, over its standard error
CAPTION = (
    "Measured outputs and their prediction errors over frequency: the base, the base with the effects found, and the "
    "prediction by a regression on all earlier samples."
)


class VehiclePredictions(OnVehicle):
    """A vehicle with recorded speed and at least one recorded output."""

    def __init__(self, given: Given) -> None:
        super().__init__(given)
        vehicle, device = self.vehicle, self.device
        self.experiment = (
            vehicle_runs_experiment(vehicle, given.free, predicted=True, criteria=given.criteria)
            if device is None
            else ridden_vehicle_experiment(vehicle, device, given.free)
        )
        fitted, validation = self.recordings
        every = predicted_runs([*fitted, *validation], self.experiment)
        self.runs, self.validation = every[: len(fitted)], every[len(fitted) :]
        self.library = predictable_effects(vehicle, self.experiment, self.runs, given.own_effects)

    def verdict(self, on_progress: Callable[[Verdict], None]) -> Verdict:
        return verdict_on_predictions(
            self.experiment,
            self.runs,
            self.validation,
            self.library,
            on_progress,
            self.given.criteria,
            self.left_out.append,
        )

    def contents(self, verdict: Verdict) -> dict[str, Any]:
        result = with_matrix_entries(as_result(verdict, "1", "flexible_model", cells), verdict, self.experiment)
        shown = fitted_of(verdict.best)
        return result | {"base": {n: entry for n, entry in result["base"].items() if n in shown}}

    def limitations(self, verdict: Verdict, contents: dict[str, Any]) -> list[str]:
        every = [*self.runs, *self.validation]
        return [*notes_of(every), *limitations(self.experiment, every, verdict.criteria), *self.unused(contents)]

    def pictures(self, verdict: Verdict) -> Pictures:
        return Pictures([], [(prediction_spectra(verdict), CAPTION)])


def ridden_vehicle_experiment(
    vehicle: Component, device: Component, free: Sequence[str] = ()
) -> VehicleOverSpeedExperiment:
    """The vehicle with a device at its handlebar whose torque is not recorded; both are fitted with their priors."""
    of_device = tuple(
        FreeParameter(f"device.{n}", 0.0, x, RIDER_ERROR * x)
        for n, x in device.values.items()
        if x > 0 and device.table[n].tunable
    )
    return VehicleOverSpeedExperiment(
        ridden(vehicle, device), "vehicle", "vehicle.speed", (*free_parameters_of(vehicle, free), *of_device),
        exact_delays=True
    )


def with_run_to_run_spread(experiment: VehicleOverSpeedExperiment) -> VehicleOverSpeedExperiment:
    """The experiment whose parameters with a prior differ between runs, as with tyre temperature, fuel mass and
    posture."""
    return replace(
        experiment,
        free=tuple(replace(f, spread=RUN_TO_RUN * f.standard_error / f.known) if f.known else f
                   for f in experiment.free),
    )


def with_disturbances(experiment: VehicleOverSpeedExperiment, outputs: Sequence[str]) -> VehicleOverSpeedExperiment:
    """The experiment with the levels of disturbances and of sensor noise as free parameters: factors of first
    estimates."""
    prefix = f"{experiment.part}." if experiment.part else ""
    factors = factors_of([n for n in FORCES if prefix + n in experiment.component.inputs], outputs)
    free = tuple(
        FreeParameter(experiment.parameter(factors, n), DISTURBANCE_SPREAD, 1.0,
                      CORNER_SPREAD if n.startswith("corner") else SPREAD)
        for n in factors.free_parameters()
    )
    return replace(experiment, component=experiment.with_effects([factors]), free=(*experiment.free, *free))


def predicted_runs(recordings: Sequence[Recording], experiment: VehicleOverSpeedExperiment) -> list[PredictedRun]:
    """The recordings with the outputs and inputs of the vehicle that all of them have.

    Raises InputError if the speed is missing in one, or if they have no output in common.
    """
    component, prefix = experiment.component, f"{experiment.part}." if experiment.part else ""
    own = [n.removeprefix(prefix) for n in component.outputs if n.startswith(prefix)]
    inputs = [n.removeprefix(prefix) for n in component.inputs if n.startswith(prefix) and n != experiment.over]
    over = experiment.over.removeprefix(prefix)
    for r in recordings:
        if over not in r.columns:
            raise InputError(
                f"{r.name}: expected a column {over} [m/s]; found: {', '.join(r.columns)}; name one "
                f"with --map COLUMN={over}"
            )
    shared = [n for n in recordings[0].columns if all(n in r.columns for r in recordings)]
    outputs = tuple(n for n in own if n in shared)
    if not outputs:
        raise InputError(f"{recordings[0].name}: no column is an output of {component.name} ({', '.join(own)}); "
                         f"columns of all runs: {', '.join(shared)}; name them with --map COLUMN=VARIABLE")  # fmt: skip
    return [
        prepare_predicted_run(r, over, outputs, tuple(n for n in inputs if n in shared and np.ptp(r[n]) > 0))
        for r in recordings
    ]


def predictable_effects(
    vehicle: Component,
    experiment: VehicleOverSpeedExperiment,
    runs: Sequence[PredictedRun],
    own: Sequence[type[Effect]] = (),
) -> list[type[Effect]]:
    """The effects that are identifiable from the recorded variables.

    Delays of variables that are not recorded are left out. If neither a device is modelled nor the steer torque is
    recorded, the effects of the rider's hands on the handlebar (LIKE_HANDS, and effects in the steering head) are left
    out too.
    """
    # With a device at the handlebar the time at which an input acts is not known.
    recorded = {*runs[0].outputs, *(() if experiment.part else runs[0].inputs)}
    every = [e for e in vehicle_effects(vehicle, own) if all(source in recorded for source, _ in e.delayed.values())]
    if experiment.part or torque_is_known(runs):
        return every
    return [e for e in every if e.family not in LIKE_HANDS and e.element != STEERING_HEAD]


def verdict_on_predictions(experiment: VehicleOverSpeedExperiment, runs: Sequence[PredictedRun],
                           validation: Sequence[PredictedRun], library: Sequence[type[Effect]],
                           on_progress: Callable[[Verdict], None] = lambda verdict: None,
                           criteria: Criteria = Criteria(),
                           on_left_out: Callable[[str], None] = lambda sentence: None) -> Verdict:  # fmt: skip
    """The verdict on runs, with the disturbances of each estimated.

    First estimates of disturbances and sensor noise are fitted together with the base. A linear effect that explains
    less than `prediction_linear_share` of the noise is not named. on_left_out is called with a sentence on effects that
    are left out for it, and on validation runs that cannot be used.
    """
    model = PredictorModel(with_disturbances(with_run_to_run_spread(experiment), runs[0].outputs))
    base = _base(model, runs)
    validation = [replace(r, held=base.runs[0].held) for r in validation]
    prepared = [model.with_estimated_disturbances(r, base.of_run(i)) for i, r in enumerate(base.runs)]
    validation = [model.with_estimated_disturbances(r, base.shared) for r in validation]
    count = sum(len(r.data) for r in prepared)
    criteria = replace(
        criteria,
        second_effect_delta_bic=least_share(prepared, criteria) * count,
        second_effect_share=criteria.prediction_second_effect_share,
    )
    verdict = _selected(model, prepared, library, validation, on_progress, criteria, on_left_out)
    if doubtful := _doubtful(verdict):
        on_left_out(_sentence_on(doubtful, verdict))
        families = {c.family for c in doubtful}
        rest = [e for e in library if e.family not in families]
        again = _selected(model, prepared, rest, validation, on_progress, criteria, on_left_out)
        verdict = replace(again, candidates=again.candidates or verdict.candidates)
    return verdict


def _selected(model: PredictorModel, runs: Sequence[PredictedRun], library: Sequence[type[Effect]],
             validation: Sequence[PredictedRun], on_progress: Callable[[Verdict], None],
             criteria: Criteria, on_left_out: Callable[[str], None]) -> Verdict:  # fmt: skip
    """The verdict; without validation if the fitted vehicle cannot be predicted in the validation runs."""
    try:
        return select_model(model, runs, library, validation, on_progress, criteria=criteria)
    except InputError as error:
        if not validation:
            raise
        # An error that the validation runs did not cause is raised again.
        verdict = select_model(model, runs, library, (), on_progress, criteria=criteria)
        on_left_out(f"{', '.join(r.name for r in validation)}: not used for validation, because of an error: {error}.")
        return verdict


def _doubtful(verdict: Verdict) -> list[Candidate]:
    """Candidates with a gain that small errors of the base can cause, if the verdict names or ties one of their
    families; else none.

    By such errors each parameter may gain `least_share` of the noise's power. A nonlinear effect is doubtful only if it
    is also hardly better than the best linear one.
    """
    least = least_share(verdict.base.runs, verdict.criteria) * verdict.base.count
    linear = max((c.delta_bic for c in verdict.candidates if c.fitted and c.family not in NONLINEAR), default=-np.inf)
    weak = [c for c in one_each(verdict.candidates) if c.delta_chi2 < least * len(c.effect.free_parameters())
            and (c.family not in NONLINEAR or c.delta_bic < linear + verdict.criteria.tie_delta_bic)]  # fmt: skip
    selected = {c.family for c in (*verdict.effects, *verdict.tied)}
    return weak if any(c.family in selected for c in weak) else []


def _sentence_on(doubtful: Sequence[Candidate], verdict: Verdict) -> str:
    """The sentence on candidates that are left out because of their gain."""
    least, count = least_share(verdict.base.runs, verdict.criteria), verdict.base.count
    gains = [
        f"{c.family} gains {100 * max(c.delta_chi2, 0.0) / count:.3g} % ({n} parameter{'s' if n > 1 else ''})"
        for c in doubtful
        for n in [len(c.effect.free_parameters())]
    ]
    return (
        f"Left out are effects that gain less than {100 * least:g} % of the noise's power for each of their "
        f"parameters: {', '.join(gains)}."
    )


def least_share(runs: Sequence[PredictedRun], criteria: Criteria) -> float:
    """The share of the noise's power that an effect must gain for each of its parameters to be named."""
    return (
        criteria.prediction_linear_share if torque_is_known(runs) else criteria.prediction_linear_share_without_torque
    )


def torque_is_known(runs: Sequence[PredictedRun]) -> bool:
    """Whether the steer torque is recorded."""
    return "steer_torque" in runs[0].inputs


def _base(model: PredictorModel, runs: Sequence[PredictedRun]) -> Fit:
    """The fitted base, with inputs interpolated linearly or held between samples, whichever has the smaller
    chi-square."""
    interpolated = _fit_with_disturbances(model, runs)
    if not any(r.inputs for r in runs):
        return interpolated
    held = _fit_with_disturbances(model, [replace(r, held=True) for r in interpolated.runs])
    if interpolated.chi2 <= held.chi2:
        return interpolated
    return replace(held, runs=[replace(r, mixing=None) for r in held.runs])  # estimated for interpolated inputs


def _fit_with_disturbances(model: PredictorModel, runs: Sequence[PredictedRun]) -> Fit:
    """The base fitted with disturbances that are estimated for its start values, and then for its fitted values.

    Prediction errors of wrong start values are attributed to disturbances in the first estimates, and a fit changes an
    estimate by a factor with a prior only. The fit with the smaller chi-square is returned.
    """

    def estimated(runs: Sequence[PredictedRun], vectors: Sequence[np.ndarray]) -> list[PredictedRun]:
        return [
            model.with_estimated_disturbances(replace(r, noise=None), q) for r, q in zip(runs, vectors, strict=True)
        ]

    first = fit(model, estimated(runs, [model.start()] * len(runs)), model.start())
    runs = estimated(first.runs, [first.of_run(i) for i in range(len(runs))])
    again = fit(model, runs, model.with_disturbances_as_estimated(first.x))
    return min(first, again, key=lambda found: found.chi2)


def limitations(experiment: VehicleOverSpeedExperiment, runs: Sequence[PredictedRun], criteria: Criteria) -> list[str]:
    """The limitations of a verdict by one-step prediction, in sentences."""
    sentences = ["Not all states of the vehicle are recorded: its outputs are predicted one sample ahead, and the "
                 f"prediction errors are compared from {LOWEST_FREQUENCY:g} Hz upwards in blocks of {BLOCK:g} s. 1 "
                 "means consistent with a regression on all earlier samples.",
                 "Excitation that is not recorded is modelled as a roll torque, a side force and a torque about the "
                 "steer axis, each with a white and a slow part; linear effects that gain less than "
                 f"{100 * least_share(runs, criteria):g} % of the noise's power for each of their parameters, or "
                 f"{100 * criteria.prediction_second_effect_share:g} % of a larger effect's gain, are not "
                 "named."]  # fmt: skip
    if not any(r.inputs for r in runs):
        sentences.append("No input is recorded: only disturbances excite the vehicle, and only its modes are "
                         "identifiable.")
    if not experiment.part and not torque_is_known(runs):
        sentences.append(
            "The steer torque is not recorded: friction, springs, dampers and inertia at the handlebar are not "
            "searched for, as the rider's hands act in the same way."
        )
    return sentences
