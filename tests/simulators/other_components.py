"""Components of a user's own whose states are no deflection and rate, and recordings of what they describe, by scipy's
`solve_ivp` from equations that share no code with the components."""

from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

from fmus import Component, input, output, parameter, state
from motofmi.recordings.recording import Recording


class Tanks(Component):
    """Two tanks in cascade: a pump fills the upper one, whose outflow fills the lower one."""

    pump_gain = parameter("m/s/V", "Rise of the upper level per voltage", min=0, start=0.001)
    upper_outflow = parameter("m/s", "Fall of the upper level at 1 m", min=0, start=0.01)
    lower_outflow = parameter("m/s", "Fall of the lower level at 1 m", min=0, start=0.01)
    pump = input("V", "Voltage of the pump")
    upper_level = state("m", "Level of the upper tank", start=0.1)
    level = state("m", "Level of the lower tank", start=0.1, exposed=True)

    def equations(self, v, m):
        upper, lower = (m.sqrt(m.where(h > 1e-6, h, 1e-6 + 0 * h)) for h in (v.upper_level, v.level))
        return {
            "der(upper_level)": v.pump_gain * v.pump - v.upper_outflow * upper,
            "der(level)": v.upper_outflow * upper - v.lower_outflow * lower,
        }


def steps(rng: np.random.Generator, duration: float, hold: float, low: float, high: float) -> Callable:
    """A function of time that takes a random value between two limits every `hold` seconds, with linear transitions of
    a tenth of that time."""
    edges = np.arange(0.0, duration + 2 * hold, hold)
    values = rng.uniform(low, high, len(edges))
    time = np.column_stack([edges, edges + 0.9 * hold]).ravel()
    return lambda t: np.interp(t, time, np.repeat(values, 2))


def tanks_run(
    name: str, seed: int, overflow: float = np.inf, share: float = 0.0, limit: float = np.inf, noise: float = 0.0005
) -> Recording:
    """An hour of the tanks: 0.0004 m/s per volt, outflows of 0.008 and 0.0075 m/s at 1 m.

    Above the level `overflow` [m] the upper tank loses 0.5 1/s of the excess, of which a share reaches the lower one.
    The sensor of the lower level stops at `limit`.
    """
    rng, time = np.random.default_rng(seed), np.arange(0.0, 3600.0, 4.0)
    pump = steps(rng, time[-1], 120.0, 1.0, 9.0)

    def rates(t: float, h: np.ndarray) -> list[float]:
        upper, lower = 0.008 * np.sqrt(max(h[0], 0.0)), 0.0075 * np.sqrt(max(h[1], 0.0))
        over = 0.5 * max(h[0] - overflow, 0.0)
        return [0.0004 * float(pump(t)) - upper - over, upper + share * over - lower]

    found = solve_ivp(rates, (0.0, time[-1]), [0.06, 0.07], t_eval=time, rtol=1e-8, atol=1e-10, max_step=4.0)
    level = np.minimum(found.y[1] + noise * rng.standard_normal(len(time)), limit)
    return Recording(name, time, {"pump": pump(time), "level": level}, {"pump": "V", "level": "m"})


class TwoCarts(Component):
    """Two masses in a row, each driven by a force of its own; both positions are measured."""

    mass = parameter("kg", "First mass", min=1e-9, start=1.0)
    other_mass = parameter("kg", "Second mass", min=1e-9, start=1.0)
    ground_stiffness = parameter("N/m", "Spring between the ground and the first mass", min=0, start=100.0)
    stiffness = parameter("N/m", "Spring between the masses", min=0, start=100.0)
    damping = parameter("N.s/m", "Damper of the first mass", min=0, start=1.0)
    other_damping = parameter("N.s/m", "Damper of the second mass", min=0, start=1.0)
    force = input("N", "Force on the first mass")
    other_force = input("N", "Force on the second mass")
    position = state("m", "Position of the first mass", exposed=True)
    velocity = state("m/s", "Velocity of the first mass")
    other_position = state("m", "Position of the second mass", exposed=True)
    other_velocity = state("m/s", "Velocity of the second mass")

    def equations(self, v, m):
        between = v.stiffness * (v.position - v.other_position)
        ground = v.ground_stiffness * v.position + v.damping * v.velocity
        return {
            "der(position)": v.velocity,
            "der(velocity)": (v.force - ground - between) / v.mass,
            "der(other_position)": v.other_velocity,
            "der(other_velocity)": (v.other_force + between - v.other_damping * v.other_velocity) / v.other_mass,
        }


