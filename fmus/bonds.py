"""The power that a coupling makes or loses where units meet.

A torque T and the rates f that it works on are known twice: as one unit answered them and as the other was told
them. At the end of a step the power that one side takes and the other does not give is

    dP = T_told f - T f_told

Its sum over the steps is energy that the coupling has put into the motion. Source: Sadjina, Kyllingstad, Skjong,
Pedersen, Engineering with Computers 33 (2017) 607-620.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fmus.coupling import Network


@dataclass
class Bond:
    """One torque at one unit. power: the largest |dP| so far [W]; energy, exchanged: the sums of dP and of |T f| times the step [J]."""

    name: str
    torque: int  # among the inputs
    sources: list[int]  # of the torque, among the outputs
    rates: np.ndarray  # (ny, 2): which outputs sum to the rate, and which to the torque
    told_rates: np.ndarray  # (k, sources): the inputs that sum to the rate that each source was told
    power: float = 0.0
    energy: float = 0.0
    exchanged: float = 0.0

    @property
    def energy_error(self) -> float:
        """The energy that the coupling has made, as a share of what was exchanged: an estimate of its error."""
        return self.energy / self.exchanged if self.exchanged > 0 else 0.0

    def powers(self, outputs: np.ndarray, told: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """dP and T f [W] (n,) from the outputs (n, ny) after n steps and what the inputs (n, nu) were told for then."""
        rate, torque = (outputs @ self.rates).T
        given = told[:, self.torque] * rate
        excess = told[:, self.told_rates].sum(axis=1) - rate[:, None]
        return given - torque * rate - np.einsum("ns,ns->n", outputs[:, self.sources], excess), given

    def add(self, outputs: np.ndarray, told: np.ndarray, step: float) -> None:
        """Count n more steps."""
        lost, given = self.powers(outputs, told)
        self.power = max(self.power, float(np.abs(lost).max(initial=0.0)))
        self.energy += float(lost.sum() * step)
        self.exchanged += float(np.abs(given).sum() * step)


def bonds(network: Network, works_on: Mapping[str, Sequence[str]]) -> list[Bond]:
    """The bonds of a network; `works_on` gives for a torque the names of the rates that sum to the one it works on."""
    found = []
    for target, sources in network.wiring.items():
        unit, _, torque = target.partition(".")
        rates = [f"{unit}.{rate}" for rate in works_on.get(torque, ())]
        told = [[f"{source.partition('.')[0]}.{rate}" for rate in works_on.get(torque, ())] for source in sources]
        if rates and set(rates) <= set(network.outputs) and all(set(t) <= set(network.inputs) for t in told):
            summed = np.column_stack([np.isin(network.outputs, names) for names in (rates, sources)]).astype(float)
            told_rates = np.array([[network.inputs.index(name) for name in names] for names in told]).T
            found.append(Bond(target, network.inputs.index(target), [network.outputs.index(s) for s in sources], summed, told_rates))
    return found
