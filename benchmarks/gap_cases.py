"""Blind cases of the gap workflow: effects hidden by the simulator of the tests, and how often the right one is named.

Half of the cases hide nothing, with bursts, doubled noise or a rider who changes by 6 % among them. Rates come with
Wilson's 95 % interval.
"""

import sys
from collections import Counter
from pathlib import Path

import numpy as np

from identification.gap.decide import decide
from identification.gap.model import Model
from identification.gap.runs import prepare
from scenarios.rig_test import rig_effects, rig_test

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from simulators.as_recordings import as_recording
from simulators.hidden_rig import case

CASES = 20
RIG = {"handlebar_inertia": {"value": 0.125, "standard_error": 0.00125}}
HIDDEN = {
    "coulomb_friction": lambda r: {"Tc": r.uniform(0.2, 0.8)},
    "hardening_stiffness": lambda r: {"k3": r.uniform(5e3, 3e4)},
    "backlash": lambda r: {"g": r.uniform(0.0005, 0.003)},
    "progressive_damping": lambda r: {"c2": r.uniform(0.5, 3.0)},
    "hysteresis": lambda r: {"Fh": r.uniform(0.3, 1.5), "wh": r.uniform(0.005, 0.03)},
    "asymmetry": lambda r: {"ra": r.uniform(0.02, 0.1)},
    "drift": lambda r: {"rd": r.uniform(0.08, 0.25)},
    "reflex": lambda r: {"kr": r.uniform(8, 25), "tau": r.uniform(0.06, 0.15)},
    "channel_delay": lambda r: {"td": r.uniform(0.002, 0.008)},
    "extra_mode": lambda r: {"Ih": r.uniform(0.03, 0.08), "fh": r.uniform(2.5, 6), "zh": r.uniform(0.15, 0.4)},
}
TROUBLES = ({}, {"bursts": 6}, {"noise": 2.0}, {"change": 0.06})


def run(progress, cases: int = CASES) -> dict:
    """Counts of (truth, verdict), with the rates of false alarms and of right names."""
    library, counts = rig_effects(), Counter()
    for seed in progress(range(cases), "blind cases"):
        rng = np.random.default_rng(seed)
        name = "none" if seed % 2 == 0 else list(HIDDEN)[(seed // 2) % len(HIDDEN)]
        trouble = TROUBLES[(seed // 2) % len(TROUBLES)] if name == "none" else {}
        made, _ = case(HIDDEN[name](rng) if name in HIDDEN else {}, seed=1000 + seed, runs=("sweep_up", "stepped"), **trouble)
        runs = [prepare(as_recording(n, a), "steer_angle", "steer_torque", "steer_angle_command") for n, a in made.items()]
        verdict = decide(Model(rig_test(RIG)), runs, library)
        answer = "+".join(c.family for c in verdict.effects) if verdict.verdict == "named" else verdict.verdict
        counts[name, answer] += 1
    quiet = sum(n for (truth, _), n in counts.items() if truth == "none")
    alarms = sum(n for (truth, answer), n in counts.items() if truth == "none" and answer != "none")
    hidden = sum(n for (truth, _), n in counts.items() if truth != "none")
    right = sum(n for (truth, answer), n in counts.items() if truth != "none" and answer == truth)
    return {"cases": cases, "confusion": {f"{truth} -> {answer}": n for (truth, answer), n in sorted(counts.items())},
            "false_alarms": wilson(alarms, quiet), "right_names": wilson(right, hidden)}  # fmt: skip


def wilson(successes: int, trials: int, z: float = 1.96) -> dict[str, float]:
    """The rate with Wilson's interval (J. Am. Stat. Assoc. 22 (1927) 209-212)."""
    rate = successes / max(trials, 1)
    middle = (rate + z**2 / (2 * trials)) / (1 + z**2 / trials)
    half = z / (1 + z**2 / trials) * np.sqrt(rate * (1 - rate) / trials + z**2 / (4 * trials**2))
    return {"rate": rate, "from": float(middle - half), "to": float(middle + half), "trials": trials}
