"""The touring motorcycle of TU Munich derived a second time: rigid bodies in full nonlinear motion, Kane's equations.

Nothing of the package is used. The tree of bodies and the points are those of the published model, with x forward and z
up there; here z is down. Each wheel is a torus: a rim circle with a round cross-section, as large as its centre is
high. It touches the ground at the lowest point of the cross-section around the lowest point of the rim circle, so that
a moment about the heading is not needed. The tyre forces are given by their slopes at the load, the slip angle relaxes.
"""

import numpy as np
import sympy as sp
from sympy.physics.mechanics import Force, KanesMethod, Point, Torque, dynamicsymbols, inertia, outer
from sympy.physics.mechanics import ReferenceFrame as Frame

from tests.truth.compliant_motorcycle_by_kane import fixed, turned
from tests.truth.motorcycle_by_kane import rigid

BODIES = ("frame", "lower_body", "upper_body", "upper_fork", "lower_fork", "front_wheel", "swingarm", "rear_wheel")
POINTS = ("frame", "lower_body", "steering_head", "swingarm_axis", "upper_body_joint", "upper_fork", "fork_joint",
          "lower_fork_joint", "front_wheel_centre", "swingarm_joint", "rear_wheel_centre")  # fmt: skip
CENTRE_HEIGHT = {  # the points on the way from the reference point down to the centre of each wheel
    "front": {"steering_head": -1, "upper_fork": -1, "fork_joint": -1, "lower_fork_joint": 1, "front_wheel_centre": -1},
    "rear": {"swingarm_axis": -1, "swingarm_joint": 1, "rear_wheel_centre": -1},
}
FLEXIBLE = ("frame_torsion", "fork_bending", "fork_torsion", "swingarm_torsion", "rider_slide", "rider_lean")
NAMES = (
    *(f"{p}_{axis}" for p in POINTS for axis in "xz"), *(f"{b}_{n}" for b in BODIES for n in ("mass", "xx", "zz", "xz")),
    *(f"{f}_{n}" for f in FLEXIBLE for n in ("stiffness", "damping")), "reference_height", "caster_angle",
    "upper_body_inclination", "upper_body_inertia_inclination", "front_wheel_radius", "rear_wheel_radius",
    "front_spin_inertia", "rear_spin_inertia", "front_section_radius", "rear_section_radius", "steering_damping", "gravity",
    "V", "drag", "lift", *(f"{end}_{n}" for end in ("front", "rear") for n in (
        "load", "cornering_stiffness", "camber_stiffness", "aligning_stiffness", "camber_moment_stiffness",
        "relaxation_length")),
)  # fmt: skip
PARAMETERS = sp.symbols(NAMES, real=True)
SPEEDS = ("lateral_velocity", "yaw_rate", "roll_rate", "frame_torsion_rate", "steer_rate", "fork_bending_rate",
          "fork_torsion_rate", "swingarm_torsion_rate", "rider_slide_rate", "rider_lean_rate")  # fmt: skip
ANGLES = ("roll_angle", "frame_torsion_position", "steer_angle", "fork_bending_position", "fork_torsion_position",
          "swingarm_torsion_position", "rider_slide_position", "rider_lean_position")  # fmt: skip
STATES = (*SPEEDS, *ANGLES, "front_relaxed_slip", "rear_relaxed_slip")
INPUTS = ("handlebar_torque", "frame_torque", "steer_torque", "roll_torque", "lateral_force")


