"""Power bonds: the power that a coupling adds or removes where subsystems are connected.

A torque T and the rates f that it works on are known twice: as outputs of one subsystem and as inputs of the other.
At the end of a step the residual power is

    dP = T_input f - T f_input

Its sum over the steps is energy that the coupling has added to the motion. Source: Sadjina, Kyllingstad, Skjong,
Pedersen, Engineering with Computers 33 (2017) 607-620.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fmus.cosimulation.network import Network


@dataclass
class PowerBond:
    """One torque at one subsystem. power: the largest |dP| so far [W]; energy, exchanged: the sums of dP and of |T f|
    times the step [J]."""

    name: str
    torque: int  # among the inputs
    sources: list[int]  # of the torque, among the outputs
    rates: np.ndarray  # (ny, 2): weights of the outputs that sum to the rate, and to the torque
    source_rates: np.ndarray  # (k, sources): the inputs that sum to the rate at each source
    power: float = 0.0
    energy: float = 0.0
    exchanged: float = 0.0

    @property
    def energy_error(self) -> float:
        """The energy that the coupling has added, as a fraction of the exchanged energy: an estimate of its error."""
        return self.energy / self.exchanged if self.exchanged > 0 else 0.0

    def powers(self, outputs: np.ndarray, inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """dP and T f [W] (n,) from the outputs (n, ny) and the inputs (n, nu) at the end of n steps."""
        rate, torque = (outputs @ self.rates).T
        given = inputs[:, self.torque] * rate
        excess = inputs[:, self.source_rates].sum(axis=1) - rate[:, None]
        return given - torque * rate - np.einsum("ns,ns->n", outputs[:, self.sources], excess), given

    def add(self, outputs: np.ndarray, inputs: np.ndarray, step: float) -> None:
        """Count n more steps."""
        lost, given = self.powers(outputs, inputs)
        self.power = max(self.power, float(np.abs(lost).max(initial=0.0)))
        self.energy += float(lost.sum() * step)
        self.exchanged += float(np.abs(given).sum() * step)


def power_bonds(network: Network, works_on: Mapping[str, Sequence[str]]) -> list[PowerBond]:
    """The power bonds of a network; `works_on` gives for a torque the names of the rates that sum to
    the one it works on."""
    found = []
    for target, sources in network.wiring.items():
        subsystem, _, torque = target.partition(".")
        rates = [f"{subsystem}.{rate}" for rate in works_on.get(torque, ())]
        rates_at_sources = [
            [f"{source.partition('.')[0]}.{rate}" for rate in works_on.get(torque, ())] for source in sources
        ]
        if (
            rates
            and set(rates) <= set(network.outputs)
            and all(set(t) <= set(network.inputs) for t in rates_at_sources)
        ):
            summed = np.column_stack([np.isin(network.outputs, names) for names in (rates, sources)]).astype(float)
            source_rates = np.array([[network.inputs.index(name) for name in names] for names in rates_at_sources]).T
            found.append(
                PowerBond(
                    target,
                    network.inputs.index(target),
                    [network.outputs.index(s) for s in sources],
                    summed,
                    source_rates,
                )
            )
    return found
