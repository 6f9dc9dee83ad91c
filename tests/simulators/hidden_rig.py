"""A rig with a rider who has something that the model lacks, written apart from the library: other code, finer step.

Angles: d = steer minus torso. Torques are the rig's: T is what the servo must give.

    T     = (I_s + J) delta'' + T_arm + friction + k_s delta + c_s s + k_r delta(t - tau) + I_cc theta'' + cogging
    T_arm = k play(d) + c d' + k3 d^3 + k5 d^5 + c2 |d'| d' + r k |d| + F hysteron(d) + ...

With a compliant shaft the bar is a body of its own behind a spring. All is integrated by RK4 at 1500 Hz or more,
sliders by their own recursion (stop operator, not a differential equation).
"""

from collections import namedtuple
from dataclasses import dataclass, field

import numpy as np
from numba import njit

# What may be hidden, with the value that it has where it is absent.
ABSENT = {
    "Tc": 0.0, "Ts": 0.0, "ss": 0.1,  # dry friction at the bar, its excess near standstill, over this rate
    "Tl": 0.0, "wl": 2e-3,  # LuGre friction at the bar, deflection of its bristles
    "k2": 0.0, "k3": 0.0, "k5": 0.0, "kx": 0.0, "wx": 0.03,  # arms: square, cubic, quintic, exponential over this deflection
    "kd": 0.0,  # arms: deflection^2.5
    "g": 0.0, "gs": 0.0, "ws": 2e-3,  # play: sharp, smooth with this width
    "c2": 0.0, "c3": 0.0, "cp": 0.0,  # arms: damping with rate^2, rate^3, rate^1.5
    "Fh": 0.0, "wh": 0.01, "Fd": 0.0, "wd": 0.01, "nd": 1.0,  # slider; Dahl (1) or Bouc-Wen (exponent above 1)
    "ra": 0.0, "qa": 0.0, "sa": 0.0,  # arms: lopsided with |d|, d^2, smooth |d|
    "rd": 0.0, "rk": 0.0, "rc": 0.0, "rj": 0.0, "re": 0.0, "rl": 0.0,  # drift: both, stiffness, damping; a jump of the stiffness midway; it settles; it creeps
    "kr": 0.0, "tau": 0.1, "tm_r": 0.0,  # reflex, its delay, the muscle's time constant
    "td": 0.0, "te": 0.0,  # delay of the torque channel, and how much it grows over the run
    "Ih": 0.0, "fh": 4.0, "zh": 0.3, "ph": 0.0,  # head; its spring softens as that of a pendulum
    "J": 0.0, "Icc": 0.0, "ks": 0.0, "cs": 0.0, "Tw": 0.0,  # hands, coupled inertia, spring and damper at the bar, waist friction
    "km": 0.0, "tm": 0.1, "C": 0.0, "g3": 0.0, "g2": 0.0,  # Maxwell arms, shaft, sensor's gain
    "bx": 0.0, "eb": 0.0, "fb": 0.3, "Ar": 0.0, "Nr": 150.0, "ce": 0.0, "hs": 0.0,
    "kw": 0.0, "ga": 0.0, "ji": 0.0,  # outside of the library, see blind_cases
}  # fmt: skip
Hidden = namedtuple("Hidden", ABSENT)
RIDER = {"Is": 0.125, "It": 0.6441, "ka": 1053.4, "kt": 75.8, "ca": 19.28, "ct": 4.79}
Rider = namedtuple("Rider", RIDER)


