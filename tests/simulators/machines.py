"""Machines of public benchmarks, simulated from their published equations and values, at many steps per sample.

    positioning   M q'' = g v - F_v q' - F_c sign(q') - offset, the motor's voltage v from a position loop with a wrong guess of the rate;
                  Janot, Gautier, Brunot, Nonlinear System Identification Benchmarks (2019), EMPS
    silverbox     m y'' + d y' + k_1 y + k_3 y^3 = u, u held between the samples; Wigren, Schoukens, ECC (2013)
    bouc_wen      m y'' + c y' + k y + z = u,  z' = alpha y' - beta (gamma |y'| z + delta y' |z|);
                  Noel, Schoukens, Hysteretic Benchmark with a Dynamic Nonlinearity (2016)
"""

import numpy as np
from scipy.signal import butter, lfilter

POSITIONING = {"mass": 95.1, "viscous": 203.5, "coulomb": 20.4, "offset": -3.16}
SILVERBOX = {"mass": 5.17e-6, "damping": 2.17e-4, "stiffness": 0.998, "cubic": 3.99}
BOUC_WEN = {"mass": 2.0, "damping": 10.0, "stiffness": 5e4, "alpha": 5e4, "beta": 1e3, "gamma": 0.8, "delta": -1.1}
PLACES = np.array([0, 0, 1, 1, 0, 0, 0.5, 0.5, -0.2, -0.2, 0.6, 1, 0.3, 0, 0, 1, 0.2, 0.8, 0, 0, 0.4, 0.9, 0.9, 0, 0])


def _runge_kutta(rates, x, u, step):
    one = rates(x, u)
    two = rates(x + step / 2 * one, u)
    three = rates(x + step / 2 * two, u)
    return x + step / 6 * (one + 2 * two + 2 * three + rates(x + step * three, u))


def positioning(seed, reach=0.2, duration=24, noise=2e-6):
    """Time, force and position (n,) of the axis as it goes from place to place, at 1 kHz."""
    p, rng, finer, step = POSITIONING, np.random.default_rng(seed), 10, 1e-4
    ramp = np.hanning(301) / np.hanning(301).sum()
    time = np.arange(1000 * duration) / 1000
    wanted = np.convolve(np.pad(np.interp(time, np.arange(25), reach * PLACES), 150, "edge"), ramp, "valid")
    q = rate = before = seen_rate = 0.0
    force, position = np.empty(len(time)), np.empty(len(time))
    for k in range(len(time)):
        seen = q + noise * rng.standard_normal()
        seen_rate += 0.3 * ((seen - before) * 1000 - seen_rate)
        before, position[k] = seen, seen
        force[k] = 35.15 * min(max(243.45 / 35.15 * (160.18 * (wanted[k] - seen) - seen_rate), -10.0), 10.0)
        for _ in range(finer):
            rate += (
                step * (force[k] - p["viscous"] * rate - p["coulomb"] * np.tanh(rate / 1e-4) - p["offset"]) / p["mass"]
            )
            q += step * rate
    return time, force, position


def silverbox(seed, samples=5000, size=0.05, noise=2e-4):
    """Time, input and output (n,) of the circuit that is a hardening spring, under noise below 200 Hz."""
    p, rng, rate, finer = SILVERBOX, np.random.default_rng(seed), 610.35, 8
    drive = size * lfilter(*butter(9, 200 / (rate / 2)), rng.standard_normal(samples))

    def rates(x, u):
        return np.array([x[1], (u - p["damping"] * x[1] - p["stiffness"] * x[0] - p["cubic"] * x[0] ** 3) / p["mass"]])

    x, seen = np.zeros(2), np.empty(samples)
    for k, u in enumerate(drive):
        seen[k] = x[0]
        for _ in range(finer):
            x = _runge_kutta(rates, x, u, 1 / (rate * finer))
    return np.arange(samples) / rate, drive, seen + noise * rng.standard_normal(samples)


def bouc_wen(seed, periods=2, size=50.0, noise=8e-6):
    """Time, force and deflection (n,) of the hysteretic oscillator in steady state, under a multisine from 5 to 150
    Hz."""
    p, rng, rate, samples, finer = BOUC_WEN, np.random.default_rng(seed), 750, 8192, 20
    frequency = np.arange(samples // 2 + 1) * rate / samples
    lines = np.where((frequency > 5) & (frequency < 150), np.exp(2j * np.pi * rng.random(len(frequency))), 0)
    drive = np.fft.irfft(lines, samples * finer)
    drive = np.tile(drive * size / np.std(drive), periods + 1)

    def rates(x, u):
        y, v, z = x
        slip = p["beta"] * (p["gamma"] * abs(v) * z + p["delta"] * v * abs(z))
        return np.array([v, (u - p["damping"] * v - p["stiffness"] * y - z) / p["mass"], p["alpha"] * v - slip])

    x, seen = np.zeros(3), np.empty(samples * (periods + 1))
    for k, u in enumerate(drive[:-1]):
        if k % finer == 0:
            seen[k // finer] = x[0]
        x = _runge_kutta(rates, x, (u + drive[k + 1]) / 2, 1 / (rate * finer))
    seen, drive = seen[samples:], drive[samples * finer :: finer]
    return np.arange(len(seen)) / rate, drive, seen + noise * rng.standard_normal(len(seen))
