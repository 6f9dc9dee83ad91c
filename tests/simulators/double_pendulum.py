"""A double pendulum with a motor in each joint that a controller moves between poses, some of them upright, and the
recordings of its motors' torques and angles by scipy's `solve_ivp`, from Lagrange's equations in matrix form."""

from typing import ClassVar

import numpy as np
from scipy.integrate import solve_ivp

from fmus import Component, Element, input, local, parameter, state
from motofmi.recordings.recording import Recording

TRUE = {
    "inertia": 0.1, "elbow_inertia": 0.03, "coupling": 0.03, "weight": 3.4, "elbow_weight": 1.2, "damping": 0.05,
    "elbow_damping": 0.03,
}  # fmt: skip
STIFFNESS, DAMPING = np.array([10.0, 5.0]), np.array([0.8, 0.3])  # of the controller [N.m/rad], [N.m.s/rad]
HOLD, RATE = 1.5, 200.0  # s of a pose, Hz
SLIDING = 0.02  # rad/s, of the regularised friction


class DoublePendulum(Component):
    """Two links from hanging, the second angle relative to the first link."""

    inertia = parameter("kg.m2", "Inertia of the first link, with the mass of the second", min=0, start=0.08)
    elbow_inertia = parameter("kg.m2", "Inertia of the second link about its joint", min=0, start=0.02)
    coupling = parameter("kg.m2", "Coupling of both links", min=0, start=0.02)
    weight = parameter("N.m", "Weight moment of the first link", min=0, start=2.5)
    elbow_weight = parameter("N.m", "Weight moment of the second link", min=0, start=1.0)
    damping = parameter("N.m.s/rad", "Damping of the first joint", min=0, start=0.1)
    elbow_damping = parameter("N.m.s/rad", "Damping of the second joint", min=0, start=0.1)
    torque = input("N.m", "Torque of the first motor")
    elbow_torque = input("N.m", "Torque of the second motor")
    angle = state("rad", "Angle of the first link", exposed=True)
    elbow_angle = state("rad", "Angle of the second link relative to the first", exposed=True)
    rate = state("rad/s", "Rate of the first link")
    elbow_rate = state("rad/s", "Rate of the second link relative to the first")
    bearing = local("N.m", "Torque of the first bearing")
    elbow_bearing = local("N.m", "Torque of the second bearing")
    elements: ClassVar = {
        "shoulder": Element("bearing", "angle", "rate"),
        "elbow": Element("elbow_bearing", "elbow_angle", "elbow_rate"),
    }

    def equations(self, v, m):
        v.bearing, v.elbow_bearing = v.damping * v.rate, v.elbow_damping * v.elbow_rate
        c, s = m.cos(v.elbow_angle), m.sin(v.elbow_angle)
        first = v.inertia + v.elbow_inertia + 2 * v.coupling * c
        both, elbow = v.elbow_inertia + v.coupling * c, v.elbow_inertia
        hanging = v.elbow_weight * m.sin(v.angle + v.elbow_angle)
        swinging = v.coupling * s * (2 * v.rate + v.elbow_rate) * v.elbow_rate
        moment = v.torque - v.bearing - v.weight * m.sin(v.angle) - hanging + swinging
        elbow_moment = v.elbow_torque - v.elbow_bearing - hanging - v.coupling * s * v.rate**2
        determinant = first * elbow - both**2
        return {
            "der(angle)": v.rate,
            "der(elbow_angle)": v.elbow_rate,
            "der(rate)": (elbow * moment - both * elbow_moment) / determinant,
            "der(elbow_rate)": (first * elbow_moment - both * moment) / determinant,
        }


def held_pendulum(name: str, seed: int, duration: float, friction: tuple[float, float] = (0.0, 0.0)) -> Recording:
    """A recording of `duration` [s] with dry friction [N.m] in the two joints; the angles have noise of 0.2 mrad."""
    rng = np.random.default_rng(seed)
    poses = np.concatenate([np.zeros((1, 2)), rng.uniform(-2.6, 2.6, (int(duration / HOLD) + 2, 2))])
    time = np.arange(0, duration, 1 / RATE)

    def torques(t: float, x: np.ndarray) -> np.ndarray:
        k, share = divmod(t / HOLD, 1.0)
        begin, end = poses[int(k)], poses[int(k) + 1]
        wanted = begin + (end - begin) * (3 * share**2 - 2 * share**3)
        return STIFFNESS * (wanted - x[:2]) - DAMPING * x[2:]

    def rates(t: float, x: np.ndarray) -> np.ndarray:
        p, (first, second), w = TRUE, x[:2], x[2:]
        mass = p["coupling"] * np.cos(second) * np.array([[2, 1], [1, 0]]) + p["elbow_inertia"] * np.ones((2, 2))
        mass[0, 0] += p["inertia"]
        centrifugal = p["coupling"] * np.sin(second) * np.array([-(2 * w[0] + w[1]) * w[1], w[0] ** 2])
        weight = np.array([p["weight"] * np.sin(first), 0.0]) + p["elbow_weight"] * np.sin(first + second)
        bearings = np.array([p["damping"], p["elbow_damping"]]) * w + np.array(friction) * np.tanh(w / SLIDING)
        return np.concatenate([w, np.linalg.solve(mass, torques(t, x) - centrifugal - weight - bearings)])

    found = solve_ivp(rates, (0.0, time[-1]), np.zeros(4), "LSODA", time, rtol=1e-8, atol=1e-9).y.T
    torque = np.array([torques(t, x) for t, x in zip(time, found, strict=True)])
    angles = found[:, :2] + 2e-4 * rng.standard_normal((len(time), 2))
    names = ("torque", "elbow_torque", "angle", "elbow_angle")
    columns = dict(zip(names, np.column_stack([torque, angles]).T, strict=True))
    return Recording(name, time, columns, dict(zip(names, ("N.m", "N.m", "rad", "rad"), strict=True)))
