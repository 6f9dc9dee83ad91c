"""The full rider a second time: every body placed by angles, Lagrange's equations from the energies.

The elbow lies in the plane through shoulder, wrist and the wrist's axis, at the angle of the law of cosines from
the line to the wrist. Velocities by complex steps, slopes of the energies by differences of sixth order.
"""

import numpy as np

STEP = 1e-30
WIDTH = 2e-3
SIXTH = ((1, 45 / 60), (2, -9 / 60), (3, 1 / 60))


def turn(axis, angle):
    """The matrix of a rotation about a unit axis, also for complex angles."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def length(a):
    return np.sqrt(np.sum(a * a))  # of complex vectors too, analytically


def places(p, q):
    """Frame of the vehicle (x forward, y right, z down) with its origin at the saddle: points of both arms by side."""
    eps, beta = p["steer_tilt"], p["torso_inclination"]
    steer_axis, waist_axis = np.array([np.sin(eps), 0, np.cos(eps)]), np.array([-np.sin(beta), 0, np.cos(beta)])
    forward = np.array([np.cos(eps), 0, -np.sin(eps)])
    head, hips = np.array([p["saddle_distance"], 0, -p["saddle_drop"]]), np.array([0, 0, -p["hip_rise"]])
    across = np.array([0.0, 1.0, 0.0])
    bar, torso = turn(steer_axis, q[0]), turn(waist_axis, q[1])
    arms = []
    for side in (1, -1):
        shoulder = hips + torso @ (side * p["shoulder_half_width"] * across - p["torso_length"] * waist_axis)
        wrist = head + bar @ (
            side * p["grip_half_width"] * across - p["grip_setback"] * forward - p["grip_rise"] * steer_axis
        )
        axis = bar @ (side * np.sin(p["elbow_spread"]) * across + np.cos(p["elbow_spread"]) * steer_axis)
        a, b = p["upper_arm_length"], p["forearm_length"]
        d = length(wrist - shoulder)
        line = (wrist - shoulder) / d
        beside = axis - line * np.sum(axis * line)
        beside = beside / length(beside)
        cosine = (a * a + d * d - b * b) / (2 * a * d)
        elbow = shoulder + a * (cosine * line + np.sqrt(1 - cosine**2) * beside)
        arms.append((shoulder, elbow, wrist))
    return arms, bar, torso, steer_axis


def motions(p, q):
    """(coefficient, vector) of everything that has kinetic energy: c |v|^2 / 2."""
    arms, *_ = places(p, q)
    found = []
    for shoulder, elbow, wrist in arms:
        for limb, start, end in (("upper_arm", shoulder, elbow), ("forearm", elbow, wrist)):
            direction = (end - start) / p[f"{limb}_length"]
            found += [(p[f"{limb}_mass"], start + p[f"{limb}_centre"] * direction), (p[f"{limb}_inertia"], direction)]
    return found


def mass_matrix(p, q):
    slopes = []
    for i in range(2):
        shifted = q.astype(complex)
        shifted[i] += 1j * STEP
        slopes.append([x.imag / STEP for _, x in motions(p, shifted)])
    coefficients = [c for c, _ in motions(p, q)]
    M = np.array(
        [[sum(c * np.dot(a, b) for c, a, b in zip(coefficients, x, y, strict=True)) for y in slopes] for x in slopes]
    )
    return M + np.diag([p["hands_inertia"] + p.get("bar_inertia", 0.0), p["trunk_inertia"]])


def deflections(p, q):
    """(joint, vector) of every joint: the elbow's angle, and limb directions against where their carrier would hold
    them."""
    rest, *_ = places(p, np.zeros(2))
    arms, bar, torso, _ = places(p, q)
    found = []
    for (S, E, W), (S0, E0, W0) in zip(arms, rest, strict=True):
        found.append(("elbow", np.array([bend(S, E, W) - bend(S0, E0, W0)])))
        found.append(("shoulder", (E - S) / length(E - S) - torso @ (E0 - S0) / length(E0 - S0)))
        found.append(("wrist", (W - E) / length(W - E) - bar @ (W0 - E0) / length(W0 - E0)))
    return found


def bend(S, E, W):
    return np.arccos(np.sum((S - E) * (W - E)) / (length(S - E) * length(W - E)))


def potential(p, q):
    """Energy of springs and weights, the waist's included [J]."""
    arms, *_ = places(p, q)
    energy = p["waist_stiffness"] * q[1] ** 2 / 2
    energy = energy + sum(p[f"{joint}_stiffness"] * np.sum(d * d) / 2 for joint, d in deflections(p, q))
    for S, E, W in arms:
        upper = S + (E - S) * p["upper_arm_centre"] / p["upper_arm_length"]
        fore = E + (W - E) * p["forearm_centre"] / p["forearm_length"]
        energy = energy - p["gravity"] * (
            p["upper_arm_mass"] * upper[2] + p["forearm_mass"] * fore[2] + p["hand_mass"] * W[2]
        )
    return energy


def slope(function, q, i):
    """d function / d q_i by central differences of sixth order."""
    total = 0.0
    for k, weight in SIXTH:
        step = np.zeros(2)
        step[i] = k * WIDTH
        total = total + weight * (function(q + step) - function(q - step))
    return total / WIDTH


def equations(p, q, u):
    """(M, f) of M q'' = f without the servo's torque."""
    M = mass_matrix(p, q)
    M_slopes = [slope(lambda x: mass_matrix(p, x), q, i) for i in range(2)]
    changing = M_slopes[0] * u[0] + M_slopes[1] * u[1]
    force = np.array([u @ M_slopes[i] @ u / 2 for i in range(2)]) - changing @ u
    shifted = q + 1j * STEP * u
    speeds = [(joint, d.imag / STEP) for joint, d in deflections(p, shifted)]
    for i in range(2):
        along = q.astype(complex)
        along[i] += 1j * STEP
        force[i] -= potential(p, along).imag / STEP
        force[i] -= sum(
            p[f"{joint}_damping"] * np.dot(d.imag / STEP, s)
            for (joint, d), (_, s) in zip(deflections(p, along), speeds, strict=True)
        )
    force[1] -= p["waist_damping"] * u[1]
    return M, force
