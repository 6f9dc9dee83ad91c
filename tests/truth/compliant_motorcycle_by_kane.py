"""Sharp's motorcycle of 1994 derived a second time: rigid bodies in full nonlinear motion, Kane's equations, linearised.

Nothing of the package is used. Points and symbols are those of the published parameter file: p1 to p12 in the nominal
configuration, x forward, z down, the origin on the ground below the rear frame's mass centre.

- the wheels are discs; the ground touches each at its lowest point, wherever its centre and its plane are;
- the forces of a tyre act there: load, side force across the heading, longitudinal force along it; moments about the
  vertical and about the heading;
- drag and lift act at p12 of the rear frame, along the yawing axes.
"""

import numpy as np
import sympy as sp
from sympy.physics.mechanics import Force, KanesMethod, Point, ReferenceFrame, Torque, dynamicsymbols, inertia, outer

from tests.truth.motorcycle_by_kane import rigid

PARAMETERS = sp.symbols(
    "Mf Mr Mb Mp Ifx Ifz Ifxz Irx Irz Irxz Ipx Ipz Ipxz irwx irwy ifwy iry aa bb bb_b bb_p ee hh hh_b hh_p hh_s jj ll Rf Rr ss"
    " trail epsilon epsilon1 epsilon_I epsilon_t eta hh_cp k_v D_v k_lamda D_lamda k_gamma D_gamma k_zita D_zita k_steer D_steer"
    " g V Zf Zr Cfvf Cfvr Cf1 Cr1 Cmvf Cmvr Cf2 Cr2 Cf3 Cr3 sigmaf sigmar share drag lift resistance",
    real=True,
)
ANGLES = ("phi", "d", "gamma", "delta", "lamda", "zeta")
STATES = ("v", "r", "p", "dd", "b", "s", "q", "w", *ANGLES, "Y_f", "Y_r", "M_f", "M_r")
INPUTS = ("T_h", "T_f", "T_d", "T_phi", "F")


