"""Adaptive step: limited by the predicted errors of the modes and by the residual energy of the power bonds.

After every segment the subsystems are linearised at their present states, and the step is limited to one at which the
coupling's largest mode error is within the tolerance. The power bonds give the share of the exchanged energy that the
coupling has added in the segment. This share is an error of damping and may be ten times the tolerance. It is of the
coupling's order p, so the step is multiplied by

    0.9 (10 tolerance / share)^(1 / p),   between a half and two

Steps are not repeated. Source of the energy as an error estimate and of the controller: Sadjina,
Kyllingstad, Skjong, Pedersen, Engineering with Computers 33 (2017) 607-620.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from fmus.cosimulation.coupling import Coupling
from fmus.cosimulation.coupling_error import GROWTH, LONGEST, SHORTEST, linear_network, predict
from fmus.cosimulation.power_bonds import PowerBond
from fmus.cosimulation.subsystems.subsystem import Subsystem

SEGMENT = 50  # steps from one decision to the next
SAFETY, SLOWEST, FASTEST = 0.9, 0.5, 2.0
WORTH = 1.05  # ratio; a smaller change does not justify new matrices


class StepControl:
    """The step [s] of the next segment in `step`; decides after every segment."""

    def __init__(
        self,
        chosen: Coupling,
        subsystems: Mapping[str, Subsystem],
        wiring: Mapping[str, Sequence[str]],
        power_bonds: Sequence[PowerBond],
        step: float,
        tolerance: float,
    ):
        self.chosen, self.subsystems, self.wiring, self.power_bonds, self.step, self.tolerance = (
            chosen,
            subsystems,
            wiring,
            power_bonds,
            step,
            tolerance,
        )
        self.smallest = self.largest = step
        self._before = self._sums()

    def _sums(self) -> np.ndarray:
        return np.array([[bond.energy, bond.exchanged] for bond in self.power_bonds]).reshape(-1, 2)

    @property
    def share(self) -> float:
        """The largest share of the exchanged energy that the coupling has added at a bond since the last decision."""
        made, exchanged = (self._sums() - self._before).T
        noticed = exchanged > 1e-9 * exchanged.max(initial=0.0)
        return float((np.abs(made[noticed]) / exchanged[noticed]).max(initial=0.0))

    def decide(self) -> bool:
        """Choose the next step; returns whether it has changed."""
        factor = np.clip(
            SAFETY * (10 * self.tolerance / max(self.share, 1e-300)) ** (1 / self.chosen.order), SLOWEST, FASTEST
        )
        self._before = self._sums()
        wanted = float(min(max(self._allowed(min(self.step * factor, LONGEST)), SHORTEST), LONGEST))
        if max(wanted, self.step) / min(wanted, self.step) < WORTH:
            return False
        self.step = wanted
        self.smallest, self.largest = min(self.smallest, wanted), max(self.largest, wanted)
        return True

    def _allowed(self, step: float) -> float:
        """The step, or the next shorter one at which the modes are within the tolerance at the present states."""
        linear = linear_network(self.subsystems, self.wiring)
        while step > SHORTEST and predict(self.chosen, linear, step).worst > self.tolerance:
            step /= GROWTH
        return step
