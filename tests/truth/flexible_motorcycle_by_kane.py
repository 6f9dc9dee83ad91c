"""The motorcycle with a front frame that twists at the steering head and a rider who leans, by Kane's equations.

Nothing of the package is used. Beside what `motorcycle_by_kane` says:

- the steer axis is carried by a part that turns by beta about an axis of the rear frame, across the steer axis, through
  the point of the steer axis at the height z_t above the foot of a; a spring 1/C and a damper d hold it;
- the upper body, of mass m_u and radius of gyration rho in roll, turns by theta about an axis of the rear frame along x
  at the height h_s; its mass and inertia are taken out of the rear frame, so that held stiff it changes nothing.
"""

import sympy as sp
from sympy.physics.mechanics import Force, KanesMethod, Point, ReferenceFrame, Torque, dynamicsymbols, inertia, outer

from tests.truth.motorcycle_by_kane import rigid, slope, tyre

PARAMETERS = sp.symbols(
    "M_f M_r Z_f I_rx I_rz C_rxz I_fx I_fz I_fxz i_fy i_ry R_f R_r a b e f h t eps C_f1 C_f2 C_r1 C_r2 sigma_f sigma_r K g V"
    " C d z_t m_u rho h_s c_r x_r k_u d_u", real=True
)  # fmt: skip
STATES = ("v", "r", "p", "s", "b", "q", "phi", "delta", "beta", "theta", "Y_f", "Y_r")


def derive():
    """Functions of the parameters: M (12, 12) and d f / d states (12, 12), for M x' = f; k_u holds the body against its
    weight too."""
    (M_f, M_r, Z_f, I_rx, I_rz, C_rxz, I_fx, I_fz, I_fxz, i_fy, i_ry, R_f, R_r, a, b_r, e, f, h, t, eps, C_f1, C_f2, C_r1, C_r2,
     sigma_f, sigma_r, K, g, V, C, d, z_t, m_u, rho, h_s, c_r, x_r, k_u, d_u) = PARAMETERS  # fmt: skip
    psi, y, phi, delta, beta, theta = dynamicsymbols("psi y phi delta beta theta")
    v, r, p, s, b, q = dynamicsymbols("v r p s b q")
    Y_f, Y_r = sp.symbols("Y_f Y_r")

    ground = ReferenceFrame("N")
    heading = ground.orientnew("heading", "Axis", (psi, ground.z))
    heading.set_ang_vel(ground, r * ground.z)
    rear = heading.orientnew("rear", "Axis", (phi, heading.x))
    rear.set_ang_vel(heading, p * heading.x)
    column = rear.orientnew("column", "Axis", (eps, rear.y))
    column.set_ang_vel(rear, 0 * rear.y)
    head = column.orientnew("head", "Axis", (beta, column.x))
    head.set_ang_vel(column, b * column.x)
    front = head.orientnew("front", "Axis", (delta, head.z))
    front.set_ang_vel(head, s * head.z)
    upper = rear.orientnew("upper", "Axis", (theta, rear.x))
    upper.set_ang_vel(rear, q * rear.x)

    rear_foot = Point("A")
    rear_foot.set_vel(ground, V * heading.x + v * heading.y)
    hinge = rear_foot.locatenew("hinge of the head", a * column.x - z_t * column.z)
    axis = hinge.locatenew("foot of a on the steer axis", z_t * head.z)
    front_centre = axis.locatenew("front centre", e * front.x - f * front.z)
    front_contact = axis.locatenew("front contact", -t * front.x + (a - t) * sp.tan(eps) * front.z)
    rear_contact = rear_foot.locatenew("rear contact", -b_r * heading.x)
    saddle = rear_foot.locatenew("hinge of the rider", x_r * rear.x - h_s * rear.z)
    upper_centre = saddle.locatenew("upper centre", -c_r * upper.z)
    stiff_centre = saddle.locatenew("where the upper centre is held stiff", -c_r * rear.z)
    rear_centre = rear_foot.locatenew("rear centre", -h * rear.z)
    for point in (hinge, saddle, stiff_centre, rear_centre):
        point.v2pt_theory(rear_foot, ground, rear)
    axis.v2pt_theory(hinge, ground, head)
    for point in (front_centre, front_contact):
        point.v2pt_theory(axis, ground, front)
    upper_centre.v2pt_theory(saddle, ground, upper)
    rear_contact.v2pt_theory(rear_foot, ground, heading)

    rear_wheel = ReferenceFrame("rear wheel")
    rear_wheel.set_ang_vel(rear, -V / R_r * rear.y)
    front_wheel = ReferenceFrame("front wheel")
    front_wheel.set_ang_vel(front, -V / R_f * front.y)
    bodies = [
        rigid("rear frame", rear_centre, rear, M_r, inertia(rear, I_rx, 0, I_rz, 0, 0, -C_rxz)),
        rigid("what the upper body was", stiff_centre, rear, -m_u, inertia(rear, -m_u * rho**2, 0, 0)),
        rigid("upper body", upper_centre, upper, m_u, inertia(upper, m_u * rho**2, 0, 0)),
        rigid("front frame", front_centre, front, M_f, inertia(front, I_fx, 0, I_fz, 0, 0, I_fxz)),
        rigid("rear wheel", rear_centre, rear_wheel, 0, i_ry * outer(rear.y, rear.y)),
        rigid("front wheel", front_centre, front_wheel, 0, i_fy * outer(front.y, front.y)),
    ]
    front_slip, front_camber, front_side = tyre(front_contact, front, ground)
    rear_slip, rear_camber, rear_side = tyre(rear_contact, rear, ground)
    twisting, leaning = beta / C + d * b, (k_u + m_u * g * c_r) * theta + d_u * q
    loads = [
        Force(rear_centre, M_r * g * ground.z), Force(front_centre, M_f * g * ground.z), Force(upper_centre, m_u * g * ground.z),
        Force(stiff_centre, -m_u * g * ground.z), Force(front_contact, Z_f * ground.z + Y_f * front_side), Force(rear_contact, Y_r * rear_side),
        Torque(front, -K * s * front.z), Torque(head, K * s * front.z - twisting * column.x), Torque(rear, twisting * column.x + leaning * rear.x),
        Torque(upper, -leaning * rear.x),
    ]  # fmt: skip
    speeds, angles = [v, r, p, s, b, q], [y, psi, phi, delta, beta, theta]
    kane = KanesMethod(
        ground, angles, speeds, [angle.diff() - rate for angle, rate in zip(angles, speeds, strict=True)]
    )
    kane.kanes_equations(bodies, loads)
    rates = [*kane.forcing, p, s, b, q,
             V / sigma_f * (C_f1 * front_slip + C_f2 * front_camber - Y_f),
             V / sigma_r * (C_r1 * rear_slip + C_r2 * rear_camber - Y_r)]  # fmt: skip
    unknowns = [v, r, p, s, b, q, phi, delta, beta, theta, Y_f, Y_r]
    straight = dict.fromkeys([*unknowns, psi], sp.S.Zero)
    slopes = sp.Matrix([[slope(rate, unknown, straight) for unknown in unknowns] for rate in rates])
    mass = sp.diag(kane.mass_matrix.xreplace(straight), sp.eye(6))
    return tuple(sp.lambdify(PARAMETERS, m, "numpy", cse=True) for m in (mass, slopes))
