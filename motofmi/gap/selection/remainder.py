"""The misfit that a verdict explains and that remains: `complete`, `explained`, `remainder` of verdict.json.

`explained` is the share of the closable misfit on validation runs that the verdict's model closes, with its 95 %
interval; where the noise is known, the closable misfit is the part that exceeds the noise. `remainder` is the rms of
the model's residuals, in the unit of the output and as a share of the measured rms.
"""

from dataclasses import asdict
from typing import Any

import numpy as np

from motofmi.gap.comparison.closable import closed_share
from motofmi.gap.comparison.residuals import whitened_residuals
from motofmi.gap.estimation.candidate import adequate
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.preprocessing.sampled_run import SampledRun
from motofmi.gap.selection.result import Verdict
from motofmi.gap.validation.before_after import misfit_of, motion_rms

PIECES = 20  # consecutive pieces of equal length of the residuals of validation runs, for the bootstrap


def complete(verdict: Verdict) -> bool:
    """Whether the residuals of the verdict's model are consistent with noise on fitted and on validation runs."""
    if verdict.verdict not in ("named", "none") or not adequate(verdict.best, verdict.criteria):
        return False
    gap = verdict.validation_gap
    return gap is None or gap[1].chi2 < verdict.criteria.predicted_reduced_chi2


def explained(verdict: Verdict) -> dict[str, float] | None:
    """The share [1] of the closable misfit on validation runs that is closed, and the ends of its 95 % interval.

    The keys are `share`, `low` and `high`. None where nothing is added to the base, or without validation runs.
    """
    if verdict.comparison is not None:
        found = verdict.comparison.outcome.share
        return None if found is None else asdict(found)
    if verdict.validation_gap is None or verdict.best is verdict.base or not verdict.best.model.effects:
        return None
    before, after = (_mean_squares(misfit.fit) for misfit in verdict.validation_gap)
    return asdict(closed_share(before, after, 1.0))  # residuals are over the noise, which has a mean square of 1


def remainder(verdict: Verdict, unit: str) -> dict[str, Any]:
    """The rms of the residuals in the unit of the output, its share of the measured rms [1], and the nearest effect.

    The residuals are those of validation runs where there are any, else of the fitted ones. nearest is the family of
    the best effect that is not named, None where the verdict is complete.
    """
    misfit = verdict.validation_gap[1] if verdict.validation_gap else misfit_of(verdict.best)
    motion = motion_rms(misfit.fit.runs)
    named = {c.family for c in verdict.effects}
    nearest = next((c.family for c in (*verdict.tied, *verdict.candidates) if c.family not in named), None)
    incomplete = verdict.verdict == "unknown" or (verdict.verdict == "named" and not complete(verdict))
    return {
        "rms": misfit.rms,
        "share": misfit.rms / motion if motion > 0 else None,
        "unit": unit,
        "nearest": nearest if incomplete else None,
    }


def _mean_squares(found: Fit) -> np.ndarray:
    """The mean squares (pieces,) of the residuals over the noise, on consecutive pieces in time."""
    if all(isinstance(run, SampledRun) for run in found.runs):
        residuals = np.concatenate(whitened_residuals(found))
    else:
        residuals = found.residuals[: found.count]  # windows or blocks one after another, for every output
    return np.array([np.mean(piece**2) for piece in np.array_split(residuals, min(PIECES, len(residuals)))])
