"""A vehicle's recorded runs in which only some states are measured: compared by one-step prediction."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fmus.declaration.component import Component
from fmus.effects import Effect
from fmus.support.errors import InputError
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import one_each
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.experiments.experiment import FreeParameter
from motofmi.gap.experiments.vehicle_over_speed import VehicleOverSpeedExperiment
from motofmi.gap.localisation.predicted_places import cells
from motofmi.gap.models.disturbances import CORNER_SPREAD, FORCES, SPREAD, factors_of
from motofmi.gap.models.one_step_prediction import PredictorModel
from motofmi.gap.preprocessing.predicted_run import BLOCK, LOWEST, PredictedRun, prepare_predicted_run
from motofmi.gap.selection.model_selection import Verdict, select_model
from motofmi.gap.verdict import as_result
from motofmi.recordings.recording import Recording
from motofmi.reports.gap_report import Pictures
from motofmi.reports.gap_vehicle import prediction_spectra
from motofmi.workflows.gap.augmented_vehicle import fitted_of
from motofmi.workflows.gap.given import Given
from motofmi.workflows.gap.vehicle import NOT_LINEAR, OF_HANDS, uncertain, vehicle_effects, vehicle_runs_experiment
from motofmi.workflows.gap.vehicle_runs import OnVehicle, notes_of, with_open_entries
from vehicle_fmu import ridden

RIDER = 0.2  # to which the parameters of whoever holds the handlebar are known
HEAD = "steering_head"  # the element between handlebar and frame
GUSTS = 0.5  # by how much the logarithms of disturbances differ from run to run beyond the first guess of each
DIFFERS = 0.3  # from run to run, of what is not known of a parameter
SHOWN = "What was measured, and the prediction errors, over frequency: base, with the effects found, and the best prediction that the recording allows."


class VehiclePredictions(OnVehicle):
    """Runs with the speed and at least one output of a vehicle."""

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

    def verdict(self, so_far: Callable[[Verdict], None]) -> Verdict:
        return verdict_on_predictions(
            self.experiment, self.runs, self.validation, self.library, so_far, self.given.criteria
        )

    def contents(self, verdict: Verdict) -> dict[str, Any]:
        result = with_open_entries(as_result(verdict, "1", "flexible_model", cells), verdict, self.experiment)
        shown = fitted_of(verdict.best)
        return result | {"base": {n: entry for n, entry in result["base"].items() if n in shown}}

    def limitations(self, verdict: Verdict, contents: dict[str, Any]) -> list[str]:
        every = [*self.runs, *self.validation]
        return [*notes_of(every), *limitations(self.experiment, every, verdict.criteria), *self.unvalidated(contents)]

    def pictures(self, verdict: Verdict) -> Pictures:
        return Pictures([], [(prediction_spectra(verdict), SHOWN)])


def ridden_vehicle_experiment(
    vehicle: Component, device: Component, free: Sequence[str] = ()
) -> VehicleOverSpeedExperiment:
    """The vehicle with a device at its handlebar whose torque nobody records; both fitted within
    what is known of them."""
    held = tuple(
        FreeParameter(f"device.{n}", 0.0, x, RIDER * x)
        for n, x in device.values.items()
        if x > 0 and device.table[n].tunable
    )
    return VehicleOverSpeedExperiment(
        ridden(vehicle, device), "vehicle", "vehicle.speed", (*uncertain(vehicle, free), *held), exact_delays=True
    )


def differing(experiment: VehicleOverSpeedExperiment) -> VehicleOverSpeedExperiment:
    """The stand whose known parameters differ from run to run: tyres warm up, tanks empty, riders sit differently."""
    return replace(
        experiment,
        free=tuple(replace(f, spread=DIFFERS * f.standard_error / f.known) if f.known else f for f in experiment.free),
    )


def with_disturbances(experiment: VehicleOverSpeedExperiment, outputs: Sequence[str]) -> VehicleOverSpeedExperiment:
    """The stand with the levels of disturbances and of the outputs' noise as free parameters:
    factors of a first guess."""
    prefix = f"{experiment.part}." if experiment.part else ""
    factors = factors_of([n for n in FORCES if prefix + n in experiment.component.inputs], outputs)
    free = tuple(
        FreeParameter(experiment.parameter(factors, n), GUSTS, 1.0, CORNER_SPREAD if n.startswith("corner") else SPREAD)
        for n in factors.free_parameters()
    )
    return replace(experiment, component=experiment.with_effects([factors]), free=(*experiment.free, *free))


def predicted_runs(recordings: Sequence[Recording], experiment: VehicleOverSpeedExperiment) -> list[PredictedRun]:
    """The recordings with the outputs and inputs of the vehicle that all of them have. Raises InputError without the
    speed, or any output."""
    component, prefix = experiment.component, f"{experiment.part}." if experiment.part else ""
    own = [n.removeprefix(prefix) for n in component.outputs if n.startswith(prefix)]
    inputs = [n.removeprefix(prefix) for n in component.inputs if n.startswith(prefix) and n != experiment.over]
    over = experiment.over.removeprefix(prefix)
    for r in recordings:
        if over not in r.columns:
            raise InputError(
                f"{r.name}: no {over} [m/s], which a vehicle's run needs; columns: {', '.join(r.columns)}; name one "
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
    """The library, without delays of what is not recorded, and without what nobody could tell from hands.

    Those hold a handlebar without a modelled device; where their torque is not recorded, they are a
    spring, a damper, an inertia.
    """
    recorded = {
        *runs[0].outputs,
        *(() if experiment.part else runs[0].inputs),
    }  # with a device between, nobody knows when an input acts
    every = [e for e in vehicle_effects(vehicle, own) if all(source in recorded for source, _ in e.delayed.values())]
    if experiment.part or torque_is_known(runs):
        return every
    return [e for e in every if e.family not in OF_HANDS and e.element != HEAD]


def verdict_on_predictions(experiment: VehicleOverSpeedExperiment, runs: Sequence[PredictedRun],
                           held: Sequence[PredictedRun], library: Sequence[type[Effect]],
                           so_far: Callable[[Verdict], None] = lambda verdict: None,
                           criteria: Criteria = Criteria()) -> Verdict:  # fmt: skip
    """The verdict on runs, each with the disturbances that are in it.

    A first guess of disturbances and noises is found beside the base. A linear effect that makes up for less than
    `prediction_linear_share` of the noise is not named.
    """
    model = PredictorModel(with_disturbances(differing(experiment), runs[0].outputs))
    base = _base(model, runs)
    held = [replace(r, held=base.runs[0].held) for r in held]
    prepared = [model.with_estimated_disturbances(r, base.of_run(i)) for i, r in enumerate(base.runs)]
    held = [model.with_estimated_disturbances(r, base.shared) for r in held]
    count = sum(len(r.data) for r in prepared)
    criteria = replace(
        criteria,
        second_effect_delta_bic=least_share(prepared, criteria) * count,
        second_effect_share=criteria.prediction_second_effect_share,
    )
    verdict = _decided(model, prepared, library, held, so_far, criteria)
    if doubtful := _doubtful(verdict):
        again = _decided(model, prepared, [e for e in library if e.family not in doubtful], held, so_far, criteria)
        verdict = replace(again, candidates=again.candidates or verdict.candidates)
    return verdict


def _decided(model: PredictorModel, runs: Sequence[PredictedRun], library: Sequence[type[Effect]],
             held: Sequence[PredictedRun], so_far: Callable[[Verdict], None],
             criteria: Criteria) -> Verdict:  # fmt: skip
    """The verdict, without validation runs where the fitted vehicle cannot be predicted in them."""
    try:
        return select_model(model, runs, library, held, so_far, criteria=criteria)
    except InputError:
        if not held:
            raise
        return select_model(model, runs, library, (), so_far, criteria=criteria)


def _doubtful(verdict: Verdict) -> set[str]:
    """Families that gain too little to be named, if the verdict speaks of one: small errors of the base look like them.

    Each parameter may gain a share by such errors. What is not linear is as doubtful as the linear effect that it
    is hardly better than.
    """
    least = least_share(verdict.base.runs, verdict.criteria) * verdict.base.count
    linear = max((c.delta_bic for c in verdict.candidates if c.fitted and c.family not in NOT_LINEAR), default=-np.inf)
    weak = {c.family for c in one_each(verdict.candidates) if c.delta_chi2 < least * len(c.effect.free_parameters())
            and (c.family not in NOT_LINEAR or c.delta_bic < linear + verdict.criteria.tie_delta_bic)}  # fmt: skip
    return weak if weak & {c.family for c in (*verdict.effects, *verdict.tied)} else set()


def least_share(runs: Sequence[PredictedRun], criteria: Criteria) -> float:
    """The share of the noise's power that each parameter of a linear effect must gain for a name."""
    return (
        criteria.prediction_linear_share if torque_is_known(runs) else criteria.prediction_linear_share_without_torque
    )


