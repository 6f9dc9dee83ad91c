"""Conditions on a verdict by chi-square on sampled runs: whether it is final, and where nothing is named after all.

Models that leave only noise are selected by chi-square; otherwise, and where such a verdict is not final, they are
compared on blocks of their residuals (see `any_component`).
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fmus.effects import Effect
from fmus.support.errors import InputError
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import adequate, has_determined_magnitudes
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.preprocessing.sampled_run import SampledRun
from motofmi.gap.selection.noise_rounds import with_noise_of
from motofmi.gap.selection.remainder import explained
from motofmi.gap.selection.result import Verdict
from motofmi.gap.validation.before_after import on_validation_runs
from motofmi.recordings.resampling import sensor_noise

# Factor on the estimate of white noise [1]: that estimate uses differences of adjacent samples and is too small for
# sensors with a low-pass filter.
WHITE_NOISE_FACTOR = 1.5
SUFFICIENT = (
    "{} would reduce chi-square, but the base is consistent with the noise, and misses {:.2%} of the motion (rms), "
    "which is within the tolerance of {:.2%}."
)

WITHIN_TOLERANCE = (
    "The base misses at most {:.2%} of the motion (rms) in each of the runs, which is within the tolerance of {:.2%}."
)


def decisive(verdict: Verdict, single: Fit, simulated: bool, criteria: Criteria) -> bool:
    """Whether the verdict by chi-square is final: its form is specified, the magnitudes of the named effects are
    determined, no validation run is far from the noise, no law outside the library explains more, and the best single
    effect was a candidate.

    An effect that the verdict does not contain was none where nothing is named, or where it could not be simulated over
    the segments of the search by chi-square, which are longer (`simulated` is whether it could). Otherwise the models
    are compared on blocks.
    """
    gap = verdict.validation_gap
    left_out = not _families(single) <= _families(verdict.best)
    if left_out and (verdict.verdict == "unknown" or not simulated):
        return False
    if finds_a_law_outside(verdict):  # the comparison states the law with its value and share
        return False
    near_noise = gap is None or gap[1].chi2 < criteria.far_from_noise
    determined = verdict.verdict != "named" or has_determined_magnitudes(verdict.best, criteria)
    return not verdict.unspecified_form and near_noise and determined


def finds_a_law_outside(verdict: Verdict) -> bool:
    """Whether nothing is named since an effect outside the library explains more."""
    return verdict.verdict == "unknown" and verdict.outside_library is not None


def _families(found: Fit) -> set[str]:
    """The families of a fit's effects."""
    return {effect.family for effect in found.model.effects}


def leaves_noise(found: Fit, validation_runs: Sequence[SampledRun], criteria: Criteria) -> bool:
    """Whether the residuals of a fit are consistent with the noise that a flexible model estimates from them.

    On validation runs the reduced chi-square must also be below `Criteria.far_from_noise`.
    """
    try:
        runs = found.runs_with_remaining_noise()
        if not adequate(fit(found.model, runs, found.x, iterations=0), criteria):
            return False
        checked = with_noise_of(runs[0], validation_runs)
        return not checked or on_validation_runs(found, checked, criteria).chi2 < criteria.far_from_noise
    except InputError:
        return False


def unless_doubtful(
    verdict: Verdict, library: Sequence[type[Effect]], validation_runs: Sequence[SampledRun], criteria: Criteria
) -> Verdict:
    """The verdict by chi-square; `unknown` where the named effect may stand for another one.

    It may where the residuals are far from the noise and no validation run confirms it, and where its form is
    unspecified in a family with a single form: such a family is an additional body, which reduces most kinds of misfit.
    """
    if verdict.verdict != "named":
        return verdict
    name, far = verdict.effects[0].family, criteria.far_from_noise
    if verdict.best.reduced > far and not validation_runs:
        return verdict.as_unknown(
            f"{name} is not named: what it leaves is far from the noise "
            f"(reduced chi-square {verdict.best.reduced:.3g}, limit {far:g}), and no validation run confirms it; "
            "give one with --holdout."
        )
    if verdict.unspecified_form and sum(effect.family == name for effect in library) == 1:
        gap = verdict.validation_gap
        on_validation = f", {gap[1].chi2:.3g} on validation runs" if gap else ""
        return verdict.as_unknown(
            f"{name} is not named: it is not adequate (reduced chi-square {verdict.best.reduced:.3g}{on_validation}), "
            "and as an effect with a single form it reduces most kinds of misfit."
        )
    return verdict


def unless_sufficient(verdict: Verdict) -> Verdict:
    """The verdict by chi-square where the noise follows from the result; `none` where the base misses less of the motion
    than `Criteria.tolerance`, and is consistent with that noise, so that an effect explains a part of the noise, or
    where nothing is named."""
    criteria, base, gap = verdict.criteria, verdict.base, verdict.validation_gap
    named = verdict.verdict in ("named", "tied")
    if verdict.verdict == "none" or (named and not adequate(base, criteria)):
        return verdict
    fits = [base] if named or gap is None else [base, gap[0].fit]
    missed = max(map(missed_share, fits))
    if missed > criteria.tolerance:
        return verdict
    said = (missed, criteria.tolerance)
    return replace(
        verdict.as_unknown(SUFFICIENT.format(verdict.names, *said) if named else WITHIN_TOLERANCE.format(*said)),
        verdict="none",
        best=base,
        validation_gap=gap and (gap[0], gap[0]),
        outside_library=None,
    )


def unless_unclear(verdict: Verdict) -> Verdict:
    """The verdict by chi-square where the noise follows from the result; `unknown` where the validation runs do not
    show the gain: the 95 % interval of the closed share of their closable misfit contains zero."""
    share = explained(verdict) if verdict.verdict in ("named", "tied") else None
    if share is None or share["low"] > 0:
        return verdict
    return verdict.as_unknown(
        f"No effect is named: the gain of {verdict.names} on the validation runs is not clear ({share['share']:.1%} of "
        f"the closable misfit, 95 % interval from {share['low']:.1%})."
    )


def missed_share(found: Fit) -> float:
    """The rms of the misfit of an output in the band that is compared, without white noise, over the rms of the output
    about its mean in each segment [1]; the largest of all."""
    shares = []
    ends = np.cumsum([len(run.data) for run in found.runs])
    for run, residuals in zip(found.runs, np.split(found.residuals[: ends[-1]], ends[:-1]), strict=True):
        samples = sum(last - first for first, last, _ in run.reduction.spans)
        for output, y in enumerate(run.measured.T):
            own = run.reduction.output_of == output
            noise = np.sum(own) * (WHITE_NOISE_FACTOR * sensor_noise(y)) ** 2
            power = np.sum((residuals[own] * run.deviation[own]) ** 2) - noise
            shares.append(np.sqrt(max(power, 0.0) / samples / run.motion_variance[output]))
    return float(max(shares))
