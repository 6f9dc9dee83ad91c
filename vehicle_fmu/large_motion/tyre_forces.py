r"""Forces of both tyres on the road: loads, side and longitudinal forces, moments.

    load of a tyre that deflects      Z = F_0 + k delta + c delta'
    longitudinal force of one that slips lengthwise      X = X(Z, kappa, alpha')
    side force and moment      Y, M = Y, M(Z, alpha', gamma, kappa)      (`vehicle_fmu.large_motion.magic_formula`)

A tyre that does not deflect has the load of its condition's multiplier, on which its other forces depend at once; loads
and forces that agree are found by Newton's method. A load that the law makes negative is a wheel in the air: the law
does not hold there, and no equilibrium is there.

Source: as in the open model of Passigato et al., Applied Sciences 10 (2020) 6826.
"""

from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np

from vehicle_fmu.large_motion.magic_formula import Tyre

CONVERGED = 1e-10
ITERATIONS = 30


class TyreForces:
    """(Y_f, Y_r, M_f, M_r, X_f, X_r) (..., 6) of two tyres, with values by name; free (4,) says whether the deflections
    and the longitudinal slips are free.
    """

    def __init__(self, tyres: Mapping[str, Tyre], values: Mapping[str, float], free: np.ndarray):
        self.tyres, self.values, self.free = tyres, values, free

    def __call__(self, found: SimpleNamespace, load: np.ndarray) -> np.ndarray:
        """The forces at what `LargeMotion.posed` finds and loads (..., 2); X = 0 where the slip is locked."""
        sideways, lengthwise = [], []
        for i, (end, tyre) in enumerate(self.tyres.items()):
            ratio, slip, free = found.ratio[end], found.relaxed[end], self.free[2 + i]
            camber = found.wheels[end].camber
            sideways.append(tyre.forces(load[..., i], slip, camber, ratio if free else None))
            lengthwise.append(tyre.longitudinal_force(load[..., i], ratio, slip) if free else 0.0 * slip)
        (y_f, m_f), (y_r, m_r) = sideways
        return np.stack([y_f, y_r, m_f, m_r, *lengthwise], axis=-1)

    def loads(self, found: SimpleNamespace) -> np.ndarray:
        """The loads (..., 2) by deflection and its rate [N]."""
        p, each = self.values, []
        for end in self.tyres:
            name = f"{end}_tyre_deflection"
            stiff, damped = p[f"{name}_stiffness"] * found.sunk[end], p[f"{name}_damping"] * found.sinking[end]
            each.append(p[f"{name}_preload"] + stiff + damped)
        return np.stack(each, axis=-1)

    def at_contacts(self, found: SimpleNamespace, multipliers: np.ndarray) -> np.ndarray:
        """Loads and longitudinal forces (..., 4) [N]: by the tyres' laws where free, those given where locked."""
        loads = np.where(self.free[:2], self.loads(found), multipliers[..., :2])
        pushes = np.where(self.free[2:], self(found, loads)[..., 4:], multipliers[..., 2:])
        return np.concatenate([loads, pushes], axis=-1)

    def consistent(self, found: SimpleNamespace, by_force: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The loads (..., 2) and the forces (..., 6) that agree with the loads that they cause, by_force (..., 2, 1 +
        6). Sets `found.determinacy`, the determinant of what the loads lack, by the loads.
        """
        nominal = [np.full(by_force.shape[:-2], tyre.nominal_load, by_force.dtype) for tyre in self.tyres.values()]
        load = np.where(self.free[:2], by_force[..., 0], np.stack(nominal, axis=-1))
        for _ in range(ITERATIONS):
            now = self(found, load)
            per_load = (self(found, load * (1 + 1e-7)) - now) / np.tile(1e-7 * load, 3)
            excess = load - by_force[..., 0] - (by_force[..., 1:] @ now[..., None])[..., 0]
            each = by_force[..., 1:] * per_load[..., None, :]
            slopes = np.eye(2) - each[..., :2] - each[..., 2:4] - each[..., 4:]
            found.determinacy = np.linalg.det(slopes).real
            change = np.linalg.solve(slopes, excess[..., None])[..., 0]
            load = load - change
            if small(change / 1e3):
                break
        return load, self(found, load)


def small(change: Any) -> bool:
    """Whether Newton's method has converged: its next change is the square of one this small (of values of the size
    of 1).
    """
    return bool((np.abs(change.real) < CONVERGED).all())
