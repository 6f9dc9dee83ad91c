"""Measured eigenvalues of motorcycles with something hidden, made apart from the package: Kane's equations and numpy.

Modes are named as somebody who measures names them: at the highest speed by frequency and damping, then followed
downwards. Weave and wobble are always measured, capsize and the slower half of the speeds sometimes.
"""

import csv
from functools import cache
from pathlib import Path

import numpy as np
from scipy.optimize import linear_sum_assignment

from tests.truth import flexible_motorcycle_by_kane

# Sharp (1971), Appendix 3, converted exactly from imperial units; twist and lean held.
SHARP = {
    "M_f": 30.64719617, "M_r": 217.4491538, "Z_f": -1005.298085, "I_rx": 31.18381281, "I_rz": 21.06941092, "C_rxz": 1.735446974,
    "I_fx": 1.233794333, "I_fz": 0.4419966512, "I_fxz": 0.0, "i_fy": 0.7185835126, "i_ry": 1.05075891, "R_f": 0.3048, "R_r": 0.3048,
    "a": 0.9485376, "b": 0.4797552, "e": 0.024384, "f": 0.0283464, "h": 0.615696, "t": 0.115824, "eps": 0.4715, "C_f1": 11173.9327,
    "C_f2": 938.5747608, "C_r1": 15831.22073, "C_r2": 1325.570041, "sigma_f": 0.24384, "sigma_r": 0.24384, "K": 6.779089742, "g": 9.80665,
    "V": 1.0, "C": 1e-9, "d": 0.0, "z_t": 0.4, "m_u": 0.0, "rho": 0.2, "h_s": 0.8, "c_r": 0.35, "x_r": 0.0, "k_u": 1.0, "d_u": 0.0,
}  # fmt: skip
LENGTHS = ("R_f", "R_r", "a", "b", "e", "f", "h", "t", "eps", "M_f", "M_r")  # known to 1 %
OTHERS = (
    "I_rx",
    "I_rz",
    "C_rxz",
    "I_fx",
    "I_fz",
    "i_fy",
    "i_ry",
    "C_f1",
    "C_f2",
    "C_r1",
    "C_r2",
    "sigma_f",
    "sigma_r",
    "K",
)  # to 5 %
STATES = flexible_motorcycle_by_kane.STATES
FINE = 0.25  # m/s


@cache
def kane():
    return flexible_motorcycle_by_kane.derive()


def matrix(p: dict, speed: float, hidden: dict) -> np.ndarray:
    """A (n, n) of the motorcycle p at a speed, with what is hidden, states that are held left out."""
    mass, slopes, _ = equations(p, speed, hidden)
    return np.linalg.solve(mass, slopes)


def equations(p: dict, speed: float, hidden: dict) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """M and df/dx (n, n) of the motorcycle p at a speed with what is hidden, and the names of the n states that are not
    held."""
    q = dict(p, V=speed)
    if "air_load" in hidden:
        # Load in proportion to the square of the speed goes from the front to the rear, tyre forces with it.
        load = hidden["air_load"] * speed**2
        rear = (q["M_f"] + q["M_r"]) * q["g"] + q["Z_f"]
        for name in ("C_f1", "C_f2"):
            q[name] *= 1 + load / q["Z_f"]
        for name in ("C_r1", "C_r2"):
            q[name] *= 1 + load / rear
        q["Z_f"] += load
    if "lean" in hidden:
        q["m_u"], frequency, zeta = hidden["lean"]
        inertia, w = q["m_u"] * (q["rho"] ** 2 + q["c_r"] ** 2), 2 * np.pi * frequency
        q["k_u"], q["d_u"] = inertia * w**2, 2 * zeta * w * inertia
    if "compliance" in hidden:
        q["C"], q["d"], q["z_t"] = hidden["compliance"], 25.0, hidden.get("axis", 0.4)
    for name in ("sigma_f", "sigma_r"):
        q[name] += hidden.get(name, 0.0)
    q["K"] += hidden.get("damper", 0.0)
    q["C_r1"] *= hidden.get("rear_tyre", 1.0)
    q["I_rz"] += hidden.get("yaw_inertia", 0.0)
    mass, slopes = (each(*(q[str(s)] for s in flexible_motorcycle_by_kane.PARAMETERS)) for each in kane())
    place = {n: i for i, n in enumerate(STATES)}
    mass, slopes = np.array(mass, float), np.array(slopes, float)
    slopes[place["s"], place["delta"]] -= hidden.get("spring", 0.0)
    mass[place["s"], place["s"]] += hidden.get("steer_inertia", 0.0)
    mass[place["p"], place["p"]] += hidden.get("roll_inertia", 0.0)
    if "air_side" in hidden:
        coefficient, height, ahead = hidden["air_side"]
        arm = {"v": 1.0, "r": ahead, "p": height}
        for i, x in arm.items():
            for j, y in arm.items():
                slopes[place[i], place[j]] -= coefficient * speed * x * y
    if "controller" in hidden:  # a steer torque in proportion to the roll rate: nothing in a library of passive effects
        slopes[place["s"], place["p"]] += hidden["controller"]
    held = ({"b", "beta"} if "compliance" not in hidden else set()) | (
        {"q", "theta"} if "lean" not in hidden else set()
    )
    kept = [i for n, i in place.items() if n not in held]
    mass, slopes, names = mass[np.ix_(kept, kept)], slopes[np.ix_(kept, kept)], [STATES[i] for i in kept]
    for device in (hands, inerter):
        if device.__name__ in hidden:
            mass, slopes, names = device(mass, slopes, names, q, hidden[device.__name__])
    return mass, slopes, names


