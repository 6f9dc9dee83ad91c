"""What runs that were held out say of a fit: whether it foretold them, and whether they refute what it was named for.

    missed      chi2 / data - 1                                                       everything frozen as fitted, but the runs' own deviations
    together    (chi2(fitted and held-out runs) - chi2(fitted runs)) / data - 1       the values moved within their errors

Frozen, a value that the fitted runs hardly tell is missed by its error alone. So what is missed refutes nothing that explains all
runs together, where the effect closes most of what the base misses, or where the held-out runs speak for it by themselves.
"""

from collections.abc import Sequence
from contextlib import suppress
from functools import cache

import numpy as np

from fmus.errors import InputError
from identification.gap.models.model import AnyRun
from identification.gap.naming.candidate import knows_its_noise
from identification.gap.naming.fitted import Fit
from identification.gap.naming.showing import FORETOLD, Closeness, on_holdout, surprise

CLOSED = 0.85  # share of what the base misses that a family with an open form closes
CLOSED_OF_FLEXIBLE = 0.5  # the same where the noise is what a flexible model leaves
MISSED = 0.2  # reduced chi-square above 1 by which a held-out run refutes a name, beyond a share of what the base misses
SHARE_MISSED = 0.005  # that share
SCATTER = 4.5  # standard deviations of a reduced chi-square, as for fitted runs
SURPRISED = 3.0  # the same where the values may move by their errors
SPEAKS = 40.0  # chi-square by which held-out runs speak for an effect


class HeldOut:
    """Runs that were not used to fit. What they leave of a fit is worked out once."""

    def __init__(self, runs: Sequence[AnyRun]):
        self.runs = list(runs)
        self.count = sum(len(run.data) for run in self.runs)
        self._seen, self.together = cache(self._closeness), cache(self._together)

    def __bool__(self) -> bool:
        return bool(self.runs)

    def missed(self, found: Fit) -> float:
        """What a fit misses with its values frozen; infinite where it cannot be simulated."""
        seen = self._seen(found)
        return np.inf if seen is None else seen.chi2 - 1

    def foretold(self, base: Fit) -> bool:
        """Whether a base explains them, be it with other values than fitted, within their errors."""
        return self.missed(base) < FORETOLD - 1 or self.together(base) < FORETOLD - 1

    def unexplained(self, found: Fit) -> float:
        """What a fit misses, whichever way is kinder to it."""
        missed = self.missed(found)
        return missed if missed < MISSED else min(missed, self.together(found))

    def refute(self, base: Fit, found: Fit, open_form: bool = False) -> bool:
        """Whether they are missed by more than noise, and by more than a name, or a family with an open form, may leave of what the base misses."""
        before, after, noise = self.missed(base), self.missed(found), float(np.sqrt(2 / self.count))  # few data scatter by more
        share = 1 - to_close(found, CLOSED) if open_form else SHARE_MISSED
        if after <= max(share * before if np.isfinite(before) else 0.0, MISSED, SCATTER * noise):
            return False
        if after >= before or self.together(found) > max(share * self.together(base) if open_form else 0.0, SURPRISED * noise):
            return True
        return after >= (1 - CLOSED) * before and not self.speak_for(base, found)

    def speak_for(self, base: Fit, found: Fit) -> bool:
        """Whether they are evidence for an effect beside that of the fitted runs."""
        return (self.together(base) - self.together(found)) * self.count > SPEAKS

    def _together(self, found: Fit) -> float:
        """What a fit misses once its values have moved within their errors; infinite where it cannot be simulated."""
        with suppress(InputError):
            if seen := self._seen(found):
                return surprise(found, seen) - 1
        return np.inf

    def _closeness(self, found: Fit) -> Closeness | None:
        with suppress(InputError):
            return on_holdout(found, self.runs)
        return None


def to_close(found: Fit, usual: float) -> float:
    """The share of the excess that a family with an open form must close."""
    return usual if knows_its_noise(found) else CLOSED_OF_FLEXIBLE
