"""Blind cases of the gap workflow on a driven joint: which effect is named, under excitations that no rig chose.

The simulator is that of the tests, which shares no code with the library. Every case draws a joint, an excitation, a
sampling rate and the size of what is hidden; a third of them hide nothing. counts[truth][answer] is the confusion matrix.
"""

import sys
from collections import Counter
from pathlib import Path

import numpy as np

from fmus.errors import InputError
from fmus.mechanisms import DrivenJoint, Pendulum
from identification.gap.data.sampled import prepare_sampled
from identification.gap.naming.any_component import investigate
from identification.gap.stands.component_test import component_test
from identification.recordings import Recording

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from simulators.hidden_mechanisms import excitation, simulate

CASES = 60
PERIODS = 30  # of the joint's own frequency in a recording
KINDS = ("random", "multisine", "chirp", "decay", "steps", "road")
FAMILY = {"friction": "coulomb_friction", "hardening": "hardening_stiffness", "backlash": "backlash", "drag": "progressive_damping",
          "hysteresis": "hysteresis", "asymmetry": "asymmetry", "drift": "drift", "sine": "geometric_nonlinearity", "saturation": "saturation",
          "delay": "channel_delay", "extra": "extra_mode"}  # fmt: skip


def sizes(rng: np.random.Generator, joint: dict[str, float], angle: float, torque: float) -> dict:
    """The size of every effect, so that it is seen but does not rule: angle and torque are the joint's without it."""
    frequency = np.sqrt(joint["k"] / joint["J"]) / (2 * np.pi)
    rate = angle * 2 * np.pi * frequency
    u = rng.uniform(0.5, 1.5)
    return {"friction": 0.2 * u * torque, "hardening": 0.4 * u * joint["k"] / angle**2, "backlash": 0.08 * u * angle,
            "drag": u * (0.5 * joint["c"] / rate + 0.05 * joint["k"] * angle / rate**2), "hysteresis": (0.25 * u * torque, 0.1 * angle), "asymmetry": 0.1 * u,
            "drift": 0.15 * u, "sine": 1.0, "saturation": 0.5 * u * angle, "delay": 0.03 * u / frequency,
            "extra": (0.1 * u * joint["J"], frequency * rng.uniform(0.6, 2.5), 0.1)}  # fmt: skip


def case(seed: int) -> tuple[str, Recording]:
    """What is hidden ("none" in every third case), and the recording."""
    rng = np.random.default_rng(seed)
    name = "none" if seed % 3 == 0 else list(FAMILY)[(seed - seed // 3 - 1) % len(FAMILY)]
    kind = KINDS[int(rng.integers(len(KINDS)))]
    joint = {"J": 0.1 * np.exp(rng.normal()), "k": 10 * np.exp(rng.normal())}
    joint["c"] = 2 * np.sqrt(joint["J"] * joint["k"]) * rng.uniform(0.03, 0.2)
    frequency = np.sqrt(joint["k"] / joint["J"]) / (2 * np.pi)
    time = np.arange(0, PERIODS / frequency * (0.4 if kind == "decay" else 1.0), 1 / (frequency * rng.uniform(40, 90)))
    angle = 1.2 if name == "sine" else float(np.exp(rng.uniform(-3, 0)))
    start, drive, torque = (angle, 0.0), excitation("decay", rng, time[-1], 1.0, 0.0), 0.1 * joint["k"] * angle
    if kind != "decay":
        unit = excitation(kind, rng, time[-1], 2.5 * frequency, 1.0)
        factor = angle / np.abs(simulate(joint, {}, unit, time)[0][:, 0]).max()
        start, drive, torque = (0.0, 0.0), lambda t: factor * unit(t), factor
    hidden = {} if name == "none" else {name: sizes(rng, joint, angle, torque)[name]}
    joint["sliding"] = 1e-3 * angle * 2 * np.pi * frequency
    motion, told = simulate(joint, hidden, drive, time, start)
    columns = {"angle": motion[:, 0] + 0.005 * motion[:, 0].std() * rng.standard_normal(len(time))}
    if kind != "decay":
        columns["torque"] = told
    return name, Recording(f"{name}_{kind}_{seed}", time, columns, {"torque": "N.m", "angle": "rad"})


def answer(name: str, recording: Recording) -> str:
    """The families that are named, or the verdict."""
    test = component_test(Pendulum() if name == "sine" else DrivenJoint(), list(recording.columns))
    try:
        verdict = investigate(test, [prepare_sampled(recording, test)]).verdict
    except InputError:
        return "refused"
    return "+".join(sorted(c.family for c in verdict.effects)) if verdict.verdict == "named" else verdict.verdict


def run(progress, cases: int = CASES) -> dict:
    """Counts of right and wrong names and of false alarms, with the confusion matrix."""
    counts: Counter[tuple[str, str]] = Counter()
    for seed in progress(range(cases)):
        name, recording = case(seed)
        counts[name, answer(name, recording)] += 1
    named = ("none", "unknown", "tied", "refused")
    hidden = {k: n for k, n in counts.items() if k[0] != "none"}
    return {
        "cases": cases,
        "hidden": sum(hidden.values()),
        "right": sum(n for (truth, said), n in hidden.items() if said == FAMILY[truth]),
        "wrong": sum(n for (truth, said), n in hidden.items() if said not in (*named, FAMILY[truth])),
        "false_alarms": sum(n for (truth, said), n in counts.items() if truth == "none" and said not in named),
        "nothing_hidden": sum(n for (truth, _), n in counts.items() if truth == "none"),
        "counts": {truth: {said: n for (t, said), n in sorted(counts.items()) if t == truth} for truth, _ in sorted(counts)},
    }
