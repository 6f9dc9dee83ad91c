"""What an effect gains over a fit, and which of several is the best.

    dchi2 = chi2(fit) - chi2(fit + effect)        dBIC = dchi2 - k ln n - 2 u     (u unknowns of single runs: initial states)
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from fmus.effects import Effect
from identification.gap.naming.fitted import Fit
from identification.gap.naming.screening import Signature

SIGNIFICANT = 12.0  # dBIC of a first effect
TIE = 10.0  # dBIC within which effects cannot be told apart
CLEAR = 40.0  # dBIC by which a family without an adequate form must lead
ADEQUATE = 1.12  # reduced chi-square, at 1400 degrees of freedom and more
BY_CHANCE = 2.5  # standard deviations of chi-square


@dataclass(frozen=True)
class Candidate:
    """An effect on top of the effects found so far: fitted, or with what the screening promises, and then `fit` lacks it."""

    effect: type[Effect]
    fit: Fit
    delta_chi2: float
    delta_bic: float

    @classmethod
    def promised(cls, found: Fit, signature: Signature) -> "Candidate":
        """What the screening says, for an effect that is not worth a fit."""
        return cls(signature.effect, found, max(signature.gain, 0.0), signature.gain - len(signature.start) * np.log(found.count))

    @classmethod
    def gained(cls, found: Fit, effect: type[Effect], fitted: Fit) -> "Candidate":
        """What an effect gains over a fit."""
        gain = found.chi2 - fitted.chi2
        return cls(effect, fitted, gain, gain - (fitted.price - found.price))

    @property
    def family(self) -> str:
        return self.effect.family

    @property
    def fitted(self) -> bool:
        return self.effect in self.fit.model.effects


def adequate(found: Fit) -> bool:
    """Whether noise alone explains what is left."""
    return found.reduced < reduced_by_noise(found)


def reduced_by_noise(found: Fit) -> float:
    """The largest reduced chi-square that noise alone gives."""
    return max(ADEQUATE, 1 + 4.5 * float(np.sqrt(2 / found.freedom)))


def by_chance(freedom: float) -> float:
    """By how much chi-square is beside its mean by chance alone."""
    return float(BY_CHANCE * np.sqrt(2 * freedom))


def knows_its_noise(found: Fit) -> bool:
    """Whether the noise is more than what a flexible model leaves, which no form of one law reaches."""
    return all(getattr(run, "noise_source", "") != "flexible_model" for run in found.runs)


def ranked(candidates: Iterable[Candidate]) -> list[Candidate]:
    """Fitted ones first, then by what they gain."""
    return sorted(candidates, key=lambda c: (not c.fitted, -c.delta_bic))


def best_of(candidates: Sequence[Candidate]) -> Candidate | None:
    """The best that was fitted; among plain forms of its family that are as good, the one with the fewest parameters."""
    fitted = [c for c in candidates if c.fitted]
    if not fitted:
        return None
    best = fitted[0]
    plain = [c for c in fitted if c.family == best.family and not c.effect.flexible and best.delta_bic - c.delta_bic < TIE]
    return min(plain, key=lambda c: len(c.effect.sought()), default=best)


def one_each(candidates: Sequence[Candidate]) -> list[Candidate]:
    """The best of every family, in order."""
    seen: dict[str, Candidate] = {}
    for c in candidates:
        seen.setdefault(c.family, c)
    return list(seen.values())
