r"""The touring motorcycle of `vehicle_fmu.components.touring_motorcycle` in large motion on a flat road.

All freedoms are free. With the velocities u, v, w of the point A along the heading, to the right of it and down, yaw
rate r, rates p of roll phi and q of pitch theta, rates of the freedoms, and the spins of the wheels, all 18 in s:

    M(q) s' = Q(q, s, inputs)

Height, pitch and spins are states, from which the tyres' deflections and longitudinal slips follow, so that there are
no conditions. Kinematics and inertia: `vehicle_fmu.large_motion.frame_axes` and `chains`, in axes of the frame; tyres
and contact: `magic_formula` and `contact_in_frame`; suspensions: `suspension`, all in `vehicle_fmu.large_motion`.
Wheels obey i_p (Omega' - e.omega') = T - X_l rho, with the torque T between wheel and carrier, and slip angles relax as

    alpha'' = (alpha - alpha') t.X' / sigma(Z, u)

Drag D u^2 acts against the heading, lift L u^2 upwards and the moment M u^2 about the right of the heading at the
reference point. A has the path x' = u cos psi - v sin psi, y' = u sin psi + v cos psi, psi' = r.

It is the model of `vehicle_fmu.large_motion.equations`, which has deflection and slip as states, and its conditions by
multipliers. A wheel that leaves the road is outside of both.

Source: as in `vehicle_fmu.components.touring_motorcycle` and `vehicle_fmu.large_motion.equations`.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, ClassVar

from fmus import Component, input, local, output, parameter, state
from fmus.declaration.elements import Element
from fmus.declaration.variables import Variable
from fmus.interfaces.handlebar import port_input, port_output, port_state
from vehicle_fmu import magic_formula_tyres
from vehicle_fmu.components.touring_motorcycle import FLEXIBLE, TouringMotorcycle
from vehicle_fmu.large_motion import magic_formula
from vehicle_fmu.large_motion.chains import CARRIER, CHAINS, ENDS, FRAME, Posed, posed
from vehicle_fmu.large_motion.contact_in_frame import TyreForce, WheelOnRoad, tyre_force, wheel_on_road
from vehicle_fmu.large_motion.frame_axes import ZERO, Twist, cross, dot, plus, times
from vehicle_fmu.large_motion.magic_formula import Tyre
from vehicle_fmu.large_motion.suspension import FRONT, LENGTHWISE, POINTS, REAR, RearLinkage
from vehicle_fmu.large_motion.touring_tree import PITCH_INERTIAS

SUSPENSIONS = {  # symbol, what it is, units of stiffness and damping, of preload, of the freedom
    FRONT: ("q_f", "front suspension", ("N/m", "N.s/m", "N", "m")),
    LENGTHWISE: ("q_b", "bending of the fork lengthwise", ("N.m/rad", "N.m.s/rad", "N.m", "rad")),
    REAR: ("q_r", "rear suspension", ("N/m", "N.s/m", "N", "rad")),
}
LINKAGE = {  # places in which the linkage can move, for a component without values
    "rear_spring_top": (-0.2, 0.0),
    "rocker_pivot": (-0.1, -0.3),
    "rocker_rod": (-0.05, -0.05),
    "rocker_spring": (-0.1, 0.0),
    "swingarm_rod": (-0.2, -0.1),
}
UNITS = {
    **dict.fromkeys(("pEy4", "qBz5", "qDz3", "qEz5", "rBx1", "rBy2"), "1/rad"),
    **dict.fromkeys(("pDy3", "pEy2", "pKy4", "pKy5", "qBz6", "qDz4", "qDz10", "qDz11"), "1/rad2"),
    "rBy3": "rad",
}
SIZES = {"pDy1": 1.0, "pDx1": 1.0, "Cy": 1.0, "Cx": 1.5, "Cga": 1.0, "Ct": 1.0, "pKx1": 20.0, "qBz1": 10.0}
RATES = (*FRAME, *(f"{name}_rate" for chain in CHAINS for name in chain), *(f"{end}_spin_rate" for end in ENDS))


def parameters() -> Iterator[tuple[str, Variable]]:
    """The parameters of the motorcycle in straight running but the locks of its freedoms, and those of its
    supplement.
    """
    for name, row in TouringMotorcycle.declared.items():
        if row.role == "parameter" and name not in FLEXIBLE:
            yield name, row
    for name in PITCH_INERTIAS:
        what = name.removesuffix("_yy").replace("_", " ")
        yield name, parameter("kg.m2", f"Pitch inertia of the {what}", min=1e-9, max=1e5, start=1.0)
    tyres = {f"{end}_tyre_deflection": f"deflection of the {end} tyre" for end in ENDS}
    sprung = {name: (what, units) for name, (_, what, units) in SUSPENSIONS.items()}
    for name, (what, units) in (sprung | {n: (w, ("N/m", "N.s/m", "N", "m")) for n, w in tyres.items()}).items():
        yield f"{name}_stiffness", parameter(units[0], f"Stiffness of the {what}", min=0, max=1e15, start=1e5)
        yield f"{name}_damping", parameter(units[1], f"Damping of the {what}", min=0, max=1e9, start=500.0)
        yield f"{name}_preload", parameter(units[2], f"Preload of the {what}", min=-1e6, max=1e6)
    for name in POINTS:
        for axis, direction, start in zip("xz", ("forward", "up"), LINKAGE[name], strict=True):
            meaning = f"Linkage of the rear suspension, {name.replace('_', ' ')}, {direction}"
            yield f"{name}_{axis}", parameter("m", meaning, min=-10, max=10, start=start)
    for end in ENDS:
        for name in magic_formula.COEFFICIENTS:
            meaning = f"Coefficient {name} of the Magic Formula, {end} tyre"
            unit, start = UNITS.get(name, "1"), SIZES.get(name, 0.0)
            yield f"{end}_{name}", parameter(unit, meaning, min=-1e6, max=1e6, start=start)


def freedoms() -> Iterator[tuple[str, Variable]]:
    """Positions and rates of the freedoms beside steering."""
    sprung = {name: (symbol, what, "m" if slides else "rad") for name, (symbol, what, slides) in FLEXIBLE.items()}
    sprung |= {name: (symbol, what, units[-1]) for name, (symbol, what, units) in SUSPENSIONS.items()}
    for name, (symbol, what, unit) in sprung.items():
        shown = name in (FRONT, REAR)
        yield f"{name}_rate", state(f"{unit}/s", f"Rate of the {what}", symbol=rf"\dot {symbol}")
        yield f"{name}_position", state(unit, what.capitalize(), symbol=symbol, nominal=1e-2, exposed=shown)
    for end in ENDS:
        mark = end[0]
        yield f"{end}_spin_rate", state("rad/s", f"Spin of the {end} wheel", symbol=rf"\Omega_{mark}", start=100.0)
        yield f"{end}_relaxed_slip", TouringMotorcycle.declared[f"{end}_relaxed_slip"]
        for name, symbol, what in (("load", "Z", "Load"), ("longitudinal_force", "X", "Longitudinal force"),
                                   ("side_force", "Y", "Side force")):  # fmt: skip
            yield f"{end}_{name}", output("N", f"{what} of the {end} tyre", symbol=f"{symbol}_{mark}", nominal=100)


class TouringMotorcycleInSpace(Component):
    """Touring motorcycle in large motion: bodies in space, suspensions, tyres that deflect and slip on a flat road."""

    vars().update(parameters())
    drive_torque = input("N.m", "Torque between swingarm and rear wheel, drives where positive", symbol="T_r")
    front_wheel_torque = input("N.m", "Torque between lower fork and front wheel, brakes where negative", symbol="T_w")
    steer_torque = TouringMotorcycle.declared["steer_torque"]
    handlebar_torque = port_input("handlebar_torque")
    frame_torque = port_input("frame_torque")

    forward_speed = state("m/s", "Forward speed along the heading", symbol="u", start=30.0, min=0.1, max=200,
                          nominal=10.0, exposed=True)  # fmt: skip
    lateral_velocity = TouringMotorcycle.declared["lateral_velocity"]
    vertical_velocity = state("m/s", "Velocity of A down", symbol="w_z")
    yaw_rate = TouringMotorcycle.declared["yaw_rate"]
    roll_rate = TouringMotorcycle.declared["roll_rate"]
    pitch_rate = state("rad/s", "Pitch rate, nose up positive", symbol="q", exposed=True)
    steer_rate = port_state("steer_rate")
    vertical_position = state("m", "Position of A down from the road", symbol="h_A", nominal=1e-2)
    roll_angle = replace(TouringMotorcycle.declared["roll_angle"], min=-1.5, max=1.5)
    pitch_angle = state("rad", "Pitch angle, nose up positive", symbol=r"\theta_p", nominal=1e-2, exposed=True)
    steer_angle = port_state("steer_angle")
    path_x = state("m", "Position of A along the first heading", symbol="x_P", nominal=10.0, exposed=True)
    path_y = state("m", "Position of A to the right of the first heading", symbol="y_P", nominal=10.0, exposed=True)
    heading = state("rad", "Heading, to the right positive", symbol=r"\psi", nominal=1.0, exposed=True)
    vars().update(freedoms())

    frame_rate = port_output("frame_rate")
    front_suspension_force = output("N", "Force of the front suspension against compression", symbol="F_{sf}",
                                    nominal=1e3)  # fmt: skip
    rear_suspension_force = output("N", "Force of the rear spring and damper against compression", symbol="F_{sr}",
                                   nominal=1e3)  # fmt: skip
    head_torque = local("N.m", "Torque of the steering head against the steer rate, such as of a damper", symbol="T_s")

    elements: ClassVar = {
        "steering_head": Element("head_torque", "steer_angle", "steer_rate", damping="steering_damping")
    }

    def mass(self, v, m):
        at = self._posed(v, m)
        inertia = at.inertia(m)
        entries: dict[tuple[str, str], Any] = {}

        def set_column(column: str, wrench: Twist, path: dict[str, Twist]) -> None:
            for row, twist in path.items():
                entries[row, column] = entries[column, row] = m.term(twist.power(wrench))

        for k, (name, twist) in enumerate(at.of_frame.items()):
            momentum = inertia["frame"].momentum(twist).once(m)
            set_column(name, momentum, dict(list(at.of_frame.items())[: k + 1]))
        for chain in CHAINS:
            for name in chain:
                momentum = inertia[name].momentum(at.links[name].freedom).once(m)
                set_column(f"{name}_rate", momentum, at.path(name))
        for end, name in CARRIER.items():
            polar = v[f"{end}_spin_inertia"]
            spinning = Twist(times(-polar, at.links[name].axes[1]), ZERO)
            set_column(f"{end}_spin_rate", spinning, at.path(name))
            entries[f"{end}_spin_rate", f"{end}_spin_rate"] = polar
        return entries

    def equations(self, v, m):
        at = self._posed(v, m)
        wheels, forces, derivatives = {}, {}, {}
        for end in ENDS:
            wheel, force = wheels[end], forces[end] = self._tyre(v, m, at, end)
            length = _tyre(v, m, end).relaxation_length(force.load, v.forward_speed)
            derivatives[f"der({end}_relaxed_slip)"] = (wheel.slip - v[f"{end}_relaxed_slip"]) * wheel.along / length
            derivatives[f"{end}_side_force"], derivatives[f"{end}_load"] = force.side, force.load
            derivatives[f"{end}_longitudinal_force"] = force.longitudinal
        v.head_torque = v.steering_damping * v.steer_rate
        steer_axis = at.links["steer"].freedom.angular
        wrench = self._wrenches(v, m, at, forces)
        own, suspension_forces = self._springs(v, m)
        own["steer_rate"] = v.steer_torque - v.head_torque
        for chain in CHAINS:
            carried = Twist(ZERO, ZERO)
            for name in reversed(chain):
                if name in wrench:
                    carried = (carried + wrench[name]).once(m)
                derivatives[f"der({name}_rate)"] = own[f"{name}_rate"] + at.links[name].freedom.power(carried)
            wrench["frame"] = wrench["frame"] + carried
        whole = wrench["frame"].once(m)
        for name, twist in at.of_frame.items():
            derivatives[f"der({name})"] = twist.power(whole)
        for end, torque in (("front", v.front_wheel_torque), ("rear", v.drive_torque)):
            link = at.links[CARRIER[end]]
            turned = v[f"{end}_spin_inertia"] * dot(link.axes[1], link.acceleration.angular)
            derivatives[f"der({end}_spin_rate)"] = torque - forces[end].longitudinal * wheels[end].radius + turned
        cosine, sine = m.cos(v.heading), m.sin(v.heading)
        positions = {f"{n}_position": f"{n}_rate" for chain in CHAINS for n in chain if n != "steer"}
        angles = {"steer_angle": "steer_rate", "roll_angle": "roll_rate", "pitch_angle": "pitch_rate"}
        rates = {**positions, **angles, "vertical_position": "vertical_velocity", "heading": "yaw_rate"}
        return {
            **derivatives,
            **{f"der({position})": v[rate] for position, rate in rates.items()},
            "der(path_x)": v.forward_speed * cosine - v.lateral_velocity * sine,
            "der(path_y)": v.forward_speed * sine + v.lateral_velocity * cosine,
            "frame_rate": dot(at.links["frame"].twist.angular, steer_axis),
            **suspension_forces,
        }

    def _posed(self, v: Any, m: Any) -> Posed:
        return posed({name: v[name] for name in self.rows("parameter", "state")}, m)

    @staticmethod
    def _tyre(v: Any, m: Any, at: Posed, end: str) -> tuple[WheelOnRoad, TyreForce]:
        wheel = wheel_on_road(at.links[CARRIER[end]], at.centre[end], at.down, v.vertical_position,
                              v[f"{end}_spin_rate"], at.height[end], v[f"{end}_section_radius"],
                              v[f"{end}_wheel_radius"], m)  # fmt: skip
        name = f"{end}_tyre_deflection"
        elastic = v[f"{name}_preload"] + v[f"{name}_stiffness"] * wheel.deflection
        load = m.term(elastic + v[f"{name}_damping"] * wheel.sinking)
        return wheel, tyre_force(wheel, _tyre(v, m, end), load, v[f"{end}_relaxed_slip"])

    @staticmethod
    def _wrenches(v: Any, m: Any, at: Posed, forces: dict[str, TyreForce]) -> dict[str, Twist]:
        """What acts on the bodies of each link, less what their motion needs."""
        gravity, found = times(v.gravity, at.down), {}
        carriers = {"frame": "frame", "upper_fork": "steer", "lower_body": "rider_slide", "upper_body": "rider_lean",
                    "lower_fork": CARRIER["front"], "swingarm": CARRIER["rear"]}  # fmt: skip
        ends = {name: end for end, name in CARRIER.items()}
        for name, link in carriers.items():
            spin = at.spin_momentum[ends[link]] if link in ends else ZERO
            found[link] = at.bodies[name].wrench(at.links[link], gravity, spin, m).times(-1)
            if link in ends:
                found[link] = found[link] + forces[ends[link]].wrench
        axis, squared = at.links["steer"].freedom.angular, m.term(v.forward_speed**2)
        found["steer"] = found["steer"] + Twist(times(v.handlebar_torque, axis), ZERO)
        wind = plus(times(-v.drag * squared, at.ahead), times(-v.lift * squared, at.down))
        moment = plus(cross((0, 0, -v.reference_height), wind), times(v.pitching_moment * squared, at.right))
        found["frame"] = found["frame"] + Twist(plus(moment, times(v.frame_torque, axis)), wind)
        return found

    @staticmethod
    def _springs(v: Any, m: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        """The generalised forces of springs and dampers by rate, and the forces of the suspensions by output."""
        linkage = RearLinkage({f"{p}_{a}": v[f"{p}_{a}"] for p in (*POINTS, "swingarm_axis") for a in "xz"}, m)
        own, forces = {}, {}
        for name in (*FLEXIBLE, *SUSPENSIONS):
            position, rate = v[f"{name}_position"], v[f"{name}_rate"]
            shortened, ratio = linkage.compression(position) if name == REAR else (position, 1)
            preload = v[f"{name}_preload"] if name in SUSPENSIONS else 0
            damped = v[f"{name}_damping"] * ratio * rate
            force = m.term(preload + v[f"{name}_stiffness"] * shortened + damped)
            own[f"{name}_rate"] = -force * ratio
            forces[f"{name}_force"] = force
        return own, {name: forces[name] for name in ("front_suspension_force", "rear_suspension_force")}


def _tyre(v: Any, m: Any, end: str) -> Tyre:
    names = (*magic_formula_tyres.COEFFICIENTS, *magic_formula.COEFFICIENTS)
    return Tyre({name: v[f"{end}_{name}"] for name in names}, m)

