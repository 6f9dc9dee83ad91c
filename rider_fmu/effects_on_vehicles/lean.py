r"""The rider leans and shifts on the saddle, by the equations of the rider in roll (see
`rider_fmu.components.rider_in_roll`).

A share sigma of the rider moves. The terms of a rigid body of the rider's mass m at the height z with the roll inertia
J are removed from the equations of the vehicle, and the forces of the rider at the roll port are added, both times
sigma:

    roll_torque += sigma T_phi(x),     lateral_force += sigma F(x)
    lateral  ... - sigma m (v' + z p' + V r)
    roll     ... - sigma (m z v' + (J + m z^2) p' + m z (V r - g phi))

The motion x of the rider does not depend on sigma. The joints are those of the rider `roll_1971`, which meets every
feature of the 2008 roll test, with stiffnesses times q^2 and dampings times q d: without gravity all natural
frequencies are q times, all damping ratios d times those of that rider.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any, ClassVar

from fmus import Effect, adds_to, parameter
from fmus.interfaces.roll import FLOWS
from rider_fmu import riders
from rider_fmu.components.rider_in_roll import rigid_body

RIDER = riders.load("roll_1971")
MASS, HEIGHT, INERTIA = rigid_body(SimpleNamespace(**RIDER.values)).values()  # kg, m, kg.m2: as a rigid body
SPEEDS = ("pelvis_velocity", "lean_rate", "head_rate")


class RiderInRollLeans(Effect):
    """The rider's pelvis, torso and head lean and shift on the saddle."""

    family, form = "rider_lean", "pelvis_torso_head"
    share = parameter(
        "1",
        "Part of the rider that moves; the rest stays with the rear frame",
        symbol=r"\sigma",
        min=0,
        max=1.2,
        start=0.5,
    )
    quickness = parameter(
        "1", "Natural frequencies relative to those of the rider roll_1971", symbol="q", min=0.3, max=5, start=1.0
    )
    damping = parameter(
        "1", "Damping ratios relative to those of the rider roll_1971", symbol="d", min=0.05, max=5, start=1.0
    )
    declared: ClassVar = {n: replace(row, exposed=False) for n, row in RIDER.rows("state").items()}
    starts: ClassVar = {"quickness": (0.7, 1.4, 2.8), "damping": (0.3, 1.0)}

    def additions(self) -> Iterator[tuple[str, Callable]]:
        """The marked methods, and the rates, inertias and port forces of the rider."""
        yield from super().additions()
        for name in RIDER.states:
            yield f"der({name})", partial(self.rate, name=name)
        for row in SPEEDS:
            for column in SPEEDS:
                yield f"mass({row}, {column})", partial(self.inertia, row=row, column=column)
        for name in FLOWS:
            yield name, partial(self.forces, name=name)

    @staticmethod
    def values(v: Any) -> dict[str, Any]:
        """The values for the rider: parameters, states, and the motion of the frame."""
        joints = {n: x * v.quickness * (v.quickness if n.endswith("stiffness") else v.damping)
                  for n, x in RIDER.values.items() if n.endswith(("stiffness", "damping"))}  # fmt: skip
        motion = {n: getattr(v, n) for n in (*RIDER.states, "roll_angle", "roll_rate", "lateral_velocity")}
        return {
            **RIDER.values,
            **joints,
            **motion,
            "gravity": v.gravity,
            "turning_acceleration": v.speed * v.yaw_rate,
            "time": 0.0,
        }

    def rate(self, v: Any, m: Any, name: str) -> Any:
        """The rate of a state of the rider, before division by the mass matrix."""
        return RIDER.run(self.values(v), m)[f"der({name})"]

    def inertia(self, v: Any, m: Any, row: str, column: str) -> Any:
        """The entry of the rider's mass matrix, less the 1 that a diagonal has by default."""
        return RIDER.mass_entries(self.values(v), m)[row, column] - (row == column)  # a state's entry is 1 before

    def forces(self, v: Any, m: Any, name: str) -> Any:
        """The share of a force or torque of the rider at the roll port."""
        return v.share * RIDER.run(self.values(v), m)[name]

    @adds_to("mass(lateral_velocity, lateral_velocity)")
    def mass_removed(self, v: Any, m: Any) -> Any:
        return -v.share * MASS

    @adds_to("mass(lateral_velocity, roll_rate)", "mass(roll_rate, lateral_velocity)")
    def moment_removed(self, v: Any, m: Any) -> Any:
        return -v.share * MASS * HEIGHT

    @adds_to("mass(roll_rate, roll_rate)")
    def inertia_removed(self, v: Any, m: Any) -> Any:
        return -v.share * (INERTIA + MASS * HEIGHT**2)

    @adds_to("der(lateral_velocity)")
    def turning_removed(self, v: Any, m: Any) -> Any:
        return v.share * MASS * v.speed * v.yaw_rate

    @adds_to("der(roll_rate)")
    def weight_removed(self, v: Any, m: Any) -> Any:
        return v.share * MASS * HEIGHT * (v.speed * v.yaw_rate - v.gravity * v.roll_angle)
