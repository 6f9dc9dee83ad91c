"""Blind cases of the gap workflow on vehicles: effects hidden in eigenvalues that are made apart from the package.

Every motorcycle is another: parameters that are published are known to 1 % (lengths, masses) and 5 % (inertias, tyres,
damper), and the real one differs by as much. Nothing is hidden in a third of the cases. Rates with Wilson's interval.
"""

import json
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

from benchmarks._resumed import command_line, resumed
from benchmarks.gap_blind import wilson
from fmus.support.progress import track
from motofmi.gap.estimation.fit_result import parameters_of
from motofmi.gap.preprocessing.eigenvalues import read_eigenvalues
from motofmi.gap.selection.eigenvalues import select_model_for_eigenvalues
from motofmi.workflows.gap.vehicle import vehicle_effects, vehicle_experiment, with_mode_names
from motofmi.workflows.measured_rider import table_spread
from rider_fmu.rigs.handlebar import HANDLEBAR_INERTIA
from tests.simulators.hidden_vehicle import SHARP, known_to, spectrum, write
from tests.vehicle_fmu.test_motorcycle import KANE_NAMES
from vehicle_fmu import Motorcycle

CASES, FIRST = 150, 5000
CLEAR = 40.0  # delta chi-square from which naming is reliable
HIDDEN = {
    "frame_compliance": lambda r: (
        {"compliance": 10 ** r.uniform(-5.3, -4.2), "axis": r.uniform(0.2, 0.6)},
        "compliance",
    ),
    "rider_lean": lambda r: ({"lean": (r.uniform(10, 50), r.uniform(1, 4), r.uniform(0.1, 0.5))}, "mass"),
    "tyre_relaxation": lambda r: (dict.fromkeys(("sigma_f", "sigma_r"), r.uniform(0.05, 0.3)), "length"),
    "roll_inertia": lambda r: ({"roll_inertia": r.uniform(10, 40)}, "inertia"),
    "aerodynamics": lambda r: ({"air_load": r.uniform(0.05, 0.2)}, "load"),
    "steer_damping": lambda r: ({"damper": r.uniform(2, 8)}, "damping"),
    "steer_stiffness": lambda r: ({"spring": r.uniform(5, 60)}, "stiffness"),
    "added_inertia": lambda r: ({"steer_inertia": r.uniform(0.08, 0.3)}, "inertia"),
}
HANDS = {
    "passive_rider": lambda r: (
        {"hands": dict(zip(("I_a", "I_t", "k_a", "k_t", "c_a", "c_t"), rider(r), strict=True))},
        "torso_inertia",
    ),
    "steer_damping": HIDDEN["steer_damping"],
    "inerter": lambda r: ({"inerter": (r.uniform(0.1, 0.3), r.uniform(4, 12))}, ""),
}
FAMILY = {"inerter": "steer_damping"}
OUTSIDE = {
    "controller": lambda r: ({"controller": r.uniform(10, 40) * r.choice([-1, 1])}, ""),
    "another tyre": lambda r: ({"rear_tyre": r.choice([0.6, 1.6])}, ""),
    "another yaw inertia": lambda r: ({"yaw_inertia": r.uniform(8, 20)}, ""),
}
SIZES = {
    "compliance": "compliance",
    "mass": "lean",
    "length": "sigma_f",
    "load": "air_load",
    "damping": "damper",
    "stiffness": "spring",
}


def rider(rng: np.random.Generator) -> np.ndarray:
    """Parameters (6,) of a rider drawn from the population of the ten riders of 2011, the added inertia first."""
    drawn = table_spread(1, int(rng.integers(2**31)))[0]
    return drawn - np.array([HANDLEBAR_INERTIA, 0, 0, 0, 0, 0])


def motorcycle(p: dict) -> Motorcycle:
    """The component with these values."""
    return Motorcycle("known", **{KANE_NAMES[n]: x for n, x in p.items() if n in KANE_NAMES})


