"""Model selection by chi-square where the noise is not known: in rounds, each with the noise of the result before.

Without other information the noise is what a flexible model leaves of the residuals of the best fit (see
`flexible_noise_model`). A better fit leaves less noise, so the selection is repeated until the noise changes little, or
nothing is named since the best model is not adequate.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress

import numpy as np

from fmus.effects import Effect
from fmus.support.errors import InputError
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import adequate
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.stages import Stage, running
from motofmi.gap.preprocessing.sampled_run import SampledRun
from motofmi.gap.selection.candidate_search import search_candidates
from motofmi.gap.selection.model_selection import select_model
from motofmi.gap.selection.result import Verdict

MOST_ROUNDS = 3  # rounds of model selection, each with the noise of the previous result
NOISE_CHANGE = 0.1  # mean relative change of the noise's standard deviation below which there is no further round

OnProgress = Callable[[Verdict], None]


def select_in_rounds(
    base: Fit,
    library: Sequence[type[Effect]],
    validation_runs: Sequence[SampledRun],
    on_progress: OnProgress,
    criteria: Criteria,
    known: Sequence[Fit] = (),
    consistent: Fit | None = None,
) -> Verdict:
    """The verdict of model selection, repeated with the noise of its result until the noise changes little, or the best
    model is not adequate.

    known are fits of effects that are starts of the search, the most promising last. The first noise is that which
    `consistent` leaves, a fit whose residuals are consistent with noise; without it, or where it cannot be simulated
    again, that of the best single effect.
    """
    verdict, known = Verdict("unknown", base, base, criteria=criteria), list(known)
    with running(Stage.NOISE):
        again = _again_left_by(consistent) if consistent else None
        prepared = again or with_noise_of_best_effect(base, library, known, criteria)
    for round_ in range(MOST_ROUNDS):
        checked = with_noise_of(prepared[0], validation_runs)
        # Intermediate verdicts of a later round contain less than the final verdict of the round before.
        report = on_progress if round_ == 0 else _report_nothing
        try:
            verdict = select_model(base.model, prepared, library, checked, report, known, criteria)
        except InputError as error:  # with less noise the last best fit may not be simulated: its verdict remains
            verdict = verdict if round_ else verdict.as_unknown(f"No effect is named: {error}.")
            break
        on_progress(verdict)
        known.append(verdict.best)
        before, prepared = prepared, list(verdict.best.runs)
        # The noise only decreases from round to round, so that an inadequate model remains so.
        remains = verdict.verdict == "unknown" and not adequate(verdict.best, criteria)
        if remains or _change(before, prepared) < NOISE_CHANGE:
            break
    return verdict


def _report_nothing(verdict: Verdict) -> None:
    """For callers that need no intermediate verdicts."""


def with_noise_of(fitted: SampledRun, validation_runs: Sequence[SampledRun]) -> list[SampledRun]:
    """Validation runs with the noise and the input interpolation of a fitted run."""
    return [
        run.with_interpolation(fitted.kind).with_densities(fitted.densities, fitted.noise_source)
        for run in validation_runs
    ]


def with_noise_of_best_effect(
    base: Fit, library: Sequence[type[Effect]], known: list[Fit], criteria: Criteria = Criteria()
) -> list[SampledRun]:
    """The runs with the noise estimated from the best single effect; the residuals of a poor base are not noise.

    If that fit cannot be simulated again the next best one is used, at last the base. All fits are added to `known`.
    """
    for candidate in search_candidates(base, library, known=known, criteria=criteria):
        with suppress(InputError):
            return candidate.fit.runs_with_remaining_noise()
    return base.runs_with_remaining_noise()


def _again_left_by(found: Fit) -> list[SampledRun] | None:
    """The runs with the noise that a fit leaves; None where it cannot be simulated again, as that of a chaotic motion."""
    with suppress(InputError):
        return found.runs_with_remaining_noise()
    return None


def _change(before: Sequence[SampledRun], after: Sequence[SampledRun]) -> float:
    """The mean relative change of the noise's standard deviation over all coefficients, the largest of all runs."""
    return max(float(np.mean(np.abs(np.log(b.deviation / a.deviation)))) for a, b in zip(before, after, strict=True))
