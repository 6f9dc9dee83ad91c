"""What a verdict explains and what it leaves: `complete`, `explained` and `remainder` of `verdict.json`.

Which effect is missing and what is left are two questions. `explained` is the share of the closable misfit on
validation runs that the verdict's model closes, with its 95 % interval; where the noise is known the closable misfit is
what exceeds it. `remainder` is what the model leaves, in the unit of the output and as a share of the motion.
"""

from typing import Any

import numpy as np

from motofmi.gap.comparison.closable import INTERVAL, share_of_closable
from motofmi.gap.comparison.confidence_set import RESAMPLES, SEED
from motofmi.gap.estimation.candidate import adequate
from motofmi.gap.selection.model_selection import Verdict
from motofmi.gap.validation.before_after import misfit_of, motion_rms

PIECES = 20  # of the residuals of validation runs, resampled for the interval


def complete(verdict: Verdict) -> bool:
    """Whether the verdict's model leaves nothing but noise, on the fitted and on the validation runs."""
    if verdict.verdict not in ("named", "none") or not adequate(verdict.best, verdict.criteria):
        return False
    seen = verdict.validation_gap
    return seen is None or seen[1].chi2 < verdict.criteria.predicted_reduced_chi2


def explained(verdict: Verdict) -> dict[str, float] | None:
    """Share, low and high of the closable misfit on validation runs; None where nothing is added to the base, or
    without validation runs."""
    if verdict.comparison is not None:
        found = verdict.comparison.outcome.share
        return None if found is None else {"share": found.share, "low": found.low, "high": found.high}
    if verdict.validation_gap is None or verdict.best is verdict.base or not verdict.best.model.effects:
        return None
    before, after = (_pieces(misfit.fit.residuals[: misfit.fit.count]) for misfit in verdict.validation_gap)
    chosen = np.random.default_rng(SEED).integers(0, len(before), (RESAMPLES, len(before)))
    shares = share_of_closable(before[chosen].mean(axis=1), after[chosen].mean(axis=1), 1.0)
    low, high = np.percentile(shares, INTERVAL)
    return {"share": float(share_of_closable(before.mean(), after.mean(), 1.0)), "low": float(low), "high": float(high)}


def remainder(verdict: Verdict, unit: str) -> dict[str, Any]:
    """rms in the unit of the output, its share of the motion's rms, and what comes nearest to the remainder.

    On validation runs where there are any, else on the fitted ones. nearest is the effect of the library that an
    unknown verdict would need first.
    """
    seen = verdict.validation_gap[1] if verdict.validation_gap else misfit_of(verdict.best)
    motion = motion_rms(seen.fit.runs)
    named = {c.family for c in verdict.effects}
    nearest = next((c.family for c in (*verdict.tied, *verdict.candidates) if c.family not in named), None)
    wanted = verdict.verdict == "unknown" or (verdict.verdict == "named" and not complete(verdict))
    return {
        "rms": seen.rms,
        "share": seen.rms / motion if motion > 0 else None,
        "unit": unit,
        "nearest": nearest if wanted else None,
    }


def _pieces(residuals: np.ndarray) -> np.ndarray:
    """The mean squares (pieces,) of consecutive pieces of residuals (n,)."""
    return np.array([np.mean(piece**2) for piece in np.array_split(residuals, min(PIECES, len(residuals)))])
