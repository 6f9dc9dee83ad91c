"""Mechanisms that hide an effect, simulated by scipy's LSODA from equations of their own; none of the library is used.

    J q'' = T(t, q, q') - R(q, q', z, t)

One mass or two, with what is hidden in R, in the actuator or in the sensor; recorded with white noise of a share of the
signal.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline


def resistance(p, hidden, q, s, z, t, T):
    """(torque against the motion, rate of the hidden state)."""
    k, c = p["k"], p["c"]
    R, zr = k * q + c * s, 0.0
    if "friction" in hidden:
        R += hidden["friction"] * np.tanh(s / p.get("sliding", 1e-4))
    if "late_friction" in hidden:
        force, sliding, lag = hidden["late_friction"]
        R += force * z
        zr = (np.tanh(s / sliding) - z) / lag
    if "hardening" in hidden:
        R += hidden["hardening"] * q**3
    if "square" in hidden:
        R += hidden["square"] * abs(q) * q
    if "backlash" in hidden:
        g = hidden["backlash"]
        R -= k * min(max(q, -g), g)
    if "drag" in hidden:
        R += hidden["drag"] * abs(s) * s
    if "hysteresis" in hidden:
        force, width = hidden["hysteresis"]
        R += force * z
        zr = (s - abs(s) * z) / width
    if "asymmetry" in hidden:
        R += hidden["asymmetry"] * k * abs(q)
    if "drift" in hidden:
        R += hidden["drift"] * (t / T - 0.5) * (k * q + c * s)
    if "sine" in hidden:
        R += k * (np.sin(q) - q)
    if "saturation" in hidden:
        limit = hidden["saturation"]
        R -= k * (q - min(max(q, -limit), limit))
    if "smooth_friction" in hidden:
        force, rate = hidden["smooth_friction"]
        R += force * s / np.hypot(s, rate)
    if "sinh_hardening" in hidden:
        size, angle = hidden["sinh_hardening"]
        R += size * (np.sinh(q / angle) - q / angle)
    if "blunt_drag" in hidden:
        R += hidden["blunt_drag"] * abs(s) ** 1.5 * np.sign(s)
    if "atan_backlash" in hidden:
        R -= k * hidden["atan_backlash"] * 2 / np.pi * np.arctan(q / hidden["atan_backlash"] * np.pi / 2)
    if "thin_loop" in hidden:
        force, width = hidden["thin_loop"]
        R += force * z
        zr = (s - 0.8 * abs(s) * np.sqrt(abs(z)) * z - 0.2 * s * abs(z) ** 1.5) / width
    if "ripple" in hidden:
        size, angle = hidden["ripple"]
        R += size * np.sin(2 * np.pi * q / angle)
    if "pulse" in hidden:
        share, frequency = hidden["pulse"]
        R += share * k * q * np.cos(2 * np.pi * frequency * t)
    return R, zr


def actuated(hidden, torque):
    """What an actuator gives of the torque that is recorded."""
    limit = hidden.get("clip", np.inf)
    return min(max(torque, -limit), limit)


def sensed(hidden, y):
    """What a sensor shows of its signal (n,): its gain grows by a share up to the largest."""
    return y * (1 + hidden.get("sensor", 0.0) * (y / np.abs(y).max()) ** 2)


def simulate(p, hidden, drive, time, start=(0.0, 0.0), feedback=None):
    """Angle and rate (n, 2) and the drive (n,) at times; drive(t), or feedback(t, q, s) for a closed loop."""
    delay = hidden.get("delay", 0.0)
    body = hidden.get("extra")

    def rates(t, x):
        q, s, z, psi, W = x
        torque = feedback(t, q, s) if feedback else drive(t - delay)
        R, zr = resistance(p, hidden, q, s, z, t, time[-1])
        a_body = 0.0
        if body:
            inertia, frequency, zeta = body
            w = 2 * np.pi * frequency
            a_body = -(w**2) * psi - 2 * zeta * w * (W - s)
            R += inertia * a_body
        return [s, (actuated(hidden, torque) - R) / p["J"], zr, W - s, a_body]

    made = solve_ivp(
        rates,
        time[[0, -1]],
        [*start, 0.0, 0.0, start[1]],
        "LSODA",
        time,
        rtol=1e-7,
        atol=1e-9,
        max_step=4 * (time[1] - time[0]),
    )
    q, s = made.y[0], made.y[1]
    u = np.array([feedback(*row) for row in zip(time, q, s, strict=True)]) if feedback else drive(time)
    return np.column_stack([q, s]), u


def simulate_two(p, hidden, drive, time):
    """Angles of drive and load (n, 2) and the torque (n,): what is hidden acts in the shaft between them, friction at
    the load."""
    shaft = {name: value for name, value in hidden.items() if name != "friction"}

    def rates(t, x):
        q1, s1, q2, s2, z = x
        R, zr = resistance(p, shaft, q1 - q2, s1 - s2, z, t, time[-1])
        rub = hidden.get("friction", 0.0) * np.tanh(s2 / p["sliding"])
        return [
            s1,
            (actuated(hidden, drive(t)) - R - p["c1"] * s1) / p["J"],
            s2,
            (R - p["c2"] * s2 - rub) / p["J2"],
            zr,
        ]

    made = solve_ivp(
        rates, time[[0, -1]], np.zeros(5), "LSODA", time, rtol=1e-7, atol=1e-9, max_step=4 * (time[1] - time[0])
    )
    return made.y[[0, 2]].T, drive(time)


def torque_for(p, hidden, motion, time):
    """The torque (n,) that imposes an angle, a function of time with derivatives; a force sensor shows it late."""
    end, late = time[-1], hidden.get("delay", 0.0)
    inertia, frequency, zeta = hidden.get("extra", (0.0, 1.0, 1.0))
    w = 2 * np.pi * frequency

    def swing(s, psi, W):
        return -(w**2) * psi - 2 * zeta * w * (W - s)

    def rates(t, x):
        q, s = motion(t), motion(t, 1)
        return [resistance(p, hidden, q, s, x[0], t, end)[1], x[2] - s, swing(s, x[1], x[2])]

    begin = [0.0, 0.0, float(motion(time[0], 1))]
    at = np.maximum(time - late, 0.0)
    made = solve_ivp(
        rates, time[[0, -1]], begin, "LSODA", dense_output=True, rtol=1e-7, atol=1e-9, max_step=4 * (time[1] - time[0])
    )
    states = made.sol(at)
    rows = zip(motion(at), motion(at, 1), motion(at, 2), *states, at, strict=True)
    return np.array(
        [
            p["J"] * a + resistance(p, hidden, q, s, z, t, end)[0] + inertia * swing(s, psi, W)
            for q, s, a, z, psi, W, t in rows
        ]
    )


def excitation(kind, rng, duration, top, size):
    """A drive as a function of time; `top` is its highest frequency [Hz], size its rms."""
    t = np.arange(0, duration + 0.1, 1 / (40 * top))
    if kind == "decay":
        return lambda t: 0.0 * np.asarray(t)
    if kind == "multisine":
        f = np.arange(1, max(int(top * duration / 4), 5)) * 4 / duration
        phases = rng.uniform(0, 2 * np.pi, len(f))
        y = np.sum(np.cos(2 * np.pi * f[:, None] * t + phases[:, None]), axis=0)
    elif kind == "chirp":
        y = np.sin(2 * np.pi * (0.1 * top * t + 0.45 * top * t**2 / duration))
    elif kind in ("random", "road"):
        spectrum = np.fft.rfft(rng.standard_normal(len(t)))
        f = np.fft.rfftfreq(len(t), t[1])
        spectrum *= (f < top) / (1 + (f / (0.2 * top)) ** (2 if kind == "road" else 0))
        y = np.fft.irfft(spectrum, len(t))
        if kind == "road":
            y = y * (0.4 + np.abs(np.sin(2 * np.pi * t / duration * 1.5)))
    elif kind == "steps":
        levels = rng.uniform(-1, 1, int(duration * top / 4) + 2)
        held = np.minimum((t * top / 4).astype(int), len(levels) - 1)
        y = np.convolve(levels[held], np.ones(9) / 9, "same")
    else:
        raise ValueError(kind)
    return CubicSpline(t, size * y / np.std(y))
