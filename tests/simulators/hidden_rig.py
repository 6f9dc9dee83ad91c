"""A rig with a rider who has something that the model lacks, written apart from the library: other code, finer step.

Angles: d = steer minus torso. Torques are the rig's: T is what the servo must give.

    T = (I_s + J) d2 + T_arm + T_c tanh(s / 0.02) + k_s delta + c_s s + k_r delta(t - tau) + I_cc theta''
    T_arm = (k (1 + drift) d outside of the gap) + c (1 + drift) d' + k3 d^3 + k5 d^5 + c2 |d'| d' + r k |d| + F hysteron

The torso is integrated by RK4 at 2048 Hz, memory by its own recursion (stop operator, not a differential equation).
"""

import numpy as np
from numba import njit

EFFECTS = ("Tc", "k3", "k5", "g", "c2", "Fh", "wh", "ra", "rd", "kr", "tau", "td", "Ih", "fh", "zh", "J", "Icc", "ks", "cs", "Tw", "km", "tm",
           "g3")  # fmt: skip
P = {name: i for i, name in enumerate(EFFECTS)}
RIDER = {"Is": 0.125, "It": 0.6441, "ka": 1053.4, "kt": 75.8, "ca": 19.28, "ct": 4.79}
FINE = 2048.0
RATE = 128.0


@njit(cache=False)
def _torque(delta, s, a, late, duration, h, rider, p):
    Is, It, ka, kt, ca, ct = rider
    Tc, k3, k5, g, c2, Fh, wh, ra, rd = p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8]
    kr, Ih, fh, zh, J, Icc, ks, cs, Tw, km, tm, g3 = p[9], p[12], p[13], p[14], p[15], p[16], p[17], p[18], p[19], p[20], p[21], p[22]
    wn = 2 * np.pi * fh
    n = len(delta) // 2
    out = np.zeros(n)
    x = np.zeros(5)  # torso angle and rate, head angle and rate (absolute), maxwell
    z, d_before = 0.0, delta[0]
    k = np.zeros((4, 5))
    for i in range(n):
        t = i * h
        drift = rd * (t / duration - 0.5)
        for stage in range(4):
            j = min(2 * i + (0 if stage == 0 else 1 if stage < 3 else 2), len(delta) - 1)
            y = x.copy()
            if stage > 0:
                y = x + (h / 2 if stage < 3 else h) * k[stage - 1]
            d, dr = delta[j] - y[0], s[j] - y[1]
            zz = z + (d - d_before) / wh
            zz = min(max(zz, -1.0), 1.0)
            felt = d - min(max(d, -g), g)
            T = ka * (1 + drift) * felt + ca * (1 + drift) * dr + k3 * d**3 + k5 * d**5 + c2 * abs(dr) * dr + ra * ka * abs(d) + Fh * zz + km * (d - y[4])
            psi, psr = y[2] - y[0], y[3] - y[1]
            swing = wn * wn * psi + 2 * zh * wn * psr
            waist = kt * y[0] + ct * y[1] + Tw * np.tanh(y[1] / 0.02)
            acc = (T - waist + Ih * swing - Icc * a[j]) / It
            if stage == 0:
                Tm = (Is + J) * a[j] + T + Tc * np.tanh(s[j] / 0.02) + ks * delta[j] + cs * s[j] + kr * late[j] + Icc * acc
                out[i] = Tm + g3 * (Tm / 100) ** 2 * Tm
            k[stage, 0], k[stage, 1], k[stage, 2], k[stage, 3], k[stage, 4] = y[1], acc, y[3], -swing, (d - y[4]) / tm
        x = x + h / 6 * (k[0] + 2 * k[1] + 2 * k[2] + k[3])
        d = delta[min(2 * i + 2, len(delta) - 1)] - x[0]
        z = min(max(z + (d - d_before) / wh, -1.0), 1.0)
        d_before = d
    return out


def sweep(first, last, amplitude, duration):
    """Angle (n,) of a linear sweep over times, faded in and out within a second."""
    rate = (last - first) / duration

    def angle(t):
        fade = np.clip(np.minimum(t, duration - t), 0, 1.0)
        fade = fade**3 * (10 - 15 * fade + 6 * fade**2)
        return np.radians(amplitude) * fade * np.sin(2 * np.pi * (first * t + rate / 2 * t**2))

    return angle, duration