def derive():
    """Functions of PARAMETERS: M (18, 18), and f (18,) of a vector of states and inputs before them, for M x' = f.

    share is the part of the moment about z that relaxes; the state M is the whole relaxed moment.
    """
    (Mf, Mr, Mb, Mp, Ifx, Ifz, Ifxz, Irx, Irz, Irxz, Ipx, Ipz, Ipxz, irwx, irwy, ifwy, iry, aa, bb, bb_b, bb_p, ee, hh, hh_b,
     hh_p, hh_s, jj, ll, Rf, Rr, ss, trail, epsilon, epsilon1, epsilon_I, epsilon_t, eta, hh_cp, k_v, D_v, k_lamda, D_lamda,
     k_gamma, D_gamma, k_zita, D_zita, k_steer, D_steer, g, V, Zf, Zr, Cfvf, Cfvr, Cf1, Cr1, Cmvf, Cmvr, Cf2, Cr2, Cf3, Cr3,
     sigmaf, sigmar, share, drag, lift, resistance) = PARAMETERS  # fmt: skip
    psi, y, phi, d, gamma, delta, lamda, zeta = dynamicsymbols("psi y phi d gamma delta lamda zeta")
    v, r, p, dd, b, s, q, w = dynamicsymbols("v r p dd b s q w")
    Y_f, Y_r, M_f, M_r, T_h, T_f, T_d, T_phi, F = sp.symbols("Y_f Y_r M_f M_r T_h T_f T_d T_phi F")

    ground = ReferenceFrame("N")
    heading = turned(ground, "heading", ground.z, psi, r)
    rear = turned(heading, "rear", heading.x, phi, p)
    steer_axis = fixed(rear, "steer axis", epsilon)
    twist_axis = fixed(rear, "head twist axis", eta)
    twisted = turned(twist_axis, "twisted", twist_axis.x, gamma, b)
    column = fixed(twisted, "column", epsilon - eta)
    front = turned(column, "front", column.z, delta, s)
    assembly_axis = fixed(rear, "assembly twist axis", epsilon_t)
    assembly_turned = turned(assembly_axis, "assembly turned", assembly_axis.z, lamda, q)
    assembly = fixed(assembly_turned, "assembly", -epsilon_t)
    upper = turned(rear, "upper", rear.x, zeta, w)

    kk = ll + (ee + trail - jj * sp.sin(epsilon)) / sp.cos(epsilon)
    p8 = (ll + trail / sp.cos(epsilon) - ss * sp.tan(epsilon), -ss)
    p7 = (-bb + aa * sp.cos(epsilon1), -aa * sp.sin(epsilon1))
    foot = Point("A")
    foot.set_vel(ground, V * heading.x + v * heading.y)

    def place(name, base, frame, at, relative_to=(0, 0)):
        """A point of a body that is at (x, z) nominally, where the frame is aligned with the vehicle then."""
        point = base.locatenew(name, (at[0] - relative_to[0]) * frame.x + (at[1] - relative_to[1]) * frame.z)
        point.v2pt_theory(base, ground, frame)
        return point

    upright_front = fixed(front, "front, upright", -epsilon)
    p1 = place("p1", foot, rear, (0, -hh))
    p12 = place("p12", foot, rear, ((ll - bb) / 2, -hh_cp))
    joint = place("p7", foot, rear, p7)
    saddle = place("p9", foot, rear, (-bb_p, -hh_s))
    head = place("p8", foot, rear, p8)
    front_head = head.locatenew("p8 of the front frame", d * rear.y)
    front_head.set_vel(ground, head.vel(ground) + dd * rear.y + d * rear.ang_vel_in(ground).cross(rear.y))
    p3 = place("p3", front_head, upright_front, (kk, -jj), p8)
    p6 = place("p6", front_head, upright_front, (ll, -Rf), p8)
    p2 = place("p2", joint, assembly, (-bb_b, -hh_b), p7)
    p5 = place("p5", joint, assembly, (-bb, -Rr), p7)
    p4 = place("p4", saddle, upper, (-bb_p, -hh_s - hh_p), (-bb_p, -hh_s))

    own = fixed(front, "inertia axes of the front frame", epsilon_I - epsilon)
    front_wheel, rear_wheel, engine = (ReferenceFrame(n) for n in ("front wheel", "rear wheel", "engine"))
    front_wheel.set_ang_vel(front, -V / Rf * front.y)
    rear_wheel.set_ang_vel(assembly, -V / Rr * assembly.y)
    engine.set_ang_vel(rear, -V / Rr * rear.y)
    bodies = [
        rigid("rear frame", p1, rear, Mr, inertia(rear, Irx, 0, Irz, 0, 0, -Irxz)),
        rigid("engine", p1, engine, 0, iry * outer(rear.y, rear.y)),
        rigid("front frame", p3, front, Mf, inertia(own, Ifx, 0, Ifz, 0, 0, Ifxz)),
        rigid("front wheel", p6, front_wheel, 0, ifwy * outer(front.y, front.y)),
        rigid("rear wheel assembly", p2, assembly, Mb, inertia(assembly, irwx, 0, irwx)),
        rigid("rear wheel", p5, rear_wheel, 0, irwy * outer(assembly.y, assembly.y)),
        rigid("upper body", p4, upper, Mp, inertia(upper, Ipx, 0, Ipz, 0, 0, -Ipxz)),
    ]
    contact_f, slip_f, camber_f, forward_f, side_f = disc(p6, front, Rf, ground)
    contact_r, slip_r, camber_r, forward_r, side_r = disc(p5, assembly, Rr, ground)
    moments = {"f": -Cmvf * slip_f + Cf2 * camber_f, "r": -Cmvr * slip_r + Cr2 * camber_r}
    turn_f, turn_r = share * M_f + (1 - share) * moments["f"], share * M_r + (1 - share) * moments["r"]
    twist_torque, assembly_torque = k_gamma * gamma + D_gamma * b, k_lamda * lamda + D_lamda * q
    lean_torque, steer_torque, slide = k_zita * zeta + D_zita * w, k_steer * delta + D_steer * s, k_v * d + D_v * dd
    weights = [(p1, Mr), (p3, Mf), (p2, Mb), (p4, Mp)]
    loads = [
        *(Force(point, mass * g * ground.z) for point, mass in weights),
        Force(contact_f, -Zf * ground.z + Y_f * side_f - resistance * forward_f),
        Force(contact_r, -Zr * ground.z + Y_r * side_r + (drag + resistance) * forward_r),
        Force(p12, -lift * ground.z - drag * heading.x),
        Force(foot, F * heading.y), Force(front_head, -slide * rear.y), Force(head, slide * rear.y),
        Torque(front, T_h * front.z + (T_d - steer_torque) * front.z + turn_f * ground.z + Cf3 * camber_f * forward_f),
        Torque(twisted, (steer_torque - T_d) * front.z - twist_torque * twist_axis.x),
        Torque(rear, T_f * steer_axis.z + T_phi * rear.x + twist_torque * twist_axis.x + assembly_torque * assembly_axis.z
               + lean_torque * rear.x),
        Torque(assembly, -assembly_torque * assembly_axis.z + turn_r * ground.z + Cr3 * camber_r * forward_r),
        Torque(upper, -lean_torque * rear.x),
    ]  # fmt: skip
    speeds, angles = [v, r, p, dd, b, s, q, w], [y, psi, phi, d, gamma, delta, lamda, zeta]
    kane = KanesMethod(ground, angles, speeds, [a.diff() - u for a, u in zip(angles, speeds, strict=True)])
    kane.kanes_equations(bodies, loads)
    rates = [*kane.forcing, p, dd, b, s, q, w,
             V / sigmaf * (Cfvf * slip_f + Cf1 * camber_f - Y_f), V / sigmar * (Cfvr * slip_r + Cr1 * camber_r - Y_r),
             V / sigmaf * (moments["f"] - M_f), V / sigmar * (moments["r"] - M_r)]  # fmt: skip
    unknowns = [*speeds, phi, d, gamma, delta, lamda, zeta, Y_f, Y_r, M_f, M_r, T_h, T_f, T_d, T_phi, F]
    straight = dict.fromkeys([*unknowns, psi, y], sp.S.Zero)
    mass = sp.diag(kane.mass_matrix.xreplace(straight), sp.eye(10))
    symbols = [sp.Symbol(f"x_{i}") for i in range(len(unknowns))]
    force = sp.Matrix(rates).xreplace({**dict(zip(unknowns, symbols, strict=True)), psi: sp.S.Zero, y: sp.S.Zero})
    return sp.lambdify(PARAMETERS, mass, "numpy", cse=True), sp.lambdify([symbols, *PARAMETERS], force, "numpy", cse=True)


