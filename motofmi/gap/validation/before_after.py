"""The misfit before and after: reduced chi-square and rms, on fitted runs and on validation runs.

On a validation run effects and common parameters are fixed as fitted. Only the deviations of the base in that run are
estimated, under the same prior, since a rider changes from run to run.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from fmus.effects import Effect
from fmus.support.deadline import time_is_up
from fmus.support.errors import InputError
from fmus.support.parallel import in_turn
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.fit_result import (
    Fit,
    PortableFit,
    initial_guesses,
    run_to_run_deviations,
    with_initial_guesses,
)
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.models.any_model import AnyRun

OFFSET_STARTS = (0.0, 0.3, -0.3, 0.7, -0.7)  # starts of a sensor offset over its standard deviation
SAME = 1e-3  # relative difference of chi-square within which two starts have reached the same minimum


@dataclass(frozen=True)
class Misfit:
    """The misfit of a model on runs: reduced chi-square, and rms of the residuals in the unit of the output."""

    chi2: float
    rms: float
    fit: Fit


ValidationGap = tuple[Misfit, Misfit] | None  # before and after; None without validation runs


def misfit_of(found: Fit) -> Misfit:
    """The misfit on the fitted runs. The reduced chi-square includes the priors."""
    return Misfit(found.reduced, _rms(found), found)


def on_validation_runs(
    found: Fit, runs: Sequence[AnyRun], criteria: Criteria = Criteria(), known: Fit | None = None
) -> Misfit:
    """The misfit on validation runs: effects and common parameters fixed, the deviations of these runs estimated.

    known is a fit of the same model on these runs with another noise. It is continued where it can be simulated again,
    since the search for initial states takes most of the time.
    """
    if known is not None:
        with suppress(InputError):
            return _from(found, runs, _begins_of(known, runs))
    return _from(found, runs, [_begun(found, run, criteria) for run in runs])


def _from(found: Fit, runs: Sequence[AnyRun], begun: Sequence[tuple[np.ndarray, AnyRun]]) -> Misfit:
    """The misfit on validation runs from starting values of their deviations and from initial guesses."""
    shared = len(found.model.names)
    for run in runs:
        found.model.start_afresh(run)
    start = np.concatenate([found.x[:shared], *(deviations for deviations, _ in begun)])
    again = fit(found.model, [run for _, run in begun], start, frozen=range(shared))
    # Each deviation is one fitted number and one prior, which cancel in the degrees of freedom.
    left = again.residuals[: again.count + len(run_to_run_deviations(found.model.experiment)) * len(runs)]
    return Misfit(float(left @ left) / again.count, _rms(again), again)


def _begins_of(known: Fit, runs: Sequence[AnyRun]) -> list[tuple[np.ndarray, AnyRun]]:
    """The deviations of each run in a fit, and the run with the initial guesses of that fit."""
    deviations = np.split(known.x[len(known.model.names) :], len(runs))
    return list(zip(deviations, with_initial_guesses(runs, initial_guesses(known.runs)), strict=True))


def _begun(found: Fit, run: AnyRun, criteria: Criteria) -> tuple[np.ndarray, AnyRun]:
    """Starting values of a run's deviations, and the run with the initial guesses that were found with them.

    With a hardening spring, or the limit of a signal, a large sensor offset gives several minima; with laws of the rate
    alone there is one. Parameters are fixed, so that the best fit of a run alone is that of all runs together: it is
    continued, since its search for initial states takes most of the time.
    """
    places = run_to_run_deviations(found.model.experiment)
    offsets = np.array([deviation if place >= len(found.model.base) else 0.0 for place, deviation in places.items()])
    if not offsets.any() or all(_reads_rate_alone(effect) for effect in found.model.effects):
        return np.zeros(len(places)), run
    shared, best = len(found.model.names), None

    def fit_from(share: float) -> PortableFit | None:
        with suppress(InputError):
            x = np.concatenate([found.x[:shared], share * offsets])
            return PortableFit.of(fit(found.model, [run], x, frozen=range(shared)))
        return None

    for portable in in_turn([partial(fit_from, share) for share in OFFSET_STARTS]):
        if portable is not None:
            made = portable.on(found.model, [run])
            again = best is not None and abs(made.chi2 - best.chi2) < SAME * best.chi2
            best = made if best is None or made.chi2 < best.chi2 else best
            if best.reduced < criteria.predicted_reduced_chi2 or again or time_is_up():
                break
    return (np.zeros(len(places)), run) if best is None else (best.x[shared:], best.runs[0])


def _reads_rate_alone(effect: type[Effect]) -> bool:
    """Whether the terms of an effect depend on a rate, and not on a deflection."""
    read = effect.reads()
    return "rate" in read and "deflection" not in read


def reduced_chi2_after_refit(found: Fit, validation: Misfit) -> float:
    """The reduced chi-square of validation runs with the parameters free within their errors from the fitted runs.

        (chi2(fitted and validation runs together) - chi2(fitted runs)) / data of the validation runs

    It is 1 for the true model, whatever its standard errors are. With fixed values it is larger, since these differ
    from the truth by their standard errors.
    """
    deviations = validation.fit.x[len(found.model.names) :]
    together = fit(found.model, [*found.runs, *validation.fit.runs], np.concatenate([found.x, deviations]))
    return (together.chi2 - found.chi2) / validation.fit.count


def before_and_after(
    base: Fit,
    best: Fit,
    runs: Sequence[AnyRun],
    criteria: Criteria = Criteria(),
    known: tuple[Fit | None, Fit | None] = (None, None),
) -> ValidationGap:
    """The misfit on validation runs of base and best, with the noise that the best leaves, which excludes high orders
    that an effect excites; None without such runs.

    known are fits of base and best on these runs, where there are some.
    """
    if not runs:
        return None
    of_base, of_best = known
    of_best = on_validation_runs(best, runs, criteria, of_best).fit
    scaled = of_best.runs_with_remaining_noise()
    return on_validation_runs(base, scaled, criteria, of_base), on_validation_runs(best, scaled, criteria, of_best)


def floor(runs: Sequence[AnyRun]) -> float:
    """The rms of the noise in the data of the first output, in its unit."""
    return _rms_of_first_output(runs, [run.deviation for run in runs])


def motion_rms(runs: Sequence[AnyRun]) -> float:
    """The rms of the first output in the runs, about its mean in each segment where the runs hold samples."""
    variances = [run.motion_variance[0] for run in runs if hasattr(run, "motion_variance")]
    if variances:
        return float(np.sqrt(np.mean(variances)))
    return _rms_of_first_output(runs, [run.data for run in runs])


def _rms(found: Fit) -> float:
    ends = np.cumsum([len(run.data) for run in found.runs])[:-1]
    residuals = np.split(found.residuals[: found.count], ends)
    return _rms_of_first_output(found.runs, [r * run.deviation for r, run in zip(residuals, found.runs, strict=True)])


def _rms_of_first_output(runs: Sequence[Any], data: Sequence[np.ndarray]) -> float:
    """The rms of the first output over the samples of runs, from data (m,) of each; other outputs have other units."""
    power, samples = 0.0, 0
    for run, values in zip(runs, data, strict=True):
        if hasattr(run, "effort"):
            first, bases = np.arange(len(values)) < len(run.effort.data), run.reduction.bases
        elif hasattr(run, "reduction"):
            first, bases = run.reduction.output_of == 0, run.reduction.spans
        else:
            first, bases = np.ones(len(values), bool), [(0, len(values), None)]
        power += float(np.sum(values[first] ** 2))
        samples += sum(end - begin for begin, end, _ in bases)
    return float(np.sqrt(power / samples))
