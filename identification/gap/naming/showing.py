"""The gap before and after: reduced chi-square on the fitted runs and on one that was not used, and the same in N.m.

On a held-out run the effects stay as fitted; only the base's deviations of that run are estimated again, under the
same tight prior, since a rider is never twice the same.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from fmus.errors import InputError
from identification.gap.models.model import AnyRun
from identification.gap.naming.fitted import Fit, deviating
from identification.gap.naming.fitting import fit

FORETOLD = 1.5  # reduced chi-square of a held-out run above which it was not foretold
ELSEWHERE = (0.0, 0.3, -0.3, 0.7, -0.7)  # of the deviation of a sensor's zero: from where it is estimated


@dataclass(frozen=True)
class Closeness:
    """How near a model is to runs: reduced chi-square, and the rms that is left on the harmonics, in the output's unit."""

    chi2: float
    rms: float
    fit: Fit


HeldOutGap = tuple[Closeness, Closeness] | None

def closeness(found: Fit) -> Closeness:
    """Of the runs that were fitted. The reduced chi-square is that of the data, with the priors' share."""
    return Closeness(found.reduced, _rms(found), found)


def on_holdout(found: Fit, runs: Sequence[AnyRun]) -> Closeness:
    """Of runs that were not used: effects and common values frozen, the runs' own deviations estimated."""
    shared = len(found.model.names)
    begun = np.concatenate([found.x[:shared], *(_deviations(found, run) for run in runs)])
    for run in runs:
        found.model.anew(run)
    again = fit(found.model, runs, begun, frozen=range(shared))
    # Each deviation is one number fitted and one prior: they cancel in the degrees of freedom.
    left = again.residuals[: again.count + len(deviating(found.model.stand)) * len(runs)]
    return Closeness(float(left @ left) / again.count, _rms(again), again)


def _deviations(found: Fit, run: AnyRun) -> np.ndarray:
    """From where the deviations of a run are estimated: a spring that stiffens has several answers, and leads astray from a zero that is far off."""
    places = deviating(found.model.stand)
    zeros = np.array([deviation if place >= len(found.model.base) else 0.0 for place, deviation in places.items()])
    if not zeros.any() or not found.model.effects:
        return np.zeros(len(places))
    shared, best = len(found.model.names), None
    for share in ELSEWHERE:
        with suppress(InputError):
            made = fit(found.model, [run], np.concatenate([found.x[:shared], share * zeros]), frozen=range(shared))
            best = made if best is None or made.chi2 < best.chi2 else best
            if best.reduced < FORETOLD:
                break
    return np.zeros(len(places)) if best is None else best.x[shared:]


def surprise(found: Fit, holdout: Closeness) -> float:
    """The reduced chi-square of held-out runs given what the fitted ones tell of the parameters, and no more than they do.

        (chi2(fitted and held out together) - chi2(fitted)) / data held out

    1 for the truth, however well its parameters are known; frozen values are beside it by their standard errors.
    """
    deviations = holdout.fit.x[len(found.model.names) :]
    together = fit(found.model, [*found.runs, *holdout.fit.runs], np.concatenate([found.x, deviations]))
    return (together.chi2 - found.chi2) / holdout.fit.count


def before_and_after(base: Fit, best: Fit, runs: Sequence[AnyRun]) -> HeldOutGap:
    """Of held-out runs, without and with what was found, with the noise that the best leaves of them; None without such runs."""
    if not runs:
        return None
    held = quiet(best, runs)
    return on_holdout(base, held), on_holdout(best, held)


def quiet(found: Fit, runs: Sequence[AnyRun]) -> list[AnyRun]:
    """Held-out runs with the noise that a model leaves of them: a sharp effect's highest orders are then not in it."""
    again = on_holdout(found, runs).fit
    return [found.model.with_noise_beside(run, again.of_run(i)) for i, run in enumerate(runs)]


def floor(runs: Sequence[AnyRun]) -> float:
    """The rms that noise alone leaves on the harmonics, in the output's unit."""
    power = sum(float(np.sum(r.deviation[: _shown(r)] ** 2)) for r in runs)
    return float(np.sqrt(power / sum(_samples(r) for r in runs)))


def _rms(found: Fit) -> float:
    power, first = 0.0, 0
    for run in found.runs:
        last = first + len(run.data)
        power += float(np.sum((found.residuals[first:last] * run.deviation)[: _shown(run)] ** 2))
        first = last
    return float(np.sqrt(power / sum(_samples(r) for r in found.runs)))


def _shown(run: Any) -> int:
    """The data of the first output, where a run says which these are: others have units of their own."""
    return len(run.effort.data) if hasattr(run, "effort") else len(run.data)


def _samples(run: Any) -> int:
    """The samples behind the data; without a recording the data themselves."""
    return sum(last - first for first, last, _ in run.reduction.bases) if hasattr(run, "reduction") else len(run.data)
