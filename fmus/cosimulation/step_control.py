"""A step that follows the run: as long as the modes allow where the units are, and as the power residual allows.

After every segment two things are asked. Of the units linearised where they are: is the coupling's worst mode still
within the tolerance at this step, or at a longer one? And of the bonds: what share of the energy exchanged in the
segment has the coupling made? That share is an error of damping, so it may be ten times the tolerance; being of the
coupling's order p, the step is changed by the factor

    0.9 (10 tolerance / share)^(1 / p),   between a half and two

A step that has been made is not repeated. Source of the energy as the estimate and of the controller: Sadjina,
Kyllingstad, Skjong, Pedersen, Engineering with Computers 33 (2017) 607-620.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from fmus.bonds import Bond
from fmus.coupling import Coupling, Unit
from fmus.prediction import LONGEST, SHORTEST, linear_network, predict

SEGMENT = 50  # steps from one decision to the next
SAFETY, SLOWEST, FASTEST = 0.9, 0.5, 2.0
GROWTH = 10**0.1  # of the steps that are tried
WORTH = 1.05  # a smaller change is not worth new matrices


class StepControl:
    """The step [s] of the next segment in `step`; decides after every segment."""

    def __init__(self, chosen: Coupling, units: Mapping[str, Unit], wiring: Mapping[str, Sequence[str]], bonds: Sequence[Bond], step: float, tolerance: float):
        self.chosen, self.units, self.wiring, self.bonds, self.step, self.tolerance = chosen, units, wiring, bonds, step, tolerance
        self.smallest = self.largest = step
        self._before = self._sums()

    def _sums(self) -> np.ndarray:
        return np.array([[bond.energy, bond.exchanged] for bond in self.bonds]).reshape(-1, 2)

    @property
    def share(self) -> float:
        """The largest share of the exchanged energy that the coupling has made at a bond since the last decision."""
        made, exchanged = (self._sums() - self._before).T
        noticed = exchanged > 1e-9 * exchanged.max(initial=0.0)
        return float((np.abs(made[noticed]) / exchanged[noticed]).max(initial=0.0))

    def decide(self) -> bool:
        """Choose the next step. Whether it is another one."""
        factor = np.clip(SAFETY * (10 * self.tolerance / max(self.share, 1e-300)) ** (1 / self.chosen.order), SLOWEST, FASTEST)
        self._before = self._sums()
        wanted = float(min(max(self._allowed(min(self.step * factor, LONGEST)), SHORTEST), LONGEST))
        if max(wanted, self.step) / min(wanted, self.step) < WORTH:
            return False
        self.step = wanted
        self.smallest, self.largest = min(self.smallest, wanted), max(self.largest, wanted)
        return True

    def _allowed(self, step: float) -> float:
        """The step, or the next shorter one at which the modes are within the tolerance where the units are."""
        linear = linear_network(self.units, self.wiring)
        while step > SHORTEST and predict(self.chosen, linear, step).worst > self.tolerance:
            step /= GROWTH
        return step
