"""Forces on the touring motorcycle in a corner, formed for Exudyn: springs, linkage, wind, torques, tyres.

Nothing of `vehicle_fmu.large_motion` is used but the tyres' formulas: contacts are formed in fixed axes, and the rear
linkage is the intersection of two circles, its slope a central difference.
"""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from fmus import Component
from fmus.expressions.functions import NUMERIC
from motofmi.scenarios.hosts.exudyn_tree import DOWN, RIGHT, SpaceFreedom, Tree
from vehicle_fmu.components.touring_motorcycle import FLEXIBLE, bodies
from vehicle_fmu.large_motion.touring_tree import ENDS, ORDER, tyre
from vehicle_fmu.out_of_plane import Body

STEP = 1e-6  # rad: of the swingarm's angle, for the slope of the spring's length


class CornerForces:
    """The generalised forces (n,) apart from weight and inertia, with inputs u (nu,), relaxed slip angles `slips` (2,),
    and, where the tyres are not `free` to deflect and to slip lengthwise, with loads and longitudinal forces (4,).
    """

    def __init__(self, motorcycle: Component, u: np.ndarray, loads: np.ndarray):
        self.p = SimpleNamespace(**{**motorcycle.values, **motorcycle.supplement})
        self.u, self.loads, self.slips, self.free = u.copy(), loads.copy(), np.zeros(2), True
        self.tyres = {end: tyre(motorcycle, end) for end in ENDS}
        found, _ = bodies(_Values({**motorcycle.values, "speed": 0.0}), NUMERIC)
        self.tree = Tree(
            self._with_suspensions(found),
            self.p.front_spin_inertia,
            self.p.rear_spin_inertia,
            [motorcycle.supplement.get(f"{name}_yy", 0.0) for name in ORDER],
        )
        self.place = self.tree.place
        self.still = self._spring_length(0.0)

    def _with_suspensions(self, found: list[Body]) -> list[Body]:
        """The bodies with the free suspensions in the paths of lower fork, swingarm and wheels, without what is
        locked."""
        free, torsion = vars(self.p), found[ORDER.index("lower_fork")].path[-1]
        swing, (forward, down) = found[ORDER.index("swingarm")].path[-1], torsion.axis or (0.0, 0.0)
        bending = SpaceFreedom("fork_lengthwise_bending_rate", torsion.point, RIGHT, False)
        slide = SpaceFreedom("front_suspension_rate", torsion.point, -np.array([forward, 0.0, down]), True)
        swinging = SpaceFreedom("rear_suspension_rate", swing.point, -RIGHT, False)
        instead: dict[Any, list[Any]] = {
            torsion: [bending] * bool(free["fork_lengthwise_bending"]) + [torsion] + [slide] * bool(free["front_suspension"]),
            swing: [swinging] * bool(free["rear_suspension"]) + [swing],
        }
        paths = [[x for j in b.path for x in instead.get(j, [j]) if getattr(x, "free", True)] for b in found]
        return [replace(b, path=tuple(path)) for b, path in zip(found, paths, strict=True)]

    # Springs ----------------------------------------------------------------------------------------

    def _spring_length(self, angle: float) -> float:
        """The length of the rear spring [m] where the swingarm's end has risen by an angle [rad]."""
        p = vars(self.p)

        def point(name: str) -> complex:
            return complex(p[f"{name}_x"], p[f"{name}_z"])

        def rod_end(angle: float) -> complex:
            return point("swingarm_axis") + point("swingarm_rod") * np.exp(-1j * angle)

        pivot, arm = point("rocker_pivot"), point("rocker_rod")
        rod, away = abs(pivot + arm - rod_end(0.0)), rod_end(angle) - pivot
        foot = (abs(arm) ** 2 - rod**2 + abs(away) ** 2) / (2 * abs(away))
        height = np.sqrt(abs(arm) ** 2 - foot**2)
        ends = [(foot + side * 1j * height) * away / abs(away) for side in (1, -1)]
        turned = min((end / arm for end in ends), key=lambda z: abs(np.angle(z)))
        return abs(pivot + point("rocker_spring") * turned - point("rear_spring_top"))

    def _springs(self, q: np.ndarray, w: np.ndarray) -> np.ndarray:
        p, total = vars(self.p), np.zeros(len(q))
        for name in FLEXIBLE:
            if name not in self.place:
                continue
            k = self.place[name]
            total[k] = -p[f"{name}_stiffness"] * q[k] - p[f"{name}_damping"] * w[k]
        for name in ("fork_lengthwise_bending", "front_suspension", "rear_suspension"):
            if name not in self.place:
                continue
            k, shortened, slope = self.place[name], q[self.place[name]], 1.0
            if name == "rear_suspension":
                slope = (self._spring_length(q[k] - STEP) - self._spring_length(q[k] + STEP)) / (2 * STEP)
                shortened = self.still - self._spring_length(q[k])
            force = p[f"{name}_preload"] + p[f"{name}_stiffness"] * shortened + p[f"{name}_damping"] * slope * w[k]
            total[k] = -force * slope
        return total

    # Contacts ---------------------------------------------------------------------------------------

    def conditions(self, q: np.ndarray, ratio: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """The rows (4, n) of rising velocity and of rolling with longitudinal slips (2,), 0 unless given, and the depth
        of both wheels in the road (2,) [m].
        """
        ratio = np.zeros(2) if ratio is None else ratio
        wheels = [self.wheel(end, q, np.zeros_like(q)) for end in ENDS]
        rolls = [wheel.slides + kappa * wheel.heads for wheel, kappa in zip(wheels, ratio, strict=True)]
        return np.array([*(wheel.rises for wheel in wheels), *rolls]), np.array([w.depth for w in wheels])

    def wheel(self, end: str, q: np.ndarray, w: np.ndarray) -> SimpleNamespace:
        """The contact of a wheel: path of its carrier, point, heading and right (3,), slip and camber, deflection,
        load, and rows.
        """
        frames = self.tree.frames(q)
        turned, joints, axes = frames
        spin, tube, p = self.place[f"{end}_spin"], self.tyres[end].section_radius, vars(self.p)
        path = self.tree.path(f"{end}_spin")[:-1]
        axle = turned[path[-1]] @ RIGHT
        towards = DOWN - (DOWN @ axle) * axle
        level = np.linalg.norm(towards)
        rim = joints[spin] + (-self.tree.links[spin].point[2] - tube) * towards / level
        depth = (rim + tube * DOWN) @ DOWN
        point = rim + (tube - depth) * DOWN
        ahead = np.cross(axle, DOWN) / level
        right = np.cross(DOWN, ahead)
        heads = self.tree.force(path, frames, point, ahead)
        radius = p[f"{end}_wheel_radius"] - tube + (tube - depth) * level
        slides = heads.copy()
        slides[spin] -= radius
        velocity = sum(
            w[k] * (axes[k] if self.tree.links[k].slides else np.cross(axes[k], point - joints[k])) for k in path
        )
        along, sinking = velocity @ ahead, velocity @ DOWN
        name = f"{end}_tyre_deflection"
        return SimpleNamespace(
            path=path,
            point=point,
            ahead=ahead,
            right=right,
            frames=frames,
            camber=np.arcsin(axle @ DOWN),
            slip=-np.arctan2(velocity @ right, along),
            along=along,
            depth=depth,
            sinking=sinking,
            ratio=(w[spin] * radius - along) / along if along else 0.0,
            load=p[f"{name}_preload"] + p[f"{name}_stiffness"] * depth + p[f"{name}_damping"] * sinking,
            rises=self.tree.force(path, frames, point, -DOWN),
            heads=heads,
            slides=slides,
        )

    def frame_rate(self, q: np.ndarray, w: np.ndarray) -> float:
        """The rate of the frame about the steer axis [rad/s]."""
        _, _, axes = self.tree.frames(q)
        turning = sum(w[k] * axes[k] for k in self.tree.path("pitch") if not self.tree.links[k].slides)
        return float(turning @ axes[self.place["steer"]])

    def __call__(self, q: np.ndarray, w: np.ndarray) -> np.ndarray:
        """The generalised forces (n,) at coordinates and rates (n,)."""
        place, p, frames = self.place, self.p, self.tree.frames(q)
        turned, joints, axes = frames
        drive, steer_torque, handlebar, on_frame, front_wheel = self.u
        total = self._springs(q, w)
        total[place["steer"]] = steer_torque - p.steering_damping * w[place["steer"]]
        total[place["rear_spin"]] += drive
        total[place["front_spin"]] += front_wheel
        frame, squared = self.tree.path("pitch"), w[place["along"]] ** 2
        reference = joints[frame[-1]] - turned[frame[-1]] @ DOWN * p.reference_height
        wind = np.array([-p.drag, 0.0, -p.lift]) * squared
        total += self.tree.force(frame, frames, reference, wind, p.pitching_moment * squared * RIGHT)
        for path, torque in ((self.tree.path("steer"), handlebar), (frame, on_frame)):
            total += self.tree.force(path, frames, joints[path[-1]], np.zeros(3), torque * axes[place["steer"]])
        for k, end in enumerate(ENDS):
            at, its = self.wheel(end, q, w), self.tyres[end]
            load = at.load if self.free else self.loads[k]
            ratio = at.ratio if self.free else None
            push = its.longitudinal_force(load, at.ratio, self.slips[k]) if self.free else self.loads[k + 2]
            side, moment = its.forces(load, self.slips[k], at.camber, ratio)
            total += self.tree.force(at.path, frames, at.point, side * at.right, moment * DOWN)
            total += load * at.rises + push * at.slides
        return total


class _Values(dict):
    """Values by key and by attribute."""

    __getattr__ = dict.__getitem__