def carts_run(name: str, seed: int, friction: float = 0.0, noise: float = 0.01, slower: float = 1.0) -> Recording:
    """20 s of the carts at 100 Hz, with dry friction [N] of the second mass; noise over each position's rms.

    1.3 and 0.8 kg, 150 and 220 N/m, 2 and 1.5 N.s/m; with `slower` the same motion at so many times the duration.
    """
    rng, time = np.random.default_rng(seed), np.arange(0.0, 20.0, 0.01)
    forces = [steps(rng, time[-1], 0.17, -10.0, 10.0), steps(rng, time[-1], 0.23, -10.0, 10.0)]

    def rates(t: float, x: np.ndarray) -> list[float]:
        between = 220.0 * (x[0] - x[2])
        rubbing = friction * np.tanh(x[3] / 1e-3)
        first = (float(forces[0](t)) - 150.0 * x[0] - 2.0 * x[1] - between) / 1.3
        return [x[1], first, x[3], (float(forces[1](t)) + between - 1.5 * x[3] - rubbing) / 0.8]

    found = solve_ivp(rates, (0.0, time[-1]), [0.0] * 4, "LSODA", time, rtol=1e-8, atol=1e-11, max_step=0.01)
    columns = {"force": forces[0](time), "other_force": forces[1](time)}
    for name_of, y in (("position", found.y[0]), ("other_position", found.y[2])):
        columns[name_of] = y + noise * np.std(y) * rng.standard_normal(len(time))
    units = {"force": "N", "other_force": "N", "position": "m", "other_position": "m"}
    return Recording(name, slower * time, columns, units)


class Accelerometer(Component):
    """A mass on spring and damper whose acceleration is measured."""

    mass = parameter("kg", "Mass", min=1e-9, start=1.0)
    stiffness = parameter("N/m", "Stiffness", min=0, start=100.0)
    damping = parameter("N.s/m", "Damping", min=0, start=1.0)
    force = input("N", "Force on the mass")
    position = state("m", "Position")
    velocity = state("m/s", "Velocity")
    acceleration = output("m/s2", "Acceleration of the mass")

    def equations(self, v, m):
        acceleration = (v.force - v.stiffness * v.position - v.damping * v.velocity) / v.mass
        return {"der(position)": v.velocity, "der(velocity)": acceleration, "acceleration": acceleration}


def accelerometer_run(name: str, seed: int, friction: float = 0.0, noise: float = 0.01) -> Recording:
    """20 s at 100 Hz of 2 kg, 300 N/m and 4 N.s/m with dry friction [N]; noise over the acceleration's rms."""
    rng, time = np.random.default_rng(seed), np.arange(0.0, 20.0, 0.01)
    force = multisine(rng, 0.3, 8.0, 10.0)

    def acceleration(t: float, x: np.ndarray) -> float:
        return (float(force(t)) - 300.0 * x[0] - 4.0 * x[1] - friction * np.tanh(x[1] / 1e-3)) / 2.0

    found = solve_ivp(lambda t, x: [x[1], acceleration(t, x)], (0.0, time[-1]), [0.0, 0.0], "LSODA", time,
                      rtol=1e-8, atol=1e-11, max_step=0.005)  # fmt: skip
    y = np.array([acceleration(t, x) for t, x in zip(time, found.y.T, strict=True)])
    y = y + noise * np.std(y) * rng.standard_normal(len(time))
    return Recording(name, time, {"force": force(time), "acceleration": y}, {"force": "N", "acceleration": "m/s2"})


