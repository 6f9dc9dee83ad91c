r"""The benchmark bicycle on relaxing tyres instead of knife edges without slip.

The bodies are those of `vehicle_fmu.components.bicycle`; their motion to the side is that of
`vehicle_fmu.out_of_plane`, with the freedoms v, r, phi and the steer delta about the axis (sin eps, cos eps) through
(w_b + c, 0). The wheels are discs, and both tyres have the side force

    (sigma / V) Y' + Y = Z (C_1 alpha + C_2 gamma)

at the load Z, with the slip angle alpha and the camber angle gamma, and relax as those of Sharp's motorcycle of 1971.
For C_1 -> infinity and sigma -> 0 the wheels roll without slip: then this is the bicycle of the benchmark, and the
error falls as 1 / C_1.

Source: bodies: Meijaard, Papadopoulos, Ruina, Schwab, Proc. R. Soc. A 463 (2007) 1955-1982; tyres: Sharp, J. Mech. Eng.
Sci. 13(5) (1971) 316-329.
"""

from typing import Any

from fmus import local, parameter
from vehicle_fmu.bicycle_bodies import BicycleBodies
from vehicle_fmu.out_of_plane import (
    GROUND,
    Body,
    Freedom,
    Point,
    heading,
    inertia_force,
    lateral_velocity,
    mass_matrix,
    side_force,
    tilt,
    vertical_force,
)
from vehicle_fmu.relaxing_tyres import RelaxingTyres, relaxed
from vehicle_fmu.steered_vehicle import SidewaysMotion, port_motion, port_torques


class BicycleOnTyres(SidewaysMotion, BicycleBodies, RelaxingTyres):
    """Bicycle of four rigid bodies on two relaxing tyres."""

    front_cornering_coefficient = parameter("1/rad", "Side force per slip angle and load of the front tyre", symbol="C_{f1}",
                                            min=0, max=1e9, start=17.0)  # fmt: skip
    rear_cornering_coefficient = parameter("1/rad", "Side force per slip angle and load of the rear tyre", symbol="C_{r1}",
                                           min=0, max=1e9, start=17.0)  # fmt: skip
    front_camber_coefficient = parameter("1/rad", "Side force per camber angle and load of the front tyre", symbol="C_{f2}",
                                         min=-100, max=100, start=0.6)  # fmt: skip
    rear_camber_coefficient = parameter("1/rad", "Side force per camber angle and load of the rear tyre", symbol="C_{r2}",
                                        min=-100, max=100, start=0.6)  # fmt: skip

    front_load = local("N", "Load on the front tyre", symbol="Z_f")
    rear_load = local("N", "Load on the rear tyre", symbol="Z_r")

    def mass(self, v, m):
        body = bodies(v, m)
        return mass_matrix(body, list(body[-1].path))

    def equations(self, v, m):
        body = bodies(v, m)
        moment, weight = (v.gravity * sum(b.mass * x for b, x in zip(body, lever, strict=True))
                          for lever in ([b.centre[0] for b in body], [1.0] * len(body)))  # fmt: skip
        v.front_load = moment / v.wheelbase
        v.rear_load = weight - v.front_load
        v.head_torque = v.steering_damping * v.steer_rate
        contacts: dict[str, Point] = {"rear": (0, 0), "front": (v.wheelbase, 0)}
        paths = {"rear": GROUND, "front": body[-1].path}
        derivatives: dict[str, Any] = {f"der({end}_side_force)": tyre(v, end, paths[end], contacts[end]) for end in contacts}
        torques = port_torques(v, m)
        for j in body[-1].path:
            force = torques[j.rate] + inertia_force(j, body, v)
            force += sum(vertical_force(j, b.path, b.centre, b.mass * v.gravity, v) for b in body)
            for end, contact in contacts.items():
                force += vertical_force(j, paths[end], contact, -v[f"{end}_load"], v)
                force += side_force(j, paths[end], contact, v[f"{end}_side_force"])
            derivatives[f"der({j.rate})"] = force
            if j.angle:
                derivatives[f"der({j.angle})"] = v[j.rate]
        return {**derivatives, **port_motion(v, m)}


def bodies(v: Any, m: Any) -> list[Body]:
    """Rear wheel, rear frame, front frame with the inertia that a rider adds, front wheel."""
    c, S, share = m.cos(v.caster_angle), m.sin(v.caster_angle), v.added_steer_inertia
    front = (*GROUND, Freedom("steer_rate", "steer_angle", (S, c), (v.wheelbase + v.ground_trail, 0)))
    return [
        Body(GROUND, v.rear_wheel_mass, (0, -v.rear_wheel_radius), v.rear_wheel_inertia, v.rear_wheel_inertia, 0,
             v.rear_spin_inertia * v.speed / v.rear_wheel_radius),
        Body(GROUND, v.rear_frame_mass, (v.rear_frame_x, v.rear_frame_z), v.rear_frame_xx, v.rear_frame_zz, -v.rear_frame_xz),
        Body(front, v.front_frame_mass, (v.front_frame_x, v.front_frame_z), v.front_frame_xx + share * S**2,
             v.front_frame_zz + share * c**2, -v.front_frame_xz - share * S * c),
        Body(front, v.front_wheel_mass, (v.wheelbase, -v.front_wheel_radius), v.front_wheel_inertia, v.front_wheel_inertia, 0,
             v.front_spin_inertia * v.speed / v.front_wheel_radius),
    ]  # fmt: skip


def tyre(v: Any, end: str, path: tuple[Freedom, ...], contact: Point) -> Any:
    """The rate of the side force of a tyre; sets its slip and camber angle."""
    setattr(v, f"{end}_slip_angle", heading(path, v) - lateral_velocity(path, contact, v) / v.speed)
    setattr(v, f"{end}_camber_angle", tilt(path, v))
    steady = v[f"{end}_load"] * (v[f"{end}_cornering_coefficient"] * v[f"{end}_slip_angle"]
                                 + v[f"{end}_camber_coefficient"] * v[f"{end}_camber_angle"])  # fmt: skip
    return relaxed(v, end, steady)
