"""The gap of a vehicle from runs in which all of its states are recorded, by the weak form of its equations."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fmus.declaration.component import Component
from fmus.effects import Effect
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.experiments.vehicle_over_speed import VehicleOverSpeedExperiment
from motofmi.gap.localisation.weak_form_places import cells
from motofmi.gap.models.weak_form_model import WeakFormModel, accelerated
from motofmi.gap.preprocessing.undisturbed_intervals import BLOCK
from motofmi.gap.preprocessing.weak_form import BAND, WeakFormRun, prepare_weak_form
from motofmi.gap.selection.model_selection import select_model
from motofmi.gap.selection.result import Verdict
from motofmi.gap.verdict import as_result
from motofmi.recordings.recording import Recording
from motofmi.reports.gap_report import Pictures
from motofmi.reports.gap_vehicle import weak_form_spectra
from motofmi.workflows.gap.given import Given
from motofmi.workflows.gap.vehicle import NONLINEAR, vehicle_effects, vehicle_runs_experiment
from motofmi.workflows.gap.vehicle_runs import OnVehicle, notes_of, with_matrix_entries

CAPTION = (
    "Residuals of the equations of motion over frequency: the vehicle as given, the fitted base, the base with the "
    "effects found, and the disturbance."
)


class VehicleEquations(OnVehicle):
    """A vehicle without a device, with recorded speed and states."""

    @classmethod
    def suits(cls, given: Given) -> bool:
        if not super().suits(given) or given.base_device is not None:
            return False
        needed = {"speed", *given.base_vehicle.states}
        return all(needed <= r.columns.keys() for r in cls.recorded(given))

    def __init__(self, given: Given) -> None:
        super().__init__(given)
        self.experiment = vehicle_runs_experiment(self.vehicle, given.free, criteria=given.criteria)
        self.runs, self.validation = (weak_runs(each, self.experiment) for each in self.recordings)

    def verdict(self, on_progress: Callable[[Verdict], None]) -> Verdict:
        return verdict_on_runs(
            self.experiment,
            self.runs,
            self.validation,
            runs_effects(self.vehicle, self.given.own_effects),
            on_progress,
            self.given.criteria,
            self.left_out.append,
        )

    def contents(self, verdict: Verdict) -> dict[str, Any]:
        return with_matrix_entries(as_result(verdict, "rad/s2", "flexible_model", cells), verdict, self.experiment)

    def limitations(self, verdict: Verdict, contents: dict[str, Any]) -> list[str]:
        return [*limitations([*self.runs, *self.validation], verdict.criteria), *self.unused(contents)]

    def pictures(self, verdict: Verdict) -> Pictures:
        given = as_given(verdict.base.model.experiment, verdict.best.runs[:1])
        return Pictures([], [(weak_form_spectra(verdict, given), CAPTION)])


def weak_runs(recordings: Sequence[Recording], experiment: VehicleOverSpeedExperiment) -> list[WeakFormRun]:
    """The recordings in weak form. Raises InputError for a recording of which too little can be used."""
    return [
        prepare_weak_form(
            r,
            experiment.over,
            accelerated(experiment),
            list(experiment.component.states),
            [n for n in experiment.component.inputs if n in r.columns],
        )
        for r in recordings
    ]


def runs_effects(vehicle: Component, own: Sequence[type[Effect]] = ()) -> list[type[Effect]]:
    """The effects that add no states to the vehicle, so that all states remain recorded."""
    return [
        e for e in vehicle_effects(vehicle, own) if vehicle.with_effects(e(exact_delays=True)).states == vehicle.states
    ]


def verdict_on_runs(experiment: VehicleOverSpeedExperiment, runs: Sequence[WeakFormRun],
                    validation: Sequence[WeakFormRun], library: Sequence[type[Effect]],
                    on_progress: Callable[[Verdict], None] = lambda verdict: None,
                    criteria: Criteria = Criteria(),
                    on_left_out: Callable[[str], None] = lambda sentence: None) -> Verdict:  # fmt: skip
    """The verdict on runs, with the disturbance of each estimated.

    By feedback the motion depends on the disturbance, which biases the equations like a small linear effect: a linear
    effect that explains less than `weak_form_linear_share` of the disturbance is not named. It is left out of a further
    selection, and on_left_out is called with a sentence on it. Inputs are either held between samples or interpolated,
    whichever leaves the smaller disturbance.
    """
    model = WeakFormModel(experiment)
    prepared_runs = [
        [[model.with_remaining_noise(replace(r, held=input_held), model.start()) for r in each]
         for each in (runs, validation)]
        for input_held in (False, True)
    ]
    prepared, checked = min(
        prepared_runs, key=lambda each: sum(np.log(d(r.frequency)).sum() for r in each[0] for d in r.densities)
    )
    verdict = select_model(model, prepared, library, checked, on_progress, criteria=criteria)
    count, least = verdict.base.count, criteria.weak_form_linear_share
    while doubtful := {
        c.family: c.delta_chi2 / count
        for c in (*verdict.effects, *verdict.tied)
        if c.family not in NONLINEAR and c.delta_chi2 < least * count
    }:
        for family, share in doubtful.items():
            on_left_out(f"{family} is left out: it explains {share:.3g} of the disturbance, less than {least:g}.")
        library = [e for e in library if e.family not in doubtful]
        verdict = select_model(model, prepared, library, checked, on_progress, criteria=criteria)
    return verdict


def as_given(experiment: VehicleOverSpeedExperiment, runs: Sequence[WeakFormRun]) -> Fit:
    """The vehicle with its given values, without a fit."""
    model = WeakFormModel(experiment)
    return fit(model, runs, model.start(), frozen=range(len(model.names)))


def limitations(runs: Sequence[WeakFormRun], criteria: Criteria) -> list[str]:
    """The limitations of a verdict by the weak form, in sentences."""
    return [*notes_of(runs), f"Equations are compared from {BAND[0]:g} to {BAND[1]:g} Hz in blocks of {BLOCK:g} s, "
                             "without offset and drift.",
            "The noise is estimated by the residuals of a flexible linear and nonlinear regression on the same runs: 1 "
            "means consistent with that regression, not with the noise of the sensors.",
            "Fitted values are biased by errors of the recorded states, and by feedback if disturbances instead of a "
            "recorded excitation cause much of the motion: linear effects that explain less than "
            f"{criteria.weak_form_linear_share:g} of the disturbance are therefore not named, and without an "
            "excitation the fitted entries are no physical constants."]  # fmt: skip