def derive():
    """Functions of PARAMETERS: M (20, 20), and f (20,) of a vector of states and inputs before them, for M x' = f."""
    g = dict(zip(NAMES, PARAMETERS, strict=True))
    psi, y, *angles = dynamicsymbols("psi y phi beta delta mu nu lamda y_r zeta")
    phi, beta, delta, mu, nu, lamda, y_r, zeta = angles
    speeds = dynamicsymbols("u0:10")
    v, r, p, b, s, bend, twist, swing, slide, lean = speeds
    slip_states, inputs = sp.symbols("a_f a_r"), sp.symbols("T_h T_f T_d T_phi F")
    T_h, T_f, T_d, T_phi, F = inputs
    eps, theta = g["caster_angle"], g["upper_body_inclination"]

    ground = Frame("N")
    heading = turned(ground, "heading", ground.z, psi, r)
    rear = turned(heading, "rear", heading.x, phi, p)
    head_axes = fixed(rear, "head", eps)
    head_twisted = turned(head_axes, "head twisted", head_axes.x, beta, b)
    fork = turned(head_twisted, "fork", head_twisted.z, delta, s)
    bent = turned(fork, "bent", fork.x, mu, bend)
    lower = turned(bent, "lower", bent.z, nu, twist)
    fork_upright, lower_upright = fixed(fork, "fork upright", -eps), fixed(lower, "lower upright", -eps)
    arm = turned(rear, "arm", rear.x, lamda, swing)
    lean_axes = fixed(rear, "lean axes", -theta)
    body = turned(lean_axes, "body", lean_axes.x, zeta, lean)
    body_own = fixed(body, "inertia of the body", theta - g["upper_body_inertia_inclination"])

    foot = Point("A")
    foot.set_vel(ground, g["V"] * heading.x + v * heading.y)

    def place(name, base, frame, point, sign=1):
        """A point of a body at (x, z up) from another."""
        x, z = (g[f"{point}_{axis}"] for axis in "xz")
        found = base.locatenew(name, sign * (x * frame.x - z * frame.z))
        found.v2pt_theory(base, ground, frame)
        return found

    reference = foot.locatenew("reference", -g["reference_height"] * rear.z)
    reference.v2pt_theory(foot, ground, rear)
    head, pivot = place("head", reference, rear, "steering_head"), place("pivot", reference, rear, "swingarm_axis")
    saddle = place("saddle", reference, rear, "lower_body")
    rider = saddle.locatenew("rider", y_r * rear.y)
    rider.set_vel(ground, saddle.vel(ground) + slide * rear.y + y_r * rear.ang_vel_in(ground).cross(rear.y))
    centres = {"frame": place("frame", reference, rear, "frame", -1), "lower_body": rider,
               "upper_body": place("upper", rider, body, "upper_body_joint", -1),
               "upper_fork": place("upper fork", head, fork_upright, "upper_fork"),
               "swingarm": place("arm", pivot, arm, "swingarm_joint", -1)}  # fmt: skip
    joint = place("joint", centres["upper_fork"], fork_upright, "fork_joint")
    centres["lower_fork"] = place("lower fork", joint, lower_upright, "lower_fork_joint", -1)
    centres["front_wheel"] = place("front wheel", centres["lower_fork"], lower_upright, "front_wheel_centre")
    centres["rear_wheel"] = place("rear wheel", centres["swingarm"], arm, "rear_wheel_centre")
    axes = {"frame": (rear, rear), "lower_body": (rear, rear), "upper_body": (body, body_own), "upper_fork": (fork, fork),
            "lower_fork": (lower, lower), "front_wheel": (lower, lower_upright), "swingarm": (arm, arm),
            "rear_wheel": (arm, arm)}  # fmt: skip
    bodies = [rigid(n, centres[n], axes[n][0], g[f"{n}_mass"],
                    inertia(axes[n][1], g[f"{n}_xx"], 0, g[f"{n}_zz"], 0, 0, -g[f"{n}_xz"])) for n in BODIES]  # fmt: skip

    tyres = {}
    for end, carrier in (("front", lower_upright), ("rear", arm)):
        rotor = Frame(f"{end} rotor")
        rotor.set_ang_vel(carrier, -g["V"] / g[f"{end}_wheel_radius"] * carrier.y)
        bodies.append(rigid(f"{end} rotor", centres[f"{end}_wheel"], rotor, 0,
                            g[f"{end}_spin_inertia"] * outer(carrier.y, carrier.y)))  # fmt: skip
        height = g["reference_height"] - sum(sign * g[f"{point}_z"] for point, sign in CENTRE_HEIGHT[end].items())
        tyres[end] = torus(centres[f"{end}_wheel"], carrier, height, g[f"{end}_section_radius"], ground)

    def reaction(name, position, rate):
        return g[f"{name}_stiffness"] * position + g[f"{name}_damping"] * rate

    torsion, bending = reaction("frame_torsion", beta, b), reaction("fork_bending", mu, bend)
    twisting, swinging = reaction("fork_torsion", nu, twist), reaction("swingarm_torsion", lamda, swing)
    leaning, sliding = reaction("rider_lean", zeta, lean), reaction("rider_slide", y_r, slide)
    steering = T_d - g["steering_damping"] * s
    loads = [Force(centres[n], g[f"{n}_mass"] * g["gravity"] * ground.z) for n in BODIES]
    loads += [
        Force(foot, F * heading.y), Force(reference, -g["lift"] * ground.z - g["drag"] * heading.x),
        Force(rider, -sliding * rear.y), Force(saddle, sliding * rear.y),
        Torque(rear, T_f * head_axes.z + T_phi * rear.x + torsion * head_axes.x + swinging * rear.x + leaning * lean_axes.x),
        Torque(head_twisted, -torsion * head_axes.x - steering * fork.z),
        Torque(fork, (T_h + steering) * fork.z + bending * fork.x), Torque(bent, -bending * fork.x + twisting * bent.z),
        Torque(lower, -twisting * bent.z), Torque(arm, -swinging * rear.x), Torque(body, -leaning * lean_axes.x),
    ]  # fmt: skip
    slips = []
    for (end, carrier), relaxed in zip((("front", lower), ("rear", arm)), slip_states, strict=True):
        contact, slip, camber, forward, side = tyres[end]
        force = g[f"{end}_cornering_stiffness"] * relaxed + g[f"{end}_camber_stiffness"] * camber
        moment = -g[f"{end}_aligning_stiffness"] * relaxed + g[f"{end}_camber_moment_stiffness"] * camber
        drive = g["drag"] if end == "rear" else 0
        loads += [Force(contact, -g[f"{end}_load"] * ground.z + force * side + drive * forward),
                  Torque(carrier, moment * ground.z)]  # fmt: skip
        slips.append(g["V"] / g[f"{end}_relaxation_length"] * (slip - relaxed))
    positions = [y, psi, *angles]
    kane = KanesMethod(ground, positions, speeds, [a.diff() - u for a, u in zip(positions, speeds, strict=True)])
    kane.kanes_equations(bodies, loads)
    unknowns = [*speeds, *angles, *slip_states, *inputs]
    straight = dict.fromkeys([*unknowns, psi, y], sp.S.Zero)
    mass = sp.diag(kane.mass_matrix.xreplace(straight), sp.eye(10))
    symbols = [sp.Symbol(f"x_{i}") for i in range(len(unknowns))]
    still = {psi: sp.S.Zero, y: sp.S.Zero}
    force = sp.Matrix([*kane.forcing, *speeds[2:], *slips]).xreplace({**dict(zip(unknowns, symbols, strict=True)), **still})
    return sp.lambdify(PARAMETERS, mass, "numpy", cse=True), sp.lambdify([symbols, *PARAMETERS], force, "numpy", cse=True)


def matrices(derived, arguments):
    """M (20, 20) and d f / d (states, inputs) (20, 25) at straight running; derivatives by complex steps."""
    mass, force = derived
    count, step = len(STATES) + len(INPUTS), 1e-30
    slopes = [force(step * 1j * np.eye(count)[i], *arguments).imag[:, 0] / step for i in range(count)]
    return np.asarray(mass(*arguments), float), np.transpose(slopes)


def torus(centre, wheel, radius, section, ground):
    """Contact of a torus across `wheel.y`: point, slip angle, camber angle, directions of heading and side force."""
    forward = wheel.y.cross(ground.z).normalize()
    side = ground.z.cross(forward)
    arm = (radius - section) * forward.cross(wheel.y) + section * ground.z
    contact = centre.locatenew(f"contact of {wheel.name}", arm)
    contact.set_vel(ground, centre.vel(ground) + wheel.ang_vel_in(ground).cross(arm))
    velocity = contact.vel(ground)
    return contact, -sp.atan(velocity.dot(side) / velocity.dot(forward)), sp.asin(wheel.y.dot(ground.z)), forward, side
