"""Possible next experiments on any component: the same excitation, larger or smaller."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from fmus.support.errors import InputError
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.experiment_design.discrimination import Prediction, predict_run
from motofmi.gap.experiment_design.next_experiment import Proposal
from motofmi.gap.preprocessing.sampled_run import SampledRun, excited

MAX_ITERATIONS = 60  # of a refit: one effect approximates another along a narrow valley of chi-square


@dataclass
class ScaledRun:
    """The excitation of an existing run times a factor."""

    experiment: str
    sentence: str
    settings: dict[str, float]
    run: SampledRun

    def predict(self, rival: Fit) -> Prediction:
        """The data that a fitted model predicts."""
        return predict_run(rival, replace(self.run, guess={}))

    def left(self, truth: Fit, rival: Fit, enough: float) -> float:
        """The delta chi-square of a rival refitted to its own runs and to the data that the assumed truth
        predicts for this one.

        The fit is ended early once the result certainly exceeds `enough`.
        """
        try:
            predicted, _ = truth.model.reduced(replace(self.run, guess={}), truth.shared)
            predicted_run = replace(self.run, data=predicted * self.run.deviation, guess={})
            runs, beat = [*rival.runs, predicted_run], rival.chi2 + enough
            again = fit(rival.model, runs, rival.x, iterations=MAX_ITERATIONS, beat=beat)
            return max(again.chi2 - rival.chi2, 0.0)
        except InputError:  # the planned run cannot be simulated
            return 0.0


def scaled_runs(found: Fit) -> Sequence[Proposal]:
    """The first run again at twice and at half the excitation; none where nothing drives it."""
    run: SampledRun = found.runs[0]
    if not excited([run]):
        return []
    excitation = "imposed motion" if run.experiment.imposed else "excitation"
    return [ScaledRun(name, f"Repeat the run at {factor:g} times the {excitation}: "
                            f"{why}", {"factor": factor}, run.scaled(factor))
            for name, factor, why in (("larger_excitation", 2.0, "effects that grow faster than the motion weigh "
                                                                 "more."),
                                      ("smaller_excitation", 0.5, "friction and play weigh more."))]  # fmt: skip
