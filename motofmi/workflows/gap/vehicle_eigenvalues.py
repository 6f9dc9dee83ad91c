"""The gap of a vehicle from eigenvalues measured over its speed."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from fmus.declaration.component import Component
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.experiments.vehicle_over_speed import VehicleOverSpeedExperiment
from motofmi.gap.localisation.eigenvalue_places import cells
from motofmi.gap.preprocessing.eigenvalues import MeasuredEigenvalues
from motofmi.gap.selection.eigenvalues import select_model_for_eigenvalues
from motofmi.gap.selection.result import Verdict
from motofmi.gap.verdict import as_result
from motofmi.reports.gap_report import Pictures
from motofmi.reports.gap_tables import modes_over_speed
from motofmi.reports.gap_vehicle import eigenvalues_of, eigenvalues_over_speed
from motofmi.reports.report import Section
from motofmi.workflows.gap.augmented_vehicle import effect_on_modes, fitted_device, fitted_vehicle, vehicle_of
from motofmi.workflows.gap.fitted_model import FittedModel
from motofmi.workflows.gap.given import Given
from motofmi.workflows.gap.kind import Kind
from motofmi.workflows.gap.vehicle import (
    NONLINEAR,
    not_applicable,
    vehicle_effects,
    vehicle_experiment,
    with_mode_names,
)

SPEEDS = 60  # number of speeds at which the eigenvalues of rivals are compared


class VehicleEigenvalues(Kind):
    """A vehicle with tables of eigenvalues over speed and their standard errors."""

    title = "The gap between vehicle and measured eigenvalues"
    place = "mode and part"

    @classmethod
    def suits(cls, given: Given) -> bool:
        return given.vehicle is not None and given.holds_eigenvalues

    def __init__(self, given: Given) -> None:
        self.given, self.vehicle, self.device = given, given.base_vehicle, given.base_device
        self.experiment = vehicle_experiment(self.vehicle, self.device, given.free)
        self.left_out = not_applicable(self.vehicle, given.own_effects)
        self.measured, self.validation = (
            [with_mode_names(each, self.experiment) for each in given.spectra(use)]
            for use in ("recordings", "validation")
        )

    def verdict(self, on_progress: Callable[[Verdict], None]) -> Verdict:
        library = vehicle_effects(self.vehicle, self.given.own_effects, linear=True)
        return select_model_for_eigenvalues(
            self.experiment, self.measured, library, self.validation, on_progress, self.given.criteria
        )

    def contents(self, verdict: Verdict) -> dict[str, Any]:
        return as_result(verdict, "1/s", "given", cells)

    def limitations(self, verdict: Verdict, contents: dict[str, Any]) -> list[str]:
        return [*limitations(self.vehicle, self.measured, self.validation), *self.left_out]

    def next_experiment(self, verdict: Verdict) -> dict[str, Any] | None:
        return next_measurement(verdict, self.experiment)

    def model(self, verdict: Verdict) -> FittedModel:
        source = f"Fitted to {', '.join(r.name for r in self.measured)}"
        return fitted_vehicle(self.vehicle, verdict.best, source, self.given.effects_folder, self.given.own_effects)

    def found_device(self, verdict: Verdict) -> FittedModel | None:
        return fitted_device(verdict.best, f"Fitted to {', '.join(r.name for r in self.measured)}")

    def modes(self, verdict: Verdict, model: Component) -> dict[str, Any] | None:
        if verdict.verdict != "named":
            return None
        speeds = np.unique(np.concatenate([r.over for r in self.measured]))
        return effect_on_modes(vehicle_of(self.vehicle, verdict.base), model, self.device, speeds)

    def modes_section(self, contents: dict[str, Any]) -> Section:
        return modes_over_speed(contents)

    def pictures(self, verdict: Verdict) -> Pictures:
        models = "the base, the base with the effects found" if verdict.best.model.effects else "the base"
        caption = f"Measured eigenvalues with their standard errors, {models}, and the differences."
        validation = f"Validation, not fitted: {', '.join(r.name for r in self.validation) or 'none'}."
        return Pictures([], [(eigenvalues_over_speed(verdict), caption)], validation)


def limitations(
    vehicle: Component, measured: Sequence[MeasuredEigenvalues], validation: Sequence[MeasuredEigenvalues]
) -> list[str]:
    """The limitations of a verdict on eigenvalues, in sentences."""
    sentences = ["The verdict depends on the standard errors in the file; errors that several rows have in common are "
                 "not taken into account.",
                 f"Effects without eigenvalues ({', '.join(NONLINEAR)}) are not identifiable from eigenvalues; they "
                 "change measured ones like a damper."]  # fmt: skip
    if not vehicle.standard_error:
        sentences.append(
            f"{vehicle.name} gives no standard errors: its masses and lengths are assumed to have standard errors of "
            "1 %, inertias, tyre and damper parameters of 5 %."
        )
    if any(not m for r in measured for m in r.mode):
        sentences.append("Eigenvalues without a mode's name were matched with the nearest computed one.")
    if not validation:
        sentences.append("No eigenvalues for validation: the verdict is not checked on data that were not used.")
    return sentences


def next_measurement(verdict: Verdict, experiment: VehicleOverSpeedExperiment) -> dict[str, Any] | None:
    """The speed at which the rivals' eigenvalues differ most, with the expected delta chi-square of one measurement.

        (difference of the real parts / their standard error)^2 + (difference of the imaginary parts / theirs)^2

    Imaginary parts of a mode that does not oscillate in the data have no error, and are not compared. None if there are
    no rivals. Rivals are the tied effects, or the base for a weakly named effect.
    """
    rivals: list[Fit] = [c.fit for c in verdict.tied]
    if verdict.verdict == "named" and verdict.effects[0].delta_bic < verdict.criteria.weak_name_delta_bic:
        rivals = [verdict.best, verdict.base]
    if len(rivals) < 2:
        return None
    run = verdict.base.runs[0]
    top = experiment.component.table[experiment.over].max
    proposals = []
    for mode in dict.fromkeys(run.mode):
        rows = [i for i, m in enumerate(run.mode) if m == mode]
        first, last = run.over[rows].min(), run.over[rows].max()
        speeds = np.linspace(first, min(1.2 * last, top), SPEEDS)
        real_error, imag_error = _errors(run, rows)
        followed = [_followed(f, speeds, run.over[rows[0]], run.value[rows[0]]) for f in rivals]
        differences = [a - b for i, a in enumerate(followed) for b in followed[i + 1 :]]
        apart = np.min([(d.real / real_error) ** 2 + (d.imag / imag_error) ** 2 for d in differences], axis=0)
        best = int(apart.argmax())
        of_imag = f" of the real and {imag_error:.2g} 1/s of the imaginary part" if np.isfinite(imag_error) else ""
        proposals.append({"experiment": "speed", "sentence": f"Measure {mode or 'the mode'} at {speeds[best]:.3g} m/s, "
                                                             f"with a standard error of {real_error:.2g} 1/s{of_imag} "
                                                             "as before.",
                          "speed": float(speeds[best]), "mode": mode,
                          "expected_delta_chi2": float(apart[best])})  # fmt: skip
    return max(proposals, key=lambda p: p["expected_delta_chi2"]) | {"alternatives": proposals}


def _errors(run: MeasuredEigenvalues, rows: Sequence[int]) -> tuple[float, float]:
    """The usual standard errors [1/s] of the real and the imaginary part in rows; that of an imaginary part that was
    not measured is infinite."""
    oscillating = [i for i in rows if run.oscillates[i]]
    imag_error = float(np.median(run.imag_error[oscillating])) if oscillating else np.inf
    return float(np.median(run.real_error[rows])), imag_error


def _followed(found: Fit, speeds: np.ndarray, start: float, value: complex) -> np.ndarray:
    """An eigenvalue (n,) [1/s] of a fit over speeds (n,) [m/s], followed by continuity from the one nearest to
    `value`."""
    spectra = eigenvalues_of(found, np.append(start, speeds))
    followed, last = [], value
    for spectrum in spectra:
        upper = spectrum[spectrum.imag >= 0]
        last = upper[np.abs(upper - last).argmin()]
        followed.append(last)
    return np.array(followed[1:])