@njit(cache=True)
def _torque(delta, s, a, late, duration, h, r, p):
    """Torque and torso rate (n,) for the motion (2 n + 1,) at steps and half steps."""
    wn, n, shaft = 2 * np.pi * p.fh, len(delta) // 2, p.C > 0
    out, gyro = np.zeros(n), np.zeros(n)
    x, y, k = np.zeros(10), np.zeros(10), np.zeros((4, 10))
    z, before = 0.0, delta[0]
    for i in range(n):
        tau = i * h / duration - 0.5
        stiff = 1 + (p.rd + p.rk) * tau + p.rj * (tau > 0) + p.re * (1 - np.exp(-4 * (tau + 0.5)))
        stiff += p.rl * np.log1p(50 * (tau + 0.5)) / np.log(51) + p.eb * np.sin(2 * np.pi * p.fb * i * h)
        loss = 1 + (p.rd + p.rc) * tau
        for stage in range(4):
            j = 2 * i + (0 if stage == 0 else 1 if stage < 3 else 2)
            y[:] = x
            if stage > 0:
                y += (h / 2 if stage < 3 else h) * k[stage - 1]
            angle, rate = (y[8], y[9]) if shaft else (delta[j], s[j])
            d, dr = angle - y[0], rate - y[1]
            slid = min(max(z + (d - before) / p.wh, -1.0), 1.0)
            felt = d - min(max(d, -p.g), p.g) - p.gs * np.tanh(d / p.ws)
            T = r.ka * stiff * felt + r.ca * loss * dr + p.k2 * abs(d) * d + p.k3 * d**3 + p.k5 * d**5
            T += p.kd * abs(d) ** 1.5 * d
            T += (
                p.kx * (p.wx * np.sinh(d / p.wx) - d)
                + p.c2 * abs(dr) * dr
                + p.c3 * dr**3
                + p.cp * np.sqrt(abs(dr)) * dr
            )
            T += r.ka * (p.ra * abs(d) + p.sa * np.sqrt(d * d + 1e-4)) + p.qa * d * d + p.ce * dr * dr + p.bx * d * dr
            T += p.Fh * slid + p.Fd * y[5] + p.km * (d - y[4])
            psi, psr = y[2] - y[0], y[3] - y[1]
            swing = wn * wn * (psi - p.ph * psi**3) + 2 * p.zh * wn * psr
            waist = r.kt * y[0] + r.ct * y[1] + p.Tw * np.tanh(y[1] / 0.02) + p.kw * y[0] ** 3
            pushed = 0.0 if shaft else p.Icc * a[j]
            acc = (T - waist + p.Ih * swing - pushed) / r.It
            dry = (p.Tc + p.Ts * np.exp(-((rate / p.ss) ** 2))) * np.tanh(rate / 0.02) + p.Tl * y[6]
            reflex = p.kr * (y[7] if p.tm_r > 0 else late[j])
            bar = T + dry + p.ks * angle + p.cs * rate + reflex + p.Ar * np.sin(p.Nr * angle)
            driven = (delta[j] - y[8]) / p.C if shaft else 0.0
            if stage == 0:
                torque = driven if shaft else (r.Is + p.J) * a[j] + bar + p.Icc * acc
                torque += p.ji * (angle * angle * a[j] + angle * rate * rate)
                out[i] = torque + p.g3 * (torque / 100) ** 2 * torque + p.g2 * abs(torque) / 100 * torque
                gyro[i] = y[1]
            k[stage, 0], k[stage, 1], k[stage, 2], k[stage, 3] = y[1], acc, y[3], -swing
            k[stage, 4] = (d - y[4]) / p.tm
            held = abs(y[5])
            k[stage, 5] = (
                dr - (abs(dr) * y[5] if p.nd == 1.0 else (abs(dr) * held ** (p.nd - 1) * y[5] + dr * held**p.nd) / 2)
            ) / p.wd
            k[stage, 6] = (rate - abs(rate) * y[6]) / p.wl
            k[stage, 7] = (late[j] - y[7]) / p.tm_r if p.tm_r > 0 else 0.0
            k[stage, 8], k[stage, 9] = y[9], (driven - bar) / (r.Is + p.J)
        x += h / 6 * (k[0] + 2 * k[1] + 2 * k[2] + k[3])
        if not shaft:
            x[8], x[9] = delta[2 * i + 2], s[2 * i + 2]
        d = x[8] - x[0]
        z = min(max(z + (d - before) / p.wh, -1.0), 1.0)
        before = d
    return out, gyro


def sweep(first, last, amplitude, duration, logarithmic=False):
    """Angle (n,) of a linear or logarithmic sweep over times, faded in and out within a second."""
    rate, growth = (last - first) / duration, np.log(last / first) / duration

    def angle(t):
        fade = np.clip(np.minimum(t, duration - t), 0, 1.0)
        fade = fade**3 * (10 - 15 * fade + 6 * fade**2)
        cycles = (
            first * np.expm1(growth * np.clip(t, 0, duration)) / growth if logarithmic else first * t + rate / 2 * t**2
        )
        return np.radians(amplitude) * fade * np.sin(2 * np.pi * cycles)

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


