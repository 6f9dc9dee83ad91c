"""Mode shapes of a vehicle over its speed, and what takes part in a mode: roll, steer, a torso, further states.

Further states are those of a device or an effect besides a torso, and those of freedoms of a vehicle besides lateral
motion, yaw, roll and steer: twist of a frame, lean.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fmus.linear_analysis.eigenvalue_tracking import Branches
from fmus.linear_analysis.linearisation import StateSpace

PLANE = ("lateral", "yaw", "roll", "steer", "front", "rear")  # what states of a vehicle's plane motion and tyres begin with

Linearised = Callable[[np.ndarray], StateSpace]  # speeds (n,) -> stacked state spaces
Columns = tuple[int, ...]  # the branches of a mode: a pair, or real roots


@dataclass(frozen=True)
class ModeShapes:
    """Mode shapes (n, nx) over speeds and eigenvalues; zeros for signals that a vehicle lacks.

    column is the branch of each eigenvalue. tyres is |Y_r / Y_f|, together is
    Re(theta delta*) / (|theta|^2 + |delta|^2), from -1/2 (torso against bar) to 1/2 (with it).
    """

    states: tuple[str, ...]
    eigenvalues: np.ndarray
    right: np.ndarray
    column: np.ndarray
    tyres: np.ndarray
    together: np.ndarray

    @classmethod
    def at(cls, speeds: np.ndarray, linearised: Linearised, branches: Branches) -> "ModeShapes":
        """The mode shapes at speeds of the grid of the branches."""
        return cls.of(linearised(speeds), branches.at(speeds))

    @classmethod
    def of(cls, space: StateSpace, spectra: np.ndarray) -> "ModeShapes":
        """The mode shapes of stacked state spaces, whose eigenvalues (n, nx) by branch are `spectra`."""
        eigenvalues, right = np.linalg.eig(space.A)
        rows = {n.split(".")[-1]: i for i, n in enumerate(space.outputs)}
        amplitudes = space.C @ right

        def signal(output: str) -> np.ndarray:
            return amplitudes[:, rows[output]] if output in rows else np.zeros_like(eigenvalues)

        moves = np.abs(eigenvalues[:, :, None] - spectra[:, None, :])
        torso, steer = signal("torso_angle"), signal("steer_angle")
        return cls(space.states, eigenvalues, right, moves.argmin(axis=2),
                   _ratio(np.abs(signal("rear_side_force")), np.abs(signal("front_side_force"))),
                   _ratio((torso * steer.conj()).real, np.abs(torso) ** 2 + np.abs(steer) ** 2))  # fmt: skip

    def upper(self, k: int) -> list[int]:
        """The indices of the eigenvalues with positive imaginary part at speed k."""
        return np.flatnonzero(self.eigenvalues[k].imag > 0).tolist()

    def pair(self, k: int, i: int) -> Columns:
        """The branches of the pair to which eigenvalue i belongs at speed k;

        LAPACK returns pairs in adjacent positions.
        """
        return int(self.column[k, i]), int(self.column[k, i + 1])

    def part(self, k: int, motion: str) -> np.ndarray:
        """The participation factors of a motion's states (`steer`, `roll`, `torso`) in the modes at speed k, from 0
        to 1.
        """
        part = self.participations[k]
        own = [i for i, n in enumerate(self.states) if n.split(".")[-1].startswith(motion)]
        return part[own].sum(axis=0) / part.sum(axis=0)

    def foreign_participation(self, k: int) -> np.ndarray:
        """The participation of further states in the modes at speed k, from 0 to 1."""
        return self.foreign_participations[k]

    @cached_property
    def foreign_participations(self) -> np.ndarray:
        """`foreign_participation` (n, nx) at all speeds."""
        foreign = [further != "" for further in further_states(self.states)]
        if not any(foreign):
            return np.zeros(self.eigenvalues.shape)
        return self.participations[:, foreign].sum(axis=1) / self.participations.sum(axis=1)

    @cached_property
    def participations(self) -> np.ndarray:
        """The magnitudes of the participation factors (n, nx, nx): of each state in each mode."""
        return np.abs(np.linalg.inv(self.right).swapaxes(1, 2) * self.right)


def _ratio(above: np.ndarray, below: np.ndarray) -> np.ndarray:
    return np.divide(above, below, out=np.zeros(above.shape), where=below > 0)


def further_states(states: tuple[str, ...]) -> list[str]:
    """What each state is besides the plane motion: `vehicle`, `device`, or empty for those of the plane motion."""
    places = [n.rpartition(".")[::2] for n in states]
    owner = next((place for place, n in places if n.startswith("steer")), None)

    def kind(place: str, name: str) -> str:
        if owner is None or name.startswith("torso") or (place == owner and name.startswith(PLANE)):
            return ""
        return "vehicle" if place == owner else "device"

    return [kind(*each) for each in places]
