"""Blind cases: a rider, a rig, tests and something hidden, all drawn by a seed, as recordings and as the truth apart.

Sizes are drawn so that an effect changes chi-square by 10 to 100,000; NOMINAL says which size of it gave which change
of chi-square on the usual rig, the base refitted.
"""

import json
from dataclasses import asdict, dataclass, replace

import numpy as np

from .hidden_rig import RIDER, Rig, record, stepped, sweep, today

# Published riders (2011, Table 2): torso inertia, arm and waist stiffness, arm and waist damping.
RIDERS = ((0.6441, 1053.4, 75.8, 19.28, 4.79), (0.7626, 1050.8, 85.2, 16.02, 5.94), (0.7587, 946.9, 91.7, 21.75, 7.30),
          (0.7059, 1851.8, 166.2, 22.04, 9.25), (0.5085, 1358.2, 81.0, 16.35, 4.98), (0.9681, 1444.7, 126.8, 47.22, 7.07),
          (0.6719, 604.9, 95.1, 7.49, 2.15), (0.5080, 1293.3, 64.6, 14.16, 5.12))  # fmt: skip
NOMINAL = {
    "Tc": (0.1, 1000), "Tl": (0.1, 716), "k2": (100, 213), "k3": (3000, 1000), "k5": (5e6, 4.98e4), "kx": (100, 5.7e4), "g": (5e-4, 3.3e4),
    "gs": (5e-4, 2.6e4), "c2": (0.3, 1.5e4), "c3": (0.1, 2.6e4), "cp": (0.3, 2350), "Fh": (0.3, 2260), "Fd": (0.3, 1340), "ra": (0.01, 8550),
    "qa": (100, 1700), "sa": (0.01, 6320), "rd": (0.05, 81), "rk": (0.05, 43), "rc": (0.05, 65), "rj": (0.05, 448), "re": (0.05, 60), "kr": (5, 249),
    "td": (0.002, 605), "te": (0.002, 1250), "Ih": (0.02, 3340), "J": (0.01, 41), "Icc": (0.03, 48), "ks": (5, 43), "cs": (0.5, 73),
    "Tw": (0.3, 2980), "km": (50, 38), "C": (2e-5, 116), "g3": (0.02, 9900), "g2": (0.02, 6350), "bx": (20, 1.97e5), "eb": (0.05, 1.03e4),
    "Ar": (0.1, 2460), "ce": (0.2, 6.4e4), "hs": (0.3, 4900), "rl": (0.3, 138), "kd": (1000, 1000),
    "kw": (1000, 600), "ga": (3, 444), "ji": (0.5, 1950),
}  # fmt: skip
LARGEST = {"rd": 0.4, "rk": 0.5, "rc": 0.5, "rj": 0.5, "re": 0.5, "rl": 0.5, "kr": 40.0, "td": 0.012, "te": 0.012, "Ih": 0.1, "J": 0.1, "Icc": 0.15, "ks": 60.0, "cs": 4.0,
           "km": 600.0, "C": 3e-4, "k2": 4e3, "Tc": 1.5, "Tl": 1.5, "Tw": 2.0, "g": 4e-3, "gs": 4e-3}  # fmt: skip
# Family: the parameter that is its size, in forms that the library has; and in forms that it lacks.
LIKE = {
    "coulomb_friction": ["Tc"], "hardening_stiffness": ["k3", "k2", "kx"], "backlash": ["g"], "progressive_damping": ["c2", "c3"],
    "hysteresis": ["Fh", "Fd"], "asymmetry": ["ra", "qa"], "drift": ["rd", "rk", "rc", "rj", "re"], "reflex": ["kr"], "channel_delay": ["td"],
    "shaft_compliance": ["C"], "extra_mode": ["Ih"], "viscoelastic_arm": ["km"], "waist_friction": ["Tw"], "sensor_nonlinearity": ["g3", "g2"],
}  # fmt: skip
UNLIKE = {
    "coulomb_friction": ["Tl"], "hardening_stiffness": ["kd"], "backlash": ["gs"], "progressive_damping": ["cp"], "hysteresis": ["Fd"],
    "asymmetry": ["sa"], "drift": ["rl"], "reflex": ["kr"], "extra_mode": ["Ih"], "channel_delay": ["te"],
}  # fmt: skip
OUTSIDE = {
    "product": "bx",  # torque with deflection times rate
    "breathing": "eb",  # the arms' stiffness swings on its own
    "cogging": "Ar",  # torque with the place of the bar
    "sensor_memory": "hs",  # hysteresis of the torque sensor
    "softening": "k3",  # negative: arms that soften as they deflect
    "thinning": "c2",  # negative: damping that falls with the rate
    "stiffening_waist": "kw",  # the spring of the waist, not that of the arms
    "uneven_angle": "ga",  # the angle sensor's gain grows with the angle
    "swinging_inertia": "ji",  # the bar's inertia grows with the angle
}
TRIO = {"cross_inertia": "Icc", "steer_stiffness": "ks", "steer_damping": "cs"}
CYCLE = ("none", "single", "none", "none", "unlike", "none", "none", "single", "none", "outside", "none", "trio", "none", "single", "none", "none",
         "pair", "none", "single", "none", "none", "unlike", "none", "outside", "single")  # fmt: skip