def multisine(rng: np.random.Generator, lowest: float, highest: float, rms: float) -> Callable:
    """A sum of 40 sines of random phase between two frequencies [Hz], as a function of time."""
    omega = 2 * np.pi * np.linspace(lowest, highest, 40) * rng.uniform(0.99, 1.01, 40)
    phase = rng.uniform(0, 2 * np.pi, 40)
    return lambda t: rms * np.sqrt(2 / 40) * np.sin(np.multiply.outer(t, omega) + phase).sum(axis=-1)


class Operator(Component):
    """A human operator: gain, lag and a second-order neuromuscular system, with a delay of perception as second-order
    Pade approximation.

    e_d = e (1 - s T / 2 + (s T)^2 / 12) / (1 + s T / 2 + (s T)^2 / 12)
    """

    gain = parameter("1", "Stick angle per error", min=0, start=1.0)
    lag = parameter("s", "Lag time constant", min=1e-3, start=0.3)
    frequency = parameter("rad/s", "Neuromuscular frequency", min=0.1, start=10.0)
    damping_ratio = parameter("1", "Neuromuscular damping ratio", min=0, start=0.3)
    delay = parameter("s", "Delay of perception", min=1e-3, start=0.15, tunable=False)
    error = input("rad", "Displayed error")
    perceived = state("rad.s2", "First state of the delay")
    perceived_rate = state("rad.s", "Second state of the delay")
    command = state("rad", "Lagged command")
    stick = state("rad", "Stick angle", exposed=True)
    stick_rate = state("rad/s", "Rate of the stick")

    def equations(self, v, m):
        # (1 - sT/2 + s2T2/12) / (1 + sT/2 + s2T2/12) = 1 - (12 s / T) / (s2 + 6 s / T + 12 / T2)
        delayed = v.error - 12 / v.delay * v.perceived_rate
        return {
            "der(perceived)": v.perceived_rate,
            "der(perceived_rate)": v.error - 12 / v.delay**2 * v.perceived - 6 / v.delay * v.perceived_rate,
            "der(command)": (v.gain * delayed - v.command) / v.lag,
            "der(stick)": v.stick_rate,
            "der(stick_rate)": v.frequency**2 * (v.command - v.stick)
            - 2 * v.damping_ratio * v.frequency * v.stick_rate,
        }


def operator_run(name: str, seed: int, delay: float = 0.15, threshold: float = 0.0, noise: float = 0.02) -> Recording:
    """60 s at 50 Hz of an operator of gain 0.8, lag 0.25 s, 9 rad/s and damping ratio 0.35, with an exact delay [s] and
    a threshold of perception [rad]; noise over the stick's rms."""
    rng, time = np.random.default_rng(seed), np.arange(0.0, 60.0, 0.02)
    error = multisine(rng, 0.05, 1.5, 0.1)

    def perceived(t: float) -> float:
        e = float(error(t - delay))
        return np.sign(e) * max(abs(e) - threshold, 0.0)

    def rates(t: float, x: np.ndarray) -> list[float]:
        return [(0.8 * perceived(t) - x[0]) / 0.25, x[2], 81.0 * (x[0] - x[1]) - 2 * 0.35 * 9.0 * x[2]]

    found = solve_ivp(rates, (0.0, time[-1]), [0.0] * 3, t_eval=time, rtol=1e-7, atol=1e-10, max_step=0.02)
    stick = found.y[1] + noise * np.std(found.y[1]) * rng.standard_normal(len(time))
    return Recording(name, time, {"error": error(time), "stick": stick}, {"error": "rad", "stick": "rad"})
