"""Model selection on measured eigenvalues.

In a linearised component an effect is linear, so that it has no form beyond those of the library. Therefore a family
without an adequate form is not named with an unspecified form; the verdict is `unknown`.
"""

from collections.abc import Callable, Sequence

from fmus.effects import Effect
from motofmi.gap.criteria import Criteria
from motofmi.gap.experiments.vehicle_over_speed import VehicleOverSpeedExperiment
from motofmi.gap.models.eigenvalue_model import EigenvalueModel
from motofmi.gap.preprocessing.eigenvalues import MeasuredEigenvalues
from motofmi.gap.selection.model_selection import select_model
from motofmi.gap.selection.result import Verdict

NO_FORM = (
    "{} is not named: no form of it in the library is consistent with the errors of the eigenvalues, and of a linear "
    "system there is no other form."
)


def select_model_for_eigenvalues(
    experiment: VehicleOverSpeedExperiment,
    runs: Sequence[MeasuredEigenvalues],
    library: Sequence[type[Effect]],
    validation: Sequence[MeasuredEigenvalues] = (),
    on_progress: Callable[[Verdict], None] = lambda verdict: None,
    criteria: Criteria = Criteria(),
) -> Verdict:
    """The verdict on measured eigenvalues, with the effects of a library.

    Validation eigenvalues can only reject an effect. on_progress is called with an intermediate verdict at every stage.
    Raises InputError where the base cannot be fitted.
    """
    verdict = select_model(EigenvalueModel(experiment), runs, library, validation, on_progress, criteria=criteria)
    return verdict.as_unknown(NO_FORM.format(verdict.names)) if verdict.unspecified_form else verdict