def hands(
    mass: np.ndarray, slopes: np.ndarray, names: list[str], q: dict, rider: dict
) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """A rider's hands on the bar (2011, eqs 1 and 2 with the torso's absolute rate W): torso angle and W as states.

    I_t W' = -T_a - T_w,  theta' = W - w,  w = r cos(eps) + p sin(eps),  T_h = T_a,  T_f = T_w; virtual power
    T_h (s + w) + T_f w. The added inertia I_a turns with the rate s + w of the front frame.
    """
    names, n = [*names, "torso", "W"], len(names)
    at = {x: np.eye(n + 2)[names.index(x)] for x in names}
    w, absolute = np.cos(q["eps"]) * at["r"] + np.sin(q["eps"]) * at["p"], np.zeros(n + 2)
    absolute += at["s"] + w
    arms = rider["k_a"] * (at["torso"] - at["delta"]) + rider["c_a"] * (at["W"] - w - at["s"])
    waist = rider["k_t"] * at["torso"] + rider["c_t"] * (at["W"] - w)
    M, F = np.eye(n + 2), np.zeros((n + 2, n + 2))
    M[:n, :n], F[:n, :n] = mass, slopes
    M += rider["I_a"] * np.outer(absolute, absolute)
    M[-1, -1] = rider["I_t"]
    F += np.outer(absolute, arms) + np.outer(w, waist)
    F[-2], F[-1] = at["W"] - w, -arms - waist
    return M, F, names


def inerter(
    mass: np.ndarray, slopes: np.ndarray, names: list[str], q: dict, values: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """An inerter b in series with a damper c between the frames: b z' = c (s - z), the torque c (s - z) against s."""
    del q
    (b, c), n, steer = values, len(names), names.index("s")
    M, F = np.eye(n + 1), np.zeros((n + 1, n + 1))
    M[:n, :n], F[:n, :n] = mass, slopes
    across = np.zeros(n + 1)
    across[steer], across[-1], M[-1, -1] = c, -c, b
    F[steer] -= across
    F[-1] = across
    return M, F, [*names, "z"]


def spectrum(p: dict, speeds: np.ndarray, hidden: dict) -> dict[str, np.ndarray]:
    """The eigenvalues over ascending speeds of weave, wobble and capsize, named at the highest and followed
    downwards."""
    fine = np.unique(np.concatenate([speeds, np.arange(speeds[0], speeds[-1], FINE)]))[::-1]
    values = np.linalg.eigvals(matrix(p, fine[0], hidden))
    upper = [i for i in range(len(values)) if values[i].imag > 1.0 and values[i].real > (-40 if "hands" in hidden else -20)]
    real = [i for i in range(len(values)) if values[i].imag == 0]
    front = min(upper, key=lambda i: abs(values[i].imag - 55.0))
    # Stiff riders overdamp the wobble; then the oscillation of the front at 5 to 7 Hz is the rider-wobble.
    name = "rider_wobble" if "hands" in hidden and values[front].imag < 45.0 else "wobble"
    weave = min((i for i in upper if i != front), key=lambda i: abs(values[i].imag - 22.0))
    chosen = {"weave": weave, name: front, "capsize": min(real, key=lambda i: abs(values[i]))}
    followed = {n: [values[i]] for n, i in chosen.items()}
    track = values
    for speed in fine[1:]:
        new = np.linalg.eigvals(matrix(p, speed, hidden))
        new = new[linear_sum_assignment(np.abs(track[:, None] - new[None, :]))[1]]
        track = new
        for n, i in chosen.items():
            followed[n].append(new[i])
    places = np.searchsorted(-fine, -speeds)
    found = {n: np.array(each)[places] for n, each in followed.items()}
    return {n: x.real + 1j * np.abs(x.imag) for n, x in found.items()}


def known_to(rng: np.random.Generator, p: dict, share: float = 1.0) -> dict:
    """The motorcycle as it is, where p is what is known of it: to 1 % and 5 %."""
    changed = dict(p)
    for names, spread in ((LENGTHS, 0.01), (OTHERS, 0.05)):
        changed |= {n: p[n] * np.exp(share * spread * rng.standard_normal()) for n in names}
    return changed


def write(path: Path, found: dict[str, np.ndarray], speeds: np.ndarray, rng: np.random.Generator, error: float) -> None:
    """Measured with independent errors of that share of each eigenvalue, 0.02 1/s at least."""
    with Path(path).open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["speed [m/s]", "mode", "real [1/s]", "imag [1/s]", "real_se [1/s]", "imag_se [1/s]"])
        for mode, values in found.items():
            for speed, x in zip(speeds, values, strict=True):
                se = max(error * abs(x), 0.02)
                imag = x.imag + se * rng.standard_normal() if x.imag > 0 else 0.0
                writer.writerow([speed, mode, x.real + se * rng.standard_normal(), abs(imag), se, se])