@dataclass
class Truth:
    """What a case hides: families (none where nothing), the parameters of the simulator, rider, rig and test.

    decimals are those of the time stamps [s]; the handlebar's inertia is in rig.json if it is known.
    """

    kind: str
    families: list[str]
    hidden: dict[str, float]
    trouble: str
    change: float
    rider: dict[str, float]
    rig: Rig
    amplitude: float
    length: float
    band: tuple[float, float]
    logarithmic: bool
    dwell: float
    decimals: int
    known: bool


def draw(number, seed, kind=None):
    """The truth of a case."""
    rng = np.random.default_rng([seed, number])
    kind = kind or CYCLE[number % len(CYCLE)]
    spread = rng.uniform(0.15, 0.25)
    values = dict(zip(list(RIDER)[1:], RIDERS[rng.integers(len(RIDERS))], strict=True))
    rider = {
        "Is": _between(rng, 0.04, 0.4),
        **{n: v * float(np.exp(spread * rng.standard_normal())) for n, v in values.items()},
    }
    trouble = str(rng.choice(["", "", "bursts", "doubled noise", "6 % change"])) if kind == "none" else ""
    noise = 2.0 if trouble == "doubled noise" else 1.0
    rig = Rig(rate=int(rng.choice([64, 100, 128, 200, 256, 500, 1000])), bits=int(rng.choice([10, 12, 12, 14, 16])), lag=float(rng.uniform(0.0, 0.06)),
              angle_noise=float(np.radians(_between(rng, 0.01, 0.06))) * noise, torque_noise=_between(rng, 0.07, 0.6) * noise,
              remnant=_between(rng, 0.1, 1.0) * noise, bursts=6 if trouble == "bursts" else 0,
              angle_offset=float(np.radians(rng.normal(0, 0.5))), torque_offset=float(rng.normal(0, 2.0)))  # fmt: skip
    change = 0.06 if trouble == "6 % change" else float(rng.uniform(0.03, 0.05))
    families, hidden = _hidden(kind, rng)
    band = float(rng.choice([0.3, 0.5, 1.0])), min(float(rng.choice([8, 10, 12, 15])), rig.rate / 6)
    return Truth(kind, families, hidden, trouble, change, rider, rig, _between(rng, 1.0, 4.0), float(rng.choice([100, 150, 200, 300])), band,
                 bool(rng.random() < 0.4), float(rng.choice([8, 10, 12])), int(rng.choice([3, 6, 9])), bool(rng.random() < 0.75))  # fmt: skip


