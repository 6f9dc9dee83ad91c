r"""Whether the runs disagree on the base: its values fitted to the validation runs alone, instead of an effect.

    base, values a in fitted and b in validation runs   against   base and effects, the same values in all runs

Runs of another machine, load, temperature or unit have other values of the base, and an effect may stand for the
difference. The runs disagree where the base with values of its own in the validation runs leaves there clearly less
than the effects with their fitted values, and closes more than `Criteria.explained_share` of what these leave. Its
losses are those of left-out blocks.

The fitted runs decide as well, since a base without an effect that is missing takes other values in each run. The runs
do not disagree where the effects close `Criteria.explained_share` of the closable misfit of the validation runs with
their fitted values, and leave clearly less in the fitted runs than the base with values of its own in each of them.

Source: Chow, Econometrica 28 (1960) 591-605, who compares sums of squares in the same way.
"""

from contextlib import suppress
from dataclasses import replace

import numpy as np

from fmus.support.deadline import time_is_up
from fmus.support.errors import InputError
from motofmi.gap.comparison.block_losses import left_out_mean_squares
from motofmi.gap.comparison.closable import closed_share, log_gain_low, low_of_mean
from motofmi.gap.comparison.compared_model import CommonBlocks, ComparedModel
from motofmi.gap.comparison.residuals import time_residuals
from motofmi.gap.comparison.sandwich import sandwich_covariance
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.frequency_domain_fit import frequency_domain_start


def disagreement(base: ComparedModel, best: ComparedModel, flexible: float, blocks: CommonBlocks) -> str:
    """The sentence on the value of the base on which fitted and validation runs disagree; empty where they do not, or
    where it is no better explanation than the effects of `best`.

    flexible [1] is the mean square after a flexible regression, over the squared scale of the comparison.
    """
    if not blocks.validation_blocks:
        return ""
    # Where effects leave more than the base does, values of its own leave less than they do without any disagreement.
    best = min((best, base), key=lambda model: float(model.validation.mean()))
    own = with_own_values(base, best, flexible, blocks)
    if own is None or log_gain_low(best, own) <= 0:
        return ""
    if closed_share(best.validation, own.validation, flexible).share <= blocks.criteria.explained_share:
        return ""
    predicted = closed_share(base.validation, best.validation, flexible).share >= blocks.criteria.explained_share
    if predicted and best is not base and _needed_in_fitted_runs(best, base, blocks):
        return ""
    share = closed_share(base.validation, own.validation, flexible).share
    effects = " and ".join(effect.family for effect in best.effects) or "it does"
    return (
        "No effect is named: the fitted and the validation runs disagree on the base. With values of its own in the "
        f"validation runs it closes {share:.1%} of the closable misfit, clearly more than {effects} with the fitted "
        f"values. {_difference(base, own, blocks)} {_amplitudes(base, blocks)}"
    )


def with_own_values(
    base: ComparedModel, best: ComparedModel, flexible: float, blocks: CommonBlocks
) -> ComparedModel | None:
    """The base fitted to the validation runs alone; None where they cannot be simulated, and after a deadline.

    A fit that cannot close as much of what `best` leaves as runs that disagree need is ended early.

    It starts from the fitted values and, where these are too far, as for a machine with another frequency, from those
    that fit the validation runs in the frequency domain.
    """
    if time_is_up():
        return None
    left = max(float(best.validation.mean()) - flexible, 0.0)
    least = (flexible + (1 - blocks.criteria.explained_share) * left) / float(base.validation.mean())
    try:
        before = fit(base.fit.model, blocks.validation, base.fit.shared, iterations=0)
        enough = min(least, 1.0) * before.chi2
        found = fit(base.fit.model, before.runs, before.x, beat=enough)
        if found.chi2 > enough and (start := _by_frequency(base, blocks)) is not None:
            with suppress(InputError):  # it cannot be simulated from there
                other = fit(base.fit.model, blocks.validation, start, beat=enough)
                found = min(found, other, key=lambda each: each.chi2)
        validation = left_out_mean_squares(time_residuals(found, blocks.scale), blocks.validation_blocks)
    except (InputError, ValueError, np.linalg.LinAlgError):
        return None
    return replace(base, fit=found, validation=validation)


def _needed_in_fitted_runs(best: ComparedModel, base: ComparedModel, blocks: CommonBlocks) -> bool:
    """Whether `best` leaves clearly less in the fitted runs than the base with values of its own in each of them."""
    runs, squares = base.fit.runs, [base.fitted]
    if len(runs) > 1:
        squares = []
        for index, run in enumerate(runs):
            of_run = [(0, first, last) for i, first, last in blocks.blocks if i == index]
            try:
                own = fit(base.fit.model, [run], base.fit.shared)
                squares.append(left_out_mean_squares(time_residuals(own, blocks.scale), of_run))
            except (InputError, ValueError, np.linalg.LinAlgError):  # the run cannot be simulated alone
                return False
    return low_of_mean(np.log(np.concatenate(squares) + base.floor) - best.fitted_losses) > 0


def _by_frequency(base: ComparedModel, blocks: CommonBlocks) -> np.ndarray | None:
    """The fitted values (parameters,) with those of the base that fit the validation runs in the frequency domain; None
    where there are none."""
    logarithms = frequency_domain_start(base.fit.model, blocks.validation)
    return None if logarithms is None else np.concatenate([logarithms, base.fit.shared[len(logarithms) :]])


def _amplitudes(base: ComparedModel, blocks: CommonBlocks) -> str:
    """The advice on the runs, with the rms about the mean of every input and output in fitted and validation runs."""
    run = base.fit.runs[0]
    names = [*run.experiment.outputs, *run.experiment.inputs]
    sides = [
        {n: float(np.sqrt(np.mean([each.recording[n].var() for each in runs]))) for n in names}
        for runs in (base.fit.runs, blocks.validation)
    ]
    rms = ", ".join(f"{sides[0][n]:.3g} and {sides[1][n]:.3g} {run.recording.units[n]} ({n})" for n in names)
    return (
        f"The rms of the columns in the fitted and in the validation runs is {rms}. Give runs of one machine in one "
        "condition, with correct units; where only their amplitude differs, fit runs of both amplitudes."
    )


def _difference(base: ComparedModel, own: ComparedModel, blocks: CommonBlocks) -> str:
    """The sentence on the value of the base that differs by most standard errors."""
    model, count = base.fit.model, len(base.fit.model.base)
    of_validation = sandwich_covariance(time_residuals(own.fit, blocks.scale), blocks.validation_blocks)
    variances = [np.diag(v)[:count] for v in (blocks.covariance(base.fit), of_validation)]
    change = np.abs(own.fit.x[:count] - base.fit.x[:count])
    k = int(np.argmax(change / np.sqrt(np.maximum(sum(variances), 1e-300))))
    name, unit = model.base[k], model.component.table[model.base[k]].unit
    fitted, validation = (
        f"{value:.4g} +- {abs(value) * np.sqrt(max(variance[k], 0.0)):.2g} {unit}"
        for value, variance in zip(
            (model.values(each.fit.shared)[name] for each in (base, own)), variances, strict=True
        )
    )
    return f"{name} is {fitted} in the fitted runs and {validation} in the validation runs."
