r"""Modes in steady turning: devices at the handlebar port, and the names of straight running kept along the lean angle.

A device adds to the linear vehicle x' = A x + B u, y = C x with the motion y and the torques u of its port

    A + B D_d C,  B C_d;   B_d C,  A_d

of deviations from steady turning: a rider holds the trim with his muscles, and his springs are free of load there. At
lean 0 motion out of the plane is apart, and its modes have the names of the nearest eigenvalues (linear sum assignment)
that `vehicle_fmu.modes` names in straight running; those in the plane are named by `plane_modes`. Each mode keeps its
branch over the lean angle, and from there over the longitudinal acceleration. Without acceleration forward speed is a
state, with a slow mode that has no name; with one it is held (frozen).
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.interpolate import CubicSpline

from fmus.declaration.component import Component
from fmus.expressions.functions import NUMERIC
from fmus.interfaces.handlebar import MOTION, TORQUES
from fmus.linear_analysis.eigenvalue_tracking import Branches, matches, track_eigenvalues
from fmus.linear_analysis.linearisation import StateSpace, linearise
from fmus.support.errors import InputError
from vehicle_fmu.large_motion.applied_forces import INPUTS
from vehicle_fmu.large_motion.equations import OUTPUTS
from vehicle_fmu.large_motion.plane_modes import in_plane, plane_modes
from vehicle_fmu.large_motion.steady_turning import SteadyTurning
from vehicle_fmu.mode_curves import ABSENT
from vehicle_fmu.named_modes import Mode, modes
from vehicle_fmu.ridden import over_speed, ridden

# Largest distances of lean angles [deg] and accelerations [m/s2] with matrices of their own; between them branches
# follow a spline.
STEP, ACCELERATION_STEP = 2.5, 0.5


@dataclass(frozen=True)
class CornerModes:
    """Eigenvalues (n, nx) and named modes over points (n,)."""

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
    turning: SteadyTurning,
    motorcycle: Component,
    devices: Sequence[Component],
    leans: np.ndarray,
    accelerations: np.ndarray | None = None,
) -> CornerModes:
    """The modes of a motorcycle with devices at lean angles (n,) [rad] and longitudinal accelerations (n,) [m/s2], 0
    unless given; `turning` is that of the motorcycle as `held`.

    Raises InputError where a point has no equilibrium.
    """
    pushed = np.zeros(len(leans)) if accelerations is None else accelerations
    coupled = _Coupled(turning, [linearise(device) for device in devices], bool(pushed.any()))
    start = _named_upright(coupled, motorcycle, devices)
    spectra = np.full((len(leans), coupled.width), ABSENT)
    curves = {mode: np.full(len(leans), ABSENT) for mode in start}
    for side in (1, -1):
        rows = np.flatnonzero(leans >= 0 if side > 0 else leans < 0)
        if not len(rows):
            continue
        degrees = np.degrees(np.abs(leans[rows]))
        branches = _branches(partial(coupled.over_lean, side), degrees, STEP)
        own = {mode: int(np.abs(branches.eigenvalues[0] - value).argmin()) for mode, value in start.items()}
        for lean in np.unique(degrees):
            those = rows[degrees == lean]
            found = _over_acceleration(coupled, side * lean, pushed[those], branches.at(np.array([lean]))[0])
            spectra[those] = found
            for mode, branch in own.items():
                curves[mode][those] = found[:, branch].real + 1j * np.abs(found[:, branch].imag)
    return CornerModes(spectra, {mode: Mode(curve) for mode, curve in curves.items()})


def _named_upright(coupled: "_Coupled", motorcycle: Component, devices: Sequence[Component]) -> dict[str, complex]:
    """The eigenvalue of each mode upright, with Im >= 0, by name."""
    from scipy.optimize import linear_sum_assignment  # noqa: PLC0415 - imported on use: it takes 0.5 s

    turning, matrix = coupled.turning, coupled.over_lean(1, np.zeros(1))[0]
    plane = np.append(in_plane(coupled.own_states), np.zeros(coupled.width - len(coupled.own_states), bool))
    straight = modes(over_speed(ridden(motorcycle, *devices)), np.array([turning.speed]))
    named = {name: value for name in straight.unstable if not np.isnan(value := straight[name].eigenvalue[0])}
    values = np.linalg.eigvals(matrix[np.ix_(~plane, ~plane)])
    values = values[values.imag >= 0]
    _, nearest = linear_sum_assignment(np.abs(np.array(list(named.values()))[:, None] - values))
    out_of_plane = dict(zip(named, values[nearest].tolist(), strict=True))
    return out_of_plane | plane_modes(turning.motion, matrix, turning.known[0].found, coupled.own_states)


def _branches(matrices: Callable[[np.ndarray], np.ndarray], wanted: np.ndarray, step: float) -> Branches:
    """The eigenvalues from 0 on over a grid with wanted values (m,) >= 0."""
    last = wanted.max()
    if last == 0:
        return Branches(np.zeros(1), np.linalg.eigvals(matrices(np.zeros(1))).astype(complex))
    even = np.linspace(0.0, last, 1 + max(1, int(np.ceil(last / step))))
    grid = np.unique(np.concatenate([even, wanted]))
    return track_eigenvalues(CubicSpline(grid, matrices(grid)), grid)


def _over_acceleration(coupled: "_Coupled", degrees: float, wanted: np.ndarray, start: np.ndarray) -> np.ndarray:
    """The eigenvalues (m, nx) at a lean angle [deg] and accelerations (m,), by the branches of those at rest (nx,)."""
    found = np.tile(start, (len(wanted), 1))
    for side in (1, -1):
        if not (rows := np.flatnonzero(side * wanted > 0)).size:
            continue
        branches = _branches(partial(coupled.over_acceleration, degrees, side), side * wanted[rows], ACCELERATION_STEP)
        order, _ = matches(start[None], branches.eigenvalues[:1])
        found[rows] = branches.at(side * wanted[rows])[:, order[0]]
    return found


class _Coupled:
    """The matrices of a motorcycle with linear devices over lean angle and acceleration."""

    def __init__(self, turning: SteadyTurning, parts: Sequence[StateSpace], frozen: bool):
        self.turning, self.parts, self.first = turning, parts, int(frozen)
        self.own_states = turning.motion.states[self.first :]
        self.width = len(self.own_states) + sum(len(part.states) for part in parts)

    def over_lean(self, side: int, degrees: np.ndarray) -> np.ndarray:
        """(n, nx, nx) at lean angles (n,) >= 0 [deg] to the right (side 1) or left (-1), at constant speed."""
        return np.array([self._matrix(side * lean, 0.0) for lean in np.radians(degrees)])

    def over_acceleration(self, degrees: float, side: int, sizes: np.ndarray) -> np.ndarray:
        """(n, nx, nx) at a lean angle [deg] and accelerations of sizes (n,) [m/s2], forward (side 1) or back (-1)."""
        return np.array([self._matrix(np.radians(degrees), side * a) for a in sizes])

    def _matrix(self, lean: float, acceleration: float) -> np.ndarray:
        A, B, C, _ = self.turning.linearised(self.turning.at(lean, acceleration))
        A, B, C = A[self.first :, self.first :], B[self.first :], C[:, self.first :]
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