RUNS = {
    "sweep_up": sweep(0.5, 12, 2, 200.0),
    "stepped": stepped(0.5, 8.5, 0.5, 4, 10.0),
    "sweep_down": sweep(12, 0.5, 3, 150.0),
}


@dataclass(frozen=True)
class Rig:
    """How a rig measures: samples per second, bits over +-20 deg and +-200 N.m, noises, and what else disturbs."""

    rate: int = 128
    bits: int = 12
    angle_noise: float = field(default=float(np.radians(0.03)))  # rad
    torque_noise: float = 0.2  # N.m
    remnant: float = 0.4  # N.m, below 2 Hz
    gyro_noise: float = 0.01  # rad/s
    lag: float = 0.016  # s, of the angle behind its command
    bursts: int = 0
    angle_offset: float = 0.0  # rad, of the sensor
    torque_offset: float = 0.0  # N.m


def record(excitation, hidden, rider, rng, rig=Rig()):
    """time, command, measured angle and torque, torso rate of one run."""
    angle, duration = excitation
    finer = int(np.ceil(1500 / rig.rate))
    h = 1 / (finer * rig.rate)
    fine = np.arange(2 * int(duration / h) + 3) * h / 2
    delayed_angle = angle(fine - rig.lag)
    rate = np.gradient(delayed_angle, h / 2, edge_order=2)
    acceleration = np.gradient(rate, h / 2, edge_order=2)
    p = Hidden(**{**ABSENT, **hidden})
    torque, gyro = _torque(delayed_angle, rate, acceleration, angle(fine - rig.lag - p.tau), duration, h, Rider(**rider), p)
    if p.hs:
        torque = torque + p.hs * _slider(torque, 5.0)
    steps = np.arange(len(torque)) * h
    time = steps[::finer]
    n = len(time)
    sampled = np.interp(time - p.td - p.te * time / duration, steps, torque)
    remnant = np.fft.irfft(np.fft.rfft(rng.standard_normal(n)) / (1 + (np.fft.rfftfreq(n, 1 / rig.rate) / 2.0) ** 2), n)
    disturbance = rig.remnant * remnant / remnant.std() + rig.torque_noise * rng.standard_normal(n)
    for _ in range(rig.bursts):
        at = rng.integers(0, n - 2 * rig.rate)
        disturbance[at : at + 2 * rig.rate] += 5 * rig.torque_noise * rng.standard_normal(2 * rig.rate)
    sizes = (np.radians(40) / 2**rig.bits, 400 / 2**rig.bits)
    measured = (
        delayed_angle[:: 2 * finer][:n] * (1 + p.ga * delayed_angle[:: 2 * finer][:n] ** 2)
        + rig.angle_offset
        + rig.angle_noise * rng.standard_normal(n)
    )
    shown = [
        size * np.round(y / size)
        for size, y in zip(sizes, (measured, sampled + rig.torque_offset + disturbance), strict=True)
    ]
    gyro = gyro[::finer] + rig.gyro_noise * rng.standard_normal(n)
    cut = slice(rig.rate // 8, None)
    return time[cut], angle(time)[cut], shown[0][cut], shown[1][cut], gyro[cut]


@njit(cache=True)
def _slider(y, width):
    """The stop operator of a signal, from -1 to 1."""
    out = np.zeros(len(y))
    for i in range(1, len(y)):
        out[i] = min(max(out[i - 1] + (y[i] - y[i - 1]) / width, -1.0), 1.0)
    return out


def case(hidden, seed, noise=1.0, change=0.03, bursts=0, runs=("sweep_up", "stepped", "sweep_down"), spread=0.18):
    """The runs of one rider drawn from the published spread, who changes from run to run. Also his mean values."""
    rng = np.random.default_rng(seed)
    rider = {
        n: v * (1 + rng.normal(0, 0.01)) if n == "Is" else v * float(np.exp(rng.normal(0, spread)))
        for n, v in RIDER.items()
    }
    rig = Rig(angle_noise=float(np.radians(0.03)) * noise, torque_noise=0.2 * noise, remnant=0.4 * noise, bursts=bursts)
    made = {}
    for name in runs:
        made[name] = record(RUNS[name], hidden, today(rider, change, rng), rng, rig)
    return made, rider


def today(rider, change, rng):
    """The rider as he is in one run; the bar stays what it is."""
    return {n: v * (1.0 if n == "Is" else float(np.exp(rng.normal(0, change)))) for n, v in rider.items()}
