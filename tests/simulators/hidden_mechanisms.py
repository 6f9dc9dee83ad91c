"""Mechanisms that hide an effect, simulated by scipy's LSODA from equations of their own; none of the library is used.

    J q'' = T(t, q, q') - R(q, q', z, t)

One mass or two, with what is hidden in R; recorded with white noise of a share of the signal.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

EFFECTS = ("friction", "hardening", "backlash", "drag", "hysteresis", "asymmetry", "drift", "sine", "saturation", "delay", "extra")


def resistance(p, hidden, q, s, z, t, T):
    """(torque against the motion, rate of the hidden state)."""
    k, c = p["k"], p["c"]
    R, zr = k * q + c * s, 0.0
    if "friction" in hidden:
        R += hidden["friction"] * np.tanh(s / p.get("sliding", 1e-4))
    if "hardening" in hidden:
        R += hidden["hardening"] * q**3
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
    return R, zr


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
        return [s, (torque - R) / p["J"], zr, W - s, a_body]

    made = solve_ivp(rates, time[[0, -1]], [*start, 0.0, 0.0, start[1]], "LSODA", time, rtol=1e-7, atol=1e-9, max_step=4 * (time[1] - time[0]))
    q, s = made.y[0], made.y[1]
    u = np.array([feedback(*row) for row in zip(time, q, s, strict=True)]) if feedback else drive(time)
    return np.column_stack([q, s]), u


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
        y = np.convolve(levels[(t * top / 4).astype(int)], np.ones(9) / 9, "same")
    else:
        raise ValueError(kind)
    return CubicSpline(t, size * y / np.std(y))


def recorded(columns, time, noise, rng, units):
    """The arrays with white noise of deviation `noise[name]`, as (time, columns, units)."""
    return time, {n: y + noise.get(n, 0.0) * rng.standard_normal(len(y)) for n, y in columns.items()}, units