def stepped(first, last, step, amplitude, dwell):
    """Angle of a stepped sine: the frequency moves within half a second, the phase without a jump."""
    levels = np.arange(first, last + step / 2, step)
    grid = np.arange(0, len(levels) * dwell, 1 / 4096)
    place = np.minimum(grid / dwell, len(levels) - 1e-9)
    index = place.astype(int)
    blend = np.clip((place - index) * dwell / 0.5, 0, 1)
    frequency = np.where(index > 0, levels[index - 1], levels[0]) * (1 - blend) + levels[index] * blend
    phase = 2 * np.pi * np.concatenate([[0], np.cumsum(frequency[:-1])]) / 4096
    duration = len(levels) * dwell

    def angle(t):
        fade = np.clip(np.minimum(t, duration - t), 0, 1.0)
        return np.radians(amplitude) * fade**3 * (10 - 15 * fade + 6 * fade**2) * np.sin(np.interp(t, grid, phase))

    return angle, duration


RUNS = {"sweep_up": sweep(0.5, 12, 2, 200.0), "stepped": stepped(0.5, 8.5, 0.5, 4, 10.0), "sweep_down": sweep(12, 0.5, 3, 150.0)}


def record(excitation, hidden, rider, rng, noise=1.0, lag=0.016, bursts=0):
    """time, command, measured angle and torque of one run; noise scales all noises, bursts is their number."""
    angle, duration = excitation
    fine = np.arange(int(duration * FINE) * 2 + 1) / (2 * FINE)
    moved = angle(fine - lag)
    h = 1 / FINE
    rate = np.gradient(moved, h / 2, edge_order=2)
    acceleration = np.gradient(rate, h / 2, edge_order=2)
    p = np.zeros(len(EFFECTS))
    p[P["wh"]], p[P["fh"]], p[P["zh"]], p[P["tm"]] = 0.01, 4.0, 0.3, 0.1
    for name, value in hidden.items():
        p[P[name]] = value
    late = angle(fine - lag - p[P["tau"]])
    torque = _torque(moved, rate, acceleration, late, duration, h, np.array([rider[n] for n in RIDER]), p)
    every = int(FINE / RATE)
    time = np.arange(len(torque)) * h
    sampled = np.interp(time[::every] - p[P["td"]], time, torque)
    time = time[::every]
    n = len(time)
    grid = np.fft.rfftfreq(n, 1 / RATE)
    remnant = np.fft.irfft(np.fft.rfft(rng.standard_normal(n)) / (1 + (grid / 2.0) ** 2), n)
    remnant *= 0.4 * noise / remnant.std()
    disturbance = 0.2 * noise * rng.standard_normal(n)
    for _ in range(bursts):
        at = rng.integers(0, n - 256)
        disturbance[at : at + 256] += 1.0 * noise * rng.standard_normal(256)
    steps = (np.radians(40) / 4096, 400 / 4096)
    measured = moved[:: 2 * every][:n] + np.radians(0.03) * noise * rng.standard_normal(n)
    quantised = [s * np.round(x / s) for s, x in zip(steps, (measured, sampled + remnant + disturbance), strict=True)]
    return time[16:], angle(time[16:]), quantised[0][16:], quantised[1][16:]


def case(hidden, seed, noise=1.0, change=0.03, bursts=0, runs=("sweep_up", "stepped", "sweep_down")):
    """The runs of one rider drawn from the published spread, who changes from run to run. Also his mean values."""
    rng = np.random.default_rng(seed)
    rider = {n: v * (1 + rng.normal(0, 0.01 if n == "Is" else 0.2)) if n == "Is" else v * float(np.exp(rng.normal(0, 0.18))) for n, v in RIDER.items()}
    made = {}
    for name in runs:
        today = {n: v * (1.0 if n == "Is" else float(np.exp(rng.normal(0, change)))) for n, v in rider.items()}
        made[name] = record(RUNS[name], hidden, today, rng, noise, bursts=bursts)
    return made, rider