def torque_is_known(runs: Sequence[PredictedRun]) -> bool:
    """Whether the steer torque is recorded."""
    return "steer_torque" in runs[0].inputs


def _base(model: PredictorModel, runs: Sequence[PredictedRun]) -> Fit:
    """The base fitted, inputs joined between their samples in the way that leaves less."""
    lines = fit(model, [model.with_estimated_disturbances(r, model.start()) for r in runs], model.start())
    if not any(r.inputs for r in runs):
        return lines
    steps = [model.with_estimated_disturbances(replace(r, held=True, noise=None), model.start()) for r in lines.runs]
    held = fit(model, steps, model.start())
    if lines.chi2 <= held.chi2:
        return lines
    return replace(held, runs=[replace(r, mixing=None) for r in held.runs])  # what predicts them best knows less


def limitations(experiment: VehicleOverSpeedExperiment, runs: Sequence[PredictedRun], criteria: Criteria) -> list[str]:
    """What a verdict by prediction rests on."""
    sentences = ["Not all states of the vehicle are recorded: it is predicted from sample to sample, and the errors "
                 f"are compared from {LOWEST:g} Hz on "
                 f"in blocks of {BLOCK:g} s. 1 means consistent with a long regression on all earlier samples.",
                 "Whatever drives the vehicle unrecorded is taken as a roll torque, a side force and a torque about "
                 "the steer axis, each in part white and in part slow; "
                 f"linear effects that gain less than {100 * least_share(runs, criteria):g} % of the noise's power for "
                 "each of their parameters, "
                 f"or {100 * criteria.prediction_second_effect_share:g} % of a larger effect's gain, are not "
                 "named."]  # fmt: skip
    if not any(r.inputs for r in runs):
        sentences.append("No input is recorded: disturbances alone move the vehicle, and only its modes show.")
    if not experiment.part and not torque_is_known(runs):
        sentences.append(
            "The steer torque is not recorded: what hands on a handlebar do as well is not looked for (friction, "
            "springs, dampers and inertia there)."
        )
    return sentences
