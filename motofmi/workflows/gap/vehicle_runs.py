"""The common part of the kinds of experiment with recorded runs of a vehicle."""

from collections.abc import Sequence
from typing import Any

from motofmi.gap.alternatives import with_errors
from motofmi.gap.estimation.fit_result import parameters_of
from motofmi.gap.experiments.vehicle_over_speed import VehicleOverSpeedExperiment
from motofmi.gap.selection.result import Verdict
from motofmi.recordings.recording import Recording
from motofmi.reports.report import Table
from motofmi.workflows.gap.augmented_vehicle import fitted_device, fitted_of, fitted_vehicle
from motofmi.workflows.gap.fitted_model import FittedModel
from motofmi.workflows.gap.given import Given
from motofmi.workflows.gap.kind import Kind
from motofmi.workflows.gap.vehicle import not_applicable

UNVALIDATED = (
    "No validation run, or none that could be predicted: the verdict is not checked on data that were not used."
)


class OnVehicle(Kind):
    """A vehicle with recorded speed and at least one recorded output.

    left_out are sentences on effects and validation runs that are not used; the search adds to them.
    """

    title = "The gap between vehicle and recorded runs"
    place = "equation or output"

    @classmethod
    def suits(cls, given: Given) -> bool:
        return given.vehicle is not None and not given.holds_eigenvalues

    def __init__(self, given: Given) -> None:
        self.given, self.vehicle, self.device = given, given.base_vehicle, given.base_device
        self.left_out = not_applicable(self.vehicle, given.own_effects)
        quantities = self.quantities(given)
        self.recordings = given.runs("recordings", quantities), given.runs("validation", quantities)

    @staticmethod
    def quantities(given: Given) -> dict[str, str]:
        """The units of the vehicle's variables."""
        return {"time": "s"} | {n: row.unit for n, row in given.base_vehicle.rows("input", "state", "output").items()}

    @classmethod
    def recorded(cls, given: Given) -> list[Recording]:
        """All recordings, those for validation among them."""
        quantities = cls.quantities(given)
        return [*given.runs("recordings", quantities), *given.runs("validation", quantities)]

    def unused(self, contents: dict[str, Any]) -> list[str]:
        """What was left out, and the limitation that applies if no validation run was compared."""
        unvalidated = [UNVALIDATED] if contents["gap"]["holdout_after"] is None else []
        return [*dict.fromkeys(self.left_out), *unvalidated]

    def model(self, verdict: Verdict) -> FittedModel:
        source = f"Fitted to {', '.join(r.name for r in self.recordings[0])}"
        return fitted_vehicle(self.vehicle, verdict.best, source, self.given.effects_folder, self.given.own_effects)

    def found_device(self, verdict: Verdict) -> FittedModel | None:
        return fitted_device(verdict.best, f"Fitted to {', '.join(r.name for r in self.recordings[0])}")

    def fitted_parameters(self, verdict: Verdict) -> list[Table]:
        rows = [(n, f"{v:.5g}", f"{e:.2g}", u) for n, (v, e, u) in fitted_of(verdict.best).items()]
        return [Table(("parameter", "value", "standard error", "unit"), rows)]


def with_matrix_entries(
    contents: dict[str, Any], verdict: Verdict, experiment: VehicleOverSpeedExperiment
) -> dict[str, Any]:
    """The contents with the fitted entries of given matrices added to `base`."""
    fitted = parameters_of(verdict.best)
    contents["base"] |= with_errors({n: fitted[n] for n in experiment.unrestricted})
    return contents


def notes_of(runs: Sequence[Any]) -> list[str]:
    """Notes from preparing the runs, and warnings from reading their recordings."""
    return [note for r in runs for note in (*r.notes, *r.recording.warnings)]
