"""What runs that were held out say of a fit: whether it foretold them, and whether they refute what it was named for.

    missed      chi2 / data - 1                                                       everything frozen as fitted, but the runs' own deviations
    together    (chi2(fitted and held-out runs) - chi2(fitted runs)) / data - 1       the values moved within their errors

Frozen, a value that the fitted runs hardly tell is missed by its error alone. So what is missed refutes nothing that explains all
runs together, where the effect closes most of what the base misses, or where the held-out runs speak for it by themselves.
"""

from collections.abc import Sequence

import numpy as np

from fmus.errors import InputError
from identification.gap.models.model import AnyRun
from identification.gap.naming.fitting import Fit
from identification.gap.naming.showing import FORETOLD, Closeness, on_holdout, surprise

CLOSED = 0.85  # share of what the base misses that a family with an open form closes
CLOSED_OF_FLEXIBLE = 0.5  # the same where the noise is what a flexible model leaves, which no form of one law reaches
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
        self._seen: dict[int, tuple[Fit, Closeness | None]] = {}  # the fits are kept, so that their ids stay theirs
        self._together: dict[int, float] = {}

    def __bool__(self) -> bool:
        return bool(self.runs)

    def missed(self, found: Fit) -> float:
        """What a fit misses with its values frozen; infinite where it cannot be simulated."""
        seen = self._closeness(found)
        return np.inf if seen is None else seen.chi2 - 1

    def together(self, found: Fit) -> float:
        """What a fit misses once its values have moved within their errors; infinite where it cannot be simulated."""
        seen = self._closeness(found)
        if id(found) not in self._together:
            try:
                self._together[id(found)] = np.inf if seen is None else surprise(found, seen) - 1
            except InputError:
                self._together[id(found)] = np.inf
        return self._together[id(found)]

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

    def _closeness(self, found: Fit) -> Closeness | None:
        if id(found) not in self._seen:
            try:
                self._seen[id(found)] = found, on_holdout(found, self.runs)
            except InputError:
                self._seen[id(found)] = found, None
        return self._seen[id(found)][1]


def to_close(found: Fit, usual: float) -> float:
    """The share of the excess that a family with an open form must close."""
    flexible = any(getattr(run, "noise_source", "") == "flexible_model" for run in found.runs)
    return CLOSED_OF_FLEXIBLE if flexible else usual
