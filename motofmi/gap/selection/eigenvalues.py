"""Model selection on measured eigenvalues.

The effects of a linearised component have only the forms of the library. So a family without an adequate form is
`unknown`, and not named with an unspecified form as where forces may be any function.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

from fmus.effects import Effect
from motofmi.gap.criteria import Criteria
from motofmi.gap.experiments.vehicle_over_speed import VehicleOverSpeedExperiment
from motofmi.gap.models.eigenvalue_model import EigenvalueModel
from motofmi.gap.preprocessing.eigenvalues import MeasuredEigenvalues
from motofmi.gap.selection.model_selection import Verdict, select_model


def select_model_for_eigenvalues(experiment: VehicleOverSpeedExperiment, runs: Sequence[MeasuredEigenvalues], library: Sequence[type[Effect]], validation: Sequence[MeasuredEigenvalues] = (),
                          so_far: Callable[[Verdict], None] = lambda verdict: None, criteria: Criteria = Criteria()) -> Verdict:  # fmt: skip
    """The verdict on measured eigenvalues, with the effects of a library; validation ones can only reject a name.

    so_far is called with an intermediate verdict at every stage.
    """
    verdict = select_model(EigenvalueModel(experiment), runs, library, validation, so_far, criteria=criteria)
    return (
        replace(verdict, verdict="unknown", effects=[], unspecified_form=False) if verdict.unspecified_form else verdict
    )
