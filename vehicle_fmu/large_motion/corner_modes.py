r"""Modes in steady turning: devices at the handlebar port, and the names of straight running kept along the lean angle.

A device adds to the linear vehicle x' = A x + B u, y = C x with the motion y and the torques u of its port

    A + B D_d C,  B C_d;   B_d C,  A_d

of deviations from steady turning: a rider holds the trim with his muscles, and his springs are free of load there. At
lean 0 each mode has the eigenvalue that `vehicle_fmu.modes` names in straight running; over the lean angle it keeps
its branch. Forward speed is a state here, with a slow mode that has no name.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from fmus.declaration.component import Component
from fmus.expressions.functions import NUMERIC
from fmus.interfaces.handlebar import MOTION, TORQUES
from fmus.linear_analysis.eigenvalue_tracking import track_eigenvalues
from fmus.linear_analysis.linearisation import StateSpace, linearise
from fmus.support.errors import InputError
from vehicle_fmu.large_motion.equations import INPUTS, OUTPUTS
from vehicle_fmu.large_motion.steady_turning import SteadyTurning
from vehicle_fmu.mode_curves import ABSENT
from vehicle_fmu.named_modes import Mode, modes
from vehicle_fmu.ridden import over_speed, ridden

STEP = 2.5  # deg: largest distance of lean angles with matrices of their own; between them branches follow a spline


@dataclass(frozen=True)
class CornerModes:
    """Eigenvalues (n, nx) and named modes over lean angles (n,) [rad]."""

    eigenvalues: np.ndarray
    named: dict[str, Mode]


def check_devices(devices: Iterable[Component]) -> None:
    """Raises InputError for a device that does not act at the handlebar alone."""
    for device in devices:
        if not (set(device.inputs) <= set(MOTION) and set(TORQUES) <= set(device.outputs)):
            raise InputError(
                f"{device.name} acts at more than the handlebar port; in steady turning riders who turn their torso and "
                "steering dampers are possible, such as rider:mean_2011 or damper:7.5"
            )


def held(motorcycle: Component, devices: Sequence[Component]) -> Component:
    """The motorcycle with the inertia that a rider adds to its front frame."""
    added = [
        float(device.run(device.start_values(), NUMERIC)["port_inertia"])
        for device in devices
        if "port_inertia" in device.table
    ]
    return motorcycle.with_values(added_steer_inertia=added[0]) if added else motorcycle


def corner_modes(
    turning: SteadyTurning, motorcycle: Component, devices: Sequence[Component], leans: np.ndarray
) -> CornerModes:
    """The modes of a motorcycle with devices at lean angles (n,) [rad]; `turning` is that of the motorcycle as `held`.

    Raises InputError where a lean angle has no equilibrium.
    """
    straight = modes(over_speed(ridden(motorcycle, *devices)), np.array([turning.speed]))
    coupled = _Coupled(turning, [linearise(device) for device in devices])
    curves = {mode: np.full(len(leans), ABSENT) for mode in straight.unstable}
    spectra = np.full((len(leans), coupled.width), ABSENT)
    for side in (1, -1):
        rows = np.flatnonzero(leans >= 0 if side > 0 else leans < 0)
        if not len(rows):
            continue
        wanted = np.degrees(np.abs(leans[rows]))
        grid = np.unique(
            np.concatenate(
                [np.linspace(0.0, wanted.max() or STEP, 1 + max(1, int(np.ceil(wanted.max() / STEP)))), wanted]
            )
        )
        branches = track_eigenvalues(CubicSpline(grid, coupled.matrices(side * grid)), grid)
        spectra[rows] = branches.at(wanted)
        for mode, curve in curves.items():
            if not np.isnan(start := straight[mode].eigenvalue[0]):
                values = branches.at(wanted)[:, np.abs(branches.eigenvalues[0] - start).argmin()]
                curve[rows] = values.real + 1j * np.abs(values.imag)
    return CornerModes(spectra, {mode: Mode(curve) for mode, curve in curves.items()})


class _Coupled:
    """The matrices of a motorcycle with linear devices over the lean angle."""

    def __init__(self, turning: SteadyTurning, parts: Sequence[StateSpace]):
        self.turning, self.parts = turning, parts
        self.width = len(turning.motion.states) + sum(len(part.states) for part in parts)

    def matrices(self, degrees: np.ndarray) -> np.ndarray:
        """(n, nx, nx) at lean angles (n,) [deg]."""
        return np.array([self._matrix(lean) for lean in np.radians(degrees)])

    def _matrix(self, lean: float) -> np.ndarray:
        A, B, C, _ = self.turning.linearised(self.turning.at(lean))
        first, torques = len(A), [INPUTS.index(name) for name in TORQUES]
        whole = np.zeros((self.width, self.width))
        whole[:first, :first] = A
        own = slice(0, first)
        for part in self.parts:
            out, motion = (
                [part.outputs.index(name) for name in TORQUES],
                C[[OUTPUTS.index(name) for name in part.inputs]],
            )
            its = slice(first, first := first + len(part.states))
            whole[own, own] += B[:, torques] @ part.D[out] @ motion
            whole[own, its], whole[its, own], whole[its, its] = B[:, torques] @ part.C[out], part.B @ motion, part.A
        return whole