def linearised(derived, arguments):
    """d x' / d (states, inputs) (18, 23) at straight running, from what `derive` returns; derivatives by complex
    steps."""
    mass, force = derived
    count, step = len(STATES) + len(INPUTS), 1e-30
    slopes = [force(step * 1j * np.eye(count)[i], *arguments).imag[:, 0] / step for i in range(count)]
    return np.linalg.solve(mass(*arguments), np.transpose(slopes))


def turned(base, name, axis, angle, rate):
    """A frame that turns on its base about an axis of it."""
    frame = base.orientnew(name, "Axis", (angle, axis))
    frame.set_ang_vel(base, rate * axis)
    return frame


def fixed(base, name, lean):
    """A frame fixed in its base, leant back by an angle."""
    frame = base.orientnew(name, "Axis", (lean, base.y))
    frame.set_ang_vel(base, 0 * base.y)
    return frame


def disc(centre, wheel, radius, ground):
    """The lowest point of a disc across `wheel.y`; its slip and camber angle; the directions of heading and side
    force."""
    forward = wheel.y.cross(ground.z).normalize()
    side = ground.z.cross(forward)
    down = forward.cross(wheel.y)
    contact = centre.locatenew(f"contact of {wheel.name}", radius * down)
    contact.set_vel(ground, centre.vel(ground) + wheel.ang_vel_in(ground).cross(radius * down))
    velocity = contact.vel(ground)
    return contact, -sp.atan(velocity.dot(side) / velocity.dot(forward)), sp.asin(wheel.y.dot(ground.z)), forward, side