def _between(rng, low, high):
    """A number whose logarithm is uniform."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _hidden(kind, rng):
    if kind == "none":
        return [], {}
    if kind == "pair":
        distinct = [
            f for f in LIKE if f not in ("drift", "viscoelastic_arm", "reflex", "shaft_compliance", "extra_mode")
        ]
        one, two = (str(f) for f in rng.choice(distinct, 2, replace=False))
        return [one, two], {**_sized(LIKE[one][0], rng, 300, 1e4), **_sized(LIKE[two][0], rng, 300, 1e4)}
    if kind == "outside":
        name = str(rng.choice(list(OUTSIDE)))
        size = _sized(OUTSIDE[name], rng, 200, 2e4)
        return [name], ({n: -x for n, x in size.items()} if name in ("softening", "thinning") else size)
    table = {"single": LIKE, "unlike": UNLIKE, "trio": {n: [p] for n, p in TRIO.items()}}[kind]
    family = str(rng.choice(list(table)))
    low, high = {"single": (10, 1e5), "unlike": (100, 3e4), "trio": (30, 3e3)}[kind]
    hidden = _sized(str(rng.choice(table[family])), rng, low, high)
    if family == "hysteresis":
        hidden |= {
            "wh": float(rng.uniform(0.004, 0.03)),
            "wd": float(rng.uniform(0.004, 0.03)),
            "nd": 3.5 if kind == "unlike" else 1.0,
        }
    if family == "reflex":
        hidden |= {"tau": float(rng.uniform(0.06, 0.18)), "tm_r": 0.04 if kind == "unlike" else 0.0}
    if family == "extra_mode":
        hidden |= {
            "fh": float(rng.uniform(2.5, 7)),
            "zh": float(rng.uniform(0.15, 0.45)),
            "ph": 4.0 if kind == "unlike" else 0.0,
        }
    if family == "viscoelastic_arm":
        hidden |= {"tm": float(np.exp(rng.uniform(np.log(0.03), np.log(0.3))))}
    return [family], hidden


def _sized(name, rng, low, high):
    """A size that changes chi-square by about as much as is drawn."""
    size, change = NOMINAL[name]
    drawn = size * np.sqrt(np.exp(rng.uniform(np.log(low), np.log(high))) / change)
    return {name: float(min(drawn, LARGEST.get(name, np.inf)))}


class Laboratory:
    """The rig with its rider in it: writes recordings into a folder; the truth is in `secret()` only."""

    def __init__(self, truth, number, seed):
        self.truth, self.rng = truth, np.random.default_rng([seed, number, 1])
        self.commanded, self.stepped = self.rng.random() < 0.75, self.rng.random() < 0.75

    def deliver(self, folder):
        """The recordings of the case: up-sweep, often a stepped run, and a down-sweep that is to be held out."""
        t = self.truth
        folder.mkdir(parents=True, exist_ok=True)
        low, high = t.band
        self.write(folder / "sweep_up.csv", sweep(low, high, t.amplitude, t.length, t.logarithmic))
        if self.stepped:
            self.write(folder / "stepped.csv", stepped(max(low, 0.5), 0.7 * high, 0.5, 1.7 * t.amplitude, t.dwell))
        self.write(folder / "holdout.csv", sweep(high, low, 1.3 * t.amplitude, 0.8 * t.length, t.logarithmic))
        if t.known:
            error = 0.01 * t.rider["Is"]
            known = {
                "value": t.rider["Is"] + error * self.rng.standard_normal(),
                "standard_error": error,
                "unit": "kg.m2",
            }
            (folder / "rig.json").write_text(json.dumps({"handlebar_inertia": known}))

    def more(self, folder, experiment):
        """A further run as proposed; its file."""
        t, kind = self.truth, experiment["experiment"]
        path = folder / f"{kind}.csv"
        if kind == "bare_bar":
            nobody = {"It": 1e6, "ka": 1e-6, "kt": 1.0, "ca": 1e-6, "ct": 1.0}
            at_the_bar = {
                n: v
                for n, v in t.hidden.items()
                if n in ("ks", "cs", "Tc", "Ts", "Tl", "td", "te", "C", "g2", "g3", "hs", "Ar", "ga", "ji")
            }
            self.write(
                path, self._sweep(experiment), {"Is": t.rider["Is"], **nobody}, at_the_bar, replace(t.rig, remnant=0.0)
            )
        else:
            self.write(path, self._sweep(experiment), gyro="gyro" in kind)
        return path

    @staticmethod
    def _sweep(experiment):
        settings = experiment["settings"]
        return sweep(settings["from"], settings["to"], np.degrees(settings["amplitude"]), settings["duration"])

    def write(self, path, excitation, rider=None, hidden=None, rig=None, gyro=False):
        t = self.truth
        rider = rider or today(t.rider, t.change, self.rng)
        time, command, *shown = record(
            excitation, t.hidden if hidden is None else hidden, rider, self.rng, rig or t.rig
        )
        names = [
            "time [s]",
            "steer_angle_command [rad]",
            "steer_angle [rad]",
            "steer_torque [N.m]",
            "torso_rate [rad/s]",
        ]
        columns = [time, command, *shown]
        kept = [i for i in range(5) if (i != 1 or self.commanded) and (i != 4 or gyro)]
        formats = [f"%.{t.decimals}f", *["%.9g"] * (len(kept) - 1)]
        np.savetxt(
            path,
            np.column_stack([columns[i] for i in kept]),
            formats,
            ",",
            header=",".join(names[i] for i in kept),
            comments="",
        )

    def secret(self):
        """The truth as a file may hold it."""
        return asdict(self.truth)
