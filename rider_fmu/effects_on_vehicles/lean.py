r"""The rider leans and shifts on the saddle, with the equations of the rider in roll (see `rider_fmu.rider_in_roll`).

A share sigma of him moves: what a rigid body of his mass m, at the height z, with the roll inertia J adds to the
vehicle's equations is taken out, and his answer to the frame's motion x is added at the roll port, both times sigma:

    roll_torque += sigma T_phi(x),     lateral_force += sigma F(x)
    lateral  ... - sigma m (v' + z p' + V r)
    roll     ... - sigma (m z v' + (J + m z^2) p' + m z (V r - g phi))

His motion x does not depend on sigma. His joints are those of the shipped rider, who meets every feature of the 2008 roll
test, with stiffnesses times q^2 and dampings times q d: without gravity all his natural frequencies were q times, his
damping ratios d times those of that rider.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any, ClassVar

from fmus import Effect, adds_to, parameter
from fmus.roll_port import FLOWS
from rider_fmu import riders
from rider_fmu.rider_in_roll import rigid_body

RIDER = riders.load("roll_1971")
MASS, HEIGHT, INERTIA = rigid_body(SimpleNamespace(**RIDER.values)).values()  # kg, m, kg.m2: held stiff
SPEEDS = ("pelvis_velocity", "lean_rate", "head_rate")


class RiderInRollLeans(Effect):
    """The rider's pelvis, torso and head lean and shift on the saddle."""

    family, form = "rider_lean", "pelvis_torso_head"
    share = parameter("1", "Part of the rider that moves; the rest stays with the rear frame", symbol=r"\sigma", min=0, max=1.2, start=0.5)
    quickness = parameter("1", "His natural frequencies over those of the shipped rider", symbol="q", min=0.3, max=5, start=1.0)
    damping = parameter("1", "His damping ratios over those of the shipped rider", symbol="d", min=0.05, max=5, start=1.0)
    declared: ClassVar = {n: replace(row, exposed=False) for n, row in RIDER.rows("state").items()}
    starts: ClassVar = {"quickness": (0.7, 1.4, 2.8), "damping": (0.3, 1.0)}

    def additions(self) -> Iterator[tuple[str, Callable]]:
        yield from super().additions()
        for name in RIDER.states:
            yield f"der({name})", partial(self.rate, name=name)
        for row in SPEEDS:
            for column in SPEEDS:
                yield f"mass({row}, {column})", partial(self.inertia, row=row, column=column)
        for name in FLOWS:
            yield name, partial(self.answer, name=name)

    @staticmethod
    def values(v: Any) -> dict[str, Any]:
        """What the rider is told: his parameters, his states, the motion of the frame."""
        joints = {n: x * v.quickness * (v.quickness if n.endswith("stiffness") else v.damping)
                  for n, x in RIDER.values.items() if n.endswith(("stiffness", "damping"))}  # fmt: skip
        motion = {n: getattr(v, n) for n in (*RIDER.states, "roll_angle", "roll_rate", "lateral_velocity")}
        return {**RIDER.values, **joints, **motion, "gravity": v.gravity, "turning_acceleration": v.speed * v.yaw_rate, "time": 0.0}

    def rate(self, v: Any, m: Any, name: str) -> Any:
        return RIDER.run(self.values(v), m)[f"der({name})"]

    def inertia(self, v: Any, m: Any, row: str, column: str) -> Any:
        return RIDER.mass_entries(self.values(v), m)[row, column] - (row == column)  # a state's entry is 1 before

    def answer(self, v: Any, m: Any, name: str) -> Any:
        return v.share * RIDER.run(self.values(v), m)[name]

    @adds_to("mass(lateral_velocity, lateral_velocity)")
    def mass_spared(self, v: Any, m: Any) -> Any:
        return -v.share * MASS

    @adds_to("mass(lateral_velocity, roll_rate)", "mass(roll_rate, lateral_velocity)")
    def moment_spared(self, v: Any, m: Any) -> Any:
        return -v.share * MASS * HEIGHT

    @adds_to("mass(roll_rate, roll_rate)")
    def inertia_spared(self, v: Any, m: Any) -> Any:
        return -v.share * (INERTIA + MASS * HEIGHT**2)

    @adds_to("der(lateral_velocity)")
    def turning_spared(self, v: Any, m: Any) -> Any:
        return v.share * MASS * v.speed * v.yaw_rate

    @adds_to("der(roll_rate)")
    def weight_spared(self, v: Any, m: Any) -> Any:
        return v.share * MASS * HEIGHT * (v.speed * v.yaw_rate - v.gravity * v.roll_angle)