def case(name: str, seed: int, folder: Path) -> dict:
    """One blind case: the verdict, the names, the truth's size and what was found."""
    rng = np.random.default_rng(seed)
    known = known_to(rng, SHARP, share=2.0)
    hidden, parameter = {**HIDDEN, **HANDS, **OUTSIDE}[name](rng) if name != "none" else ({}, "")
    speeds = np.sort(rng.uniform(6, 58, rng.integers(8, 21)))
    found = spectrum(known_to(rng, known), speeds, hidden)
    if rng.random() < 0.3:
        found.pop("capsize")
    write(folder / "eigenvalues.csv", found, speeds, rng, rng.uniform(0.004, 0.02))
    base = motorcycle(known)
    experiment = vehicle_experiment(base)
    run = with_mode_names(read_eigenvalues(folder / "eigenvalues.csv"), experiment)
    verdict = select_model_for_eigenvalues(experiment, [run], vehicle_effects(base, linear=True))
    names = [c.family for c in verdict.effects] or [c.family for c in verdict.tied]
    family = FAMILY.get(name, name)
    best = max((c.delta_chi2 for c in verdict.candidates if c.family == family), default=0.0)
    result = {
        "truth": name,
        "family": family,
        "verdict": verdict.verdict,
        "names": names,
        "delta_chi2": best,
        "before": verdict.base.reduced,
        "after": verdict.best.reduced,
    }
    found_parameters = parameters_of(verdict.best)
    if verdict.verdict == "named" and names == [name] and f"vehicle.{name}.{parameter}" in found_parameters:
        value, error, _ = found_parameters[f"vehicle.{name}.{parameter}"]
        size = hidden[SIZES.get(parameter, "roll_inertia" if name == "roll_inertia" else "steer_inertia")] if name != "passive_rider" else hidden["hands"]["I_t"]
        truth = np.ravel(size)[0]
        result |= {"size_ok": bool(abs(value - truth) <= max(0.05 * abs(truth), 2 * error)), "size": value / truth}
    return result


def run(progress, cases: int = CASES, out: str | Path | None = None, first: int = FIRST) -> dict:
    """The confusion matrix and the rates that matter; cases that the folder `out` holds already are not run again."""

    def one(number: int) -> dict:
        others, hands = [*HIDDEN, *OUTSIDE], [*HANDS, "passive_rider", "passive_rider"]
        turn = number // 3
        name = ("none", others[turn % len(others)], hands[turn % len(hands)])[number % 3]
        with tempfile.TemporaryDirectory() as folder:
            return case(name, first + number, Path(folder))

    return summary(resumed(cases, out, one, first=first))


def summary(results: list[dict]) -> dict:
    """Counts of (truth, answer) and rates."""
    counts = Counter((r["truth"], "+".join(r["names"]) if r["verdict"] == "named" else f"tied({','.join(sorted(r['names']))})" if r["names"] else r["verdict"])
                     for r in results)  # fmt: skip
    quiet = [r for r in results if r["truth"] == "none"]
    inside = [r for r in results if r["truth"] in {**HIDDEN, **HANDS}]
    clear = [r for r in inside if r["delta_chi2"] > CLEAR]
    hands = [r for r in clear if r["truth"] in HANDS]
    riders = [r for r in clear if r["truth"] == "passive_rider"]
    outside = [r for r in results if r["truth"] in OUTSIDE]
    named = [r for r in inside if r["verdict"] == "named"]
    sized = [r for r in results if "size_ok" in r]

    def right(rows: list[dict]) -> dict:
        return wilson(sum(r["family"] in r["names"] for r in rows), len(rows))

    return {
        "cases": len(results), "confusion": {f"{a} -> {b}": n for (a, b), n in sorted(counts.items())},
        "false_alarms": wilson(sum(r["verdict"] != "none" for r in quiet), len(quiet)),
        "right_or_in_the_tie": right(clear),
        "a_device_right_or_in_the_tie": right(hands),
        "a_rider_right_or_in_the_tie": right(riders),
        "a_rider_named": wilson(sum(r["names"] == ["passive_rider"] and r["verdict"] == "named" for r in riders), len(riders)),
        "wrong_names": wilson(sum(r["family"] not in r["names"] for r in named), len(named)),
        "outside_named": wilson(sum(r["verdict"] == "named" for r in outside), len(outside)),
        "sizes_within_5_percent_or_2_errors": wilson(sum(r["size_ok"] for r in sized), len(sized)),
    }  # fmt: skip


def main() -> None:
    arguments = command_line("gap_vehicle", __doc__, CASES, first=FIRST)
    print(json.dumps(run(track, arguments.cases, arguments.out, arguments.first), indent=1))


if __name__ == "__main__":
    main()
