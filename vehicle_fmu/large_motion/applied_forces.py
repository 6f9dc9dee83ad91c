"""Applied forces on the touring motorcycle in large motion: all but those of its tyres.

Weights; drag D u^2 against the heading, lift L u^2 and moment M u^2 at the reference point; springs and dampers of its
freedoms, those of the suspensions by `vehicle_fmu.large_motion.suspension`; the torques between swingarm and rear wheel
(drive, or brake where negative) and between lower fork and front wheel; the torques of the handlebar port.

Source: as in `vehicle_fmu.components.touring_motorcycle`.
"""

from types import SimpleNamespace
from typing import Any

import numpy as np

from vehicle_fmu.components.touring_motorcycle import FLEXIBLE
from vehicle_fmu.large_motion.contact import DOWN
from vehicle_fmu.large_motion.suspension import REAR, RearLinkage
from vehicle_fmu.large_motion.tree import Motion, Tree

AHEAD = np.array([1.0, 0.0, 0.0])
INPUTS = ("drive_torque", "steer_torque", "handlebar_torque", "frame_torque", "front_wheel_torque")


class AppliedForces:
    """The generalised forces (..., n) of a motorcycle with a tree, values by name, and the free ones of its freedoms
    with a spring.
    """

    def __init__(self, tree: Tree, values: SimpleNamespace, free: list[str]):
        self.tree, self.values, self.free, self.place = tree, values, free, tree.place
        self.linkage = RearLinkage(vars(values))

    def __call__(
        self, motion: Motion, q: np.ndarray, w: np.ndarray, weight: np.ndarray, u: np.ndarray
    ) -> dict[str, Any]:
        """By what they are, at a motion with coordinates q and rates w (..., n), with the forces of the weights per
        gravity (..., n) and inputs u (..., nu).
        """
        p, place = self.values, self.place
        drive, steer_torque, handlebar, on_frame, front_wheel = np.moveaxis(u, -1, 0)
        frame, steer = place["pitch"], place["steer"]
        squared = (w[..., place["along"]] ** 2)[..., None]
        shift, turn = self.tree.jacobians(motion, frame, self._reference(motion))
        wind = -p.drag * AHEAD - p.lift * DOWN
        driven, steered = np.zeros_like(q), np.zeros_like(q)
        driven[..., place["rear_spin"]], driven[..., place["front_spin"]] = drive, front_wheel
        steered[..., steer] = steer_torque
        axis = motion.axis[..., steer, :]
        _, front_turn = self.tree.jacobians(motion, steer, motion.joint[..., steer, :])
        at_bar = handlebar[..., None] * (axis[..., None, :] @ front_turn)[..., 0, :]
        at_bar = at_bar + on_frame[..., None] * (axis[..., None, :] @ turn)[..., 0, :]
        springs, dampers = self._springs_and_dampers(q, w)
        return {
            "weight": p.gravity * weight,
            "aerodynamic": squared * (wind @ shift + p.pitching_moment * turn[..., 1, :]),
            "springs": springs,
            "dampers": dampers,
            "drive": driven,
            "steer_torque": steered,
            "handlebar_port": at_bar,
        }

    def compression(self, name: str, q: np.ndarray) -> tuple[Any, Any]:
        """s (...) and ds / dq (...) of the spring of a freedom."""
        position = q[..., self.place[name]]
        return self.linkage.compression(position) if name == REAR else (position, 1.0)

    def _springs_and_dampers(self, q: np.ndarray, w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        p, springs, dampers = vars(self.values), np.zeros_like(q), np.zeros_like(q)
        for name in self.free:
            k, (shortened, ratio) = self.place[name], self.compression(name, q)
            preload = 0.0 if name in FLEXIBLE else p[f"{name}_preload"]
            springs[..., k] = -(preload + p[f"{name}_stiffness"] * shortened) * ratio
            dampers[..., k] = -p[f"{name}_damping"] * ratio**2 * w[..., k]
        dampers[..., self.place["steer"]] = -self.values.steering_damping * w[..., self.place["steer"]]
        return springs, dampers

    def _reference(self, motion: Motion) -> np.ndarray:
        frame = self.place["pitch"]
        return motion.joint[..., frame, :] - self.values.reference_height * motion.turned[..., frame, :, 2]
