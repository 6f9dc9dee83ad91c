"""The motorcycle derived a second time: rigid bodies in full nonlinear motion, Kane's equations, then linearised.

Nothing of the package is used. A rear and a front frame with a spinning rotor each, and the tyre's forces at the
contact point of each wheel:

- the point A on the ground below the rear mass centre moves at V forward (held) and v to the right, in axes that
  yaw at r; the rear frame rolls by phi about the ground line through A, the front frame turns by delta about the
  steer axis, which leans back by eps;
- a wheel spins at -V / R about the axis across its frame (y to the right, z down, rolling forwards); its polar
  inertia is the only property it has besides its frame's;
- a lateral force F acts at A;
- the load Z_f acts vertically, the side force Y_f across the wheel's heading, both at the front contact, a point
  of the front frame at the trail t behind the steer axis; the rear contact lies on the roll axis, b behind A;
- slip and camber come from the contact's velocity, the wheel's heading and its plane, in closed nonlinear form.

Heave and pitch are left out: they are of second order in straight running.
"""

import sympy as sp
from sympy.physics.mechanics import (
    Dyadic,
    Force,
    KanesMethod,
    Point,
    ReferenceFrame,
    RigidBody,
    Torque,
    dynamicsymbols,
    inertia,
    outer,
)

PARAMETERS = sp.symbols(
    "M_f M_r Z_f I_rx I_rz C_rxz I_fx I_fz I_fxz i_fy i_ry R_f R_r a b e f h t eps C_f1 C_f2 C_r1 C_r2 sigma_f sigma_r K g V",
    real=True,
)
STATES = ("v", "r", "p", "s", "phi", "delta", "Y_f", "Y_r")
INPUTS = ("T_h", "T_f", "T_d", "T_phi", "F")


def derive():
    """Functions of the parameters, in the order of PARAMETERS: M (8, 8), and d f / d(states, inputs) (8, 13), for M x'
    = f."""
    (M_f, M_r, Z_f, I_rx, I_rz, C_rxz, I_fx, I_fz, I_fxz, i_fy, i_ry, R_f, R_r,
     a, b, e, f, h, t, eps, C_f1, C_f2, C_r1, C_r2, sigma_f, sigma_r, K, g, V) = PARAMETERS  # fmt: skip
    psi, y, phi, delta = dynamicsymbols("psi y phi delta")
    v, r, p, s = dynamicsymbols("v r p s")
    Y_f, Y_r, T_h, T_f, T_d, T_phi, F = sp.symbols("Y_f Y_r T_h T_f T_d T_phi F")

    ground = ReferenceFrame("N")
    heading = ground.orientnew("heading", "Axis", (psi, ground.z))
    heading.set_ang_vel(ground, r * ground.z)
    rear = heading.orientnew("rear", "Axis", (phi, heading.x))
    rear.set_ang_vel(heading, p * heading.x)
    column = rear.orientnew("column", "Axis", (eps, rear.y))
    column.set_ang_vel(rear, 0 * rear.y)
    front = column.orientnew("front", "Axis", (delta, column.z))
    front.set_ang_vel(column, s * column.z)

    rear_foot = Point("A")
    rear_foot.set_vel(ground, V * heading.x + v * heading.y)
    rear_centre = rear_foot.locatenew("rear centre", -h * rear.z)
    axis = rear_foot.locatenew("foot of a on the steer axis", a * column.x)
    front_centre = axis.locatenew("front centre", e * front.x - f * front.z)
    front_contact = axis.locatenew("front contact", -t * front.x + (a - t) * sp.tan(eps) * front.z)
    rear_contact = rear_foot.locatenew("rear contact", -b * heading.x)
    rear_centre.v2pt_theory(rear_foot, ground, rear)
    axis.v2pt_theory(rear_foot, ground, rear)
    for point in (front_centre, front_contact):
        point.v2pt_theory(axis, ground, front)
    rear_contact.v2pt_theory(rear_foot, ground, heading)

    rear_wheel = ReferenceFrame("rear wheel")
    rear_wheel.set_ang_vel(rear, -V / R_r * rear.y)
    front_wheel = ReferenceFrame("front wheel")
    front_wheel.set_ang_vel(front, -V / R_f * front.y)
    bodies = [
        rigid("rear frame", rear_centre, rear, M_r, inertia(rear, I_rx, 0, I_rz, 0, 0, -C_rxz)),
        rigid("front frame", front_centre, front, M_f, inertia(front, I_fx, 0, I_fz, 0, 0, I_fxz)),
        rigid("rear wheel", rear_centre, rear_wheel, 0, i_ry * outer(rear.y, rear.y)),
        rigid("front wheel", front_centre, front_wheel, 0, i_fy * outer(front.y, front.y)),
    ]

    front_slip, front_camber, front_side = tyre(front_contact, front, ground)
    rear_slip, rear_camber, rear_side = tyre(rear_contact, rear, ground)
    loads = [
        Force(rear_centre, M_r * g * ground.z), Force(front_centre, M_f * g * ground.z),
        Force(front_contact, Z_f * ground.z + Y_f * front_side), Force(rear_contact, Y_r * rear_side), Force(rear_foot, F * heading.y),
        Torque(front, (T_h + T_d - K * s) * front.z), Torque(rear, (T_f - T_d + K * s) * front.z + T_phi * rear.x),
    ]  # fmt: skip
    speeds = [v, r, p, s]
    kane = KanesMethod(
        ground, [y, psi, phi, delta], speeds, [y.diff() - v, psi.diff() - r, phi.diff() - p, delta.diff() - s]
    )
    kane.kanes_equations(bodies, loads)
    rates = [*kane.forcing, p, s,
             V / sigma_f * (C_f1 * front_slip + C_f2 * front_camber - Y_f),
             V / sigma_r * (C_r1 * rear_slip + C_r2 * rear_camber - Y_r)]  # fmt: skip

    unknowns = [v, r, p, s, phi, delta, Y_f, Y_r, T_h, T_f, T_d, T_phi, F]
    straight = dict.fromkeys([*unknowns, psi], sp.S.Zero)
    slopes = sp.Matrix([[slope(rate, unknown, straight) for unknown in unknowns] for rate in rates])
    mass = sp.diag(kane.mass_matrix.xreplace(straight), sp.eye(4))
    return tuple(sp.lambdify(PARAMETERS, m, "numpy", cse=True) for m in (mass, slopes))


def slope(expression: sp.Expr, unknown: sp.Expr, straight: dict) -> sp.Expr:
    """d expression / d unknown in straight running. The others are zero from the start, which keeps it short."""
    symbol = sp.Symbol("unknown")
    return expression.xreplace({**straight, unknown: symbol}).diff(symbol).xreplace({symbol: sp.S.Zero})


def rigid(name: str, centre: Point, frame: ReferenceFrame, mass: sp.Expr, about_centre: Dyadic) -> RigidBody:
    """A rigid body with its inertia about its mass centre."""
    return RigidBody(name, centre, frame, mass, (about_centre, centre))


def tyre(contact: Point, wheel: ReferenceFrame, ground: ReferenceFrame):
    """Slip angle, camber angle, and the direction of the side force, of a wheel that stands across `wheel.y`."""
    forward = wheel.y.cross(ground.z).normalize()
    side = ground.z.cross(forward)
    velocity = contact.vel(ground)
    slip = -sp.atan(velocity.dot(side) / velocity.dot(forward))
    camber = sp.asin(wheel.y.dot(ground.z))
    return slip, camber, side
