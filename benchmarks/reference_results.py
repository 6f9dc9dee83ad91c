"""Forty inputs whose results are kept: modes, FRFs, fits, co-simulations and verdicts, to see what a change of the code changes.

Each input is a command line. Its result is reduced to numbers and words by name, without times, paths and sentences,
and compared with `reference_results.json`. The kept results are not a truth: they say whether results are the same as
before. `python -m benchmarks.reference_results --keep` replaces them.
"""

import argparse
import csv
import json
import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fmus.support.progress import track
from motofmi.frequency_response.excitation import multisine, sweep
from motofmi.recordings.reading import write_recording
from motofmi.virtual_rig.simulated_rig import steer_test
from rider_fmu import riders
from tests.simulators import hidden_bicycle, hidden_joint, hidden_rig, hidden_vehicle
from tests.simulators.as_recordings import as_recording

KEPT = Path(__file__).parent / "reference_results.json"
TOLERANCE = 1e-9  # relative to the largest number of a list: rounding, not method
# Keys whose values are times, paths, versions or sentences.
IGNORED = {"steps_per_second", "sentence", "file", "files", "out", "limitations", "warnings", "report", "model", "fmu", "units", "where", "next_experiment", "criteria",
           "assumed", "notes", "vehicle", "device", "description", "meets_tolerance", "advice", "place", "element"}  # fmt: skip
MODES = ("modes", "--speed", "5:55:5")
RUN = ("--speed", "30", "--duration", "0.5", "--initial", "steer_rate=0.5")
CASES: dict[str, tuple[str, ...]] = {
    "modes alone": (*MODES,),
    "modes mean rider": (*MODES, "--device", "rider:mean_2011"),
    "modes rider changed": (*MODES, "--device", "rider:2_2011", "--set", "arm_damping=30"),
    "modes damper": (*MODES, "--device", "damper:7.5"),
    "modes rider and leaning rider": (*MODES, "--device", "rider:mean_2011,rider:roll_1971"),
    "modes inerter": (*MODES, "--device", "damper:inerter"),
    "modes progressive damper": (*MODES, "--device", "damper:progressive"),
    "modes full rider": ("modes", "--speed", "10,30,50", "--device", "rider:full_mean_2011"),
    "modes reference": (*MODES, "--vehicle", "reference_2011", "--device", "rider:1_2008"),
    "modes bicycle": ("modes", "--vehicle", "benchmark_bicycle", "--speed", "1:10:1"),
    "device mean rider": ("device", "rider:mean_2011", "--frequency", "0.5:12:0.5"),
    "device rider 3": ("device", "rider:3_2008", "--frequency", "0.5:12:0.5"),
    "device full rider": ("device", "rider:full_mean_2011", "--frequency", "0.5:12:0.5"),
    "device inerter": ("device", "damper:inerter", "--frequency", "0.5:12:0.5"),
    "cosimulation default": ("cosimulate", *RUN, "--step", "0.001"),
    "cosimulation damper": ("cosimulate", *RUN, "--step", "0.002", "--device", "damper:7.5"),
    "cosimulation jacobi": ("cosimulate", *RUN, "--step", "0.001", "--coupling", "jacobi"),
    "cosimulation gauss-seidel": ("cosimulate", *RUN, "--step", "0.001", "--coupling", "gauss_seidel"),
    "cosimulation interface-jacobian": ("cosimulate", *RUN, "--step", "0.005", "--coupling", "interface_jacobian"),
    "cosimulation auto step": ("cosimulate", *RUN, "--step", "auto"),
    "cosimulation leaning rider": (
        "cosimulate",
        *RUN,
        "--step",
        "0.001",
        "--device",
        "rider:mean_2011,rider:roll_1971",
    ),
    "cosimulation full rider": ("cosimulate", *RUN, "--step", "0.001", "--device", "rider:full_mean_2011"),
    "frf three runs": ("frf", "{rig_0}", "{rig_1}", "{rig_2}"),
    "frf one run": ("frf", "{rig_0}", "--band", "2:8"),
    "frf torque reference": ("frf", "{rig_0}", "{rig_1}", "--reference", "steer_torque"),
    "identify weighted": ("identify", "{rig_0}", "{rig_1}", "{rig_2}"),
    "identify nyquist": ("identify", "{rig_0}", "{rig_1}", "{rig_2}", "--method", "nyquist"),
    "identify amplitude": ("identify", "{rig_0}", "{rig_1}", "--method", "amplitude"),
    "identify one run": ("identify", "{rig_1}"),
    "gap rig, nothing hidden": ("gap", "{none_up}", "{none_down}"),
    "gap rig, friction": ("gap", "{friction_up}", "{friction_down}"),
    "gap rig, hardening with a validation run": ("gap", "{hardening_up}", "--holdout", "{hardening_down}"),
    "gap rig, play": ("gap", "{play_up}", "{play_down}"),
    "gap rig, multisine": ("gap", "{multisine}"),
    "gap joint, hardening": ("gap", "{joint_hardening}", "--component", "driven_joint"),
    "gap joint, nothing hidden": ("gap", "{joint_none}", "--component", "driven_joint", "--holdout", "{joint_none_2}"),
    "gap joint, friction": ("gap", "{joint_friction}", "--component", "driven_joint"),
    "gap eigenvalues, frame twist": ("gap", "{twist}", "--vehicle", "sharp_1971"),
    "gap eigenvalues, nothing hidden": ("gap", "{plain}", "--vehicle", "sharp_1971"),
    "gap runs of a bicycle": ("gap", "{ride}", "--vehicle", "{matrices}"),
}


def write_inputs(folder: Path) -> dict[str, str]:
    """The files that the commands read, made with fixed seeds: name -> path."""
    paths = {}

    def path(name: str, suffix: str = ".csv") -> Path:
        paths[name] = str(folder / name / f"{name}{suffix}")
        Path(paths[name]).parent.mkdir(parents=True, exist_ok=True)
        return Path(paths[name])

    for k in range(3):
        write_recording(
            steer_test(riders.load("5_2011"), 0.1266, sweep(duration=60), seed=k, oversampling=2), path(f"rig_{k}")
        )
    write_recording(
        steer_test(riders.load("mean_2011"), 0.125, multisine(duration=60), seed=7, oversampling=2), path("multisine")
    )
    hidden: dict[str, dict[str, Any]] = {
        "none": {},
        "friction": {"Tc": 0.6},
        "hardening": {"k3": 6e4},
        "play": {"g": 0.004},
    }
    for name, what in hidden.items():
        for k, (direction, run) in enumerate(
            {"up": hidden_rig.sweep(0.5, 12, 2.0, 100.0), "down": hidden_rig.sweep(12, 0.5, 2.0, 100.0)}.items()
        ):
            made = hidden_rig.record(run, what, hidden_rig.RIDER, np.random.default_rng(k))[:4]
            write_recording(as_recording(f"{name}_{direction}", made), path(f"{name}_{direction}"))
    for name, (what, seed) in {"joint_hardening": ({"hardening": 60.0}, 3), "joint_none": ({}, 9), "joint_none_2": ({}, 10),
                               "joint_friction": ({"friction": 0.1}, 4)}.items():  # fmt: skip
        write_recording(hidden_joint.joint_run(what, "random", seed=seed, duration=8.0, name=name), path(name))
    speeds = np.arange(12.0, 52.0, 5.0)
    for name, what in {"twist": {"compliance": 4e-5}, "plain": {}}.items():
        found = hidden_vehicle.spectrum(hidden_vehicle.SHARP, speeds, what)
        hidden_vehicle.write(path(name), found, speeds, np.random.default_rng(1), 0.01)
    hidden_bicycle.write_matrices(path("matrices", ".toml"))
    rng = np.random.default_rng(2)
    hidden_bicycle.write_ride(
        path("ride"), hidden_bicycle.ride(rng, hidden_bicycle.bicycle(rng, 0.03), duration=60.0, friction=0.3)
    )
    return paths


def results(command: Sequence[str] = (sys.executable, "-m", "motofmi"), folder: Path | None = None,
            progress: Callable[..., Iterable[str]] = track) -> dict[str, dict[str, Any]]:  # fmt: skip
    """What every input gives, by name: numbers, words and lists of numbers by key."""
    found = {}
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    with tempfile.TemporaryDirectory() as temporary:
        paths = write_inputs(Path(temporary) / "inputs")
        for number, name in enumerate(progress(CASES, "reference results", len(CASES))):
            out, words = Path(temporary) / f"out_{number}", [word.format(**paths) for word in CASES[name]]
            words += {"gap": ["--out", str(out)], "cosimulate": ["--out", f"{out}.csv"]}.get(words[0], [])
            done = subprocess.run(
                [*command, *words, "--json", "-"],
                capture_output=True,
                text=True,
                check=False,
                cwd=folder,
                env=environment,
            )
            if done.returncode:
                found[name] = {"error": done.stderr.strip()}
                continue
            found[name] = dict(flattened(json.loads(done.stdout)))
            if words[0] == "cosimulate":
                found[name] |= rows_of(Path(f"{out}.csv"))
    return found


def flattened(value: Any, key: str = "") -> Iterable[tuple[str, Any]]:
    """The leaves of a result by dotted key; a list of numbers is one leaf."""
    if isinstance(value, Mapping):
        for name, each in value.items():
            if name not in IGNORED:
                yield from flattened(each, f"{key}.{name}" if key else name)
    elif isinstance(value, list) and any(isinstance(each, Mapping) for each in value):
        for index, each in enumerate(value):
            yield from flattened(each, f"{key}.{index}")
    else:
        yield key, value


def rows_of(path: Path) -> dict[str, list[float]]:
    """Every tenth of a co-simulation's rows by column, eleven values each."""
    with path.open(newline="", encoding="utf-8") as file:
        heading, *rows = csv.reader(file)
    chosen = [rows[round(k * (len(rows) - 1) / 10)] for k in range(11)]
    return {name: [float(row[i]) for row in chosen] for i, name in enumerate(heading)}


def difference(one: Any, other: Any, key: str = "") -> float:
    """The largest difference of two leaves relative to the largest number in them; infinite where anything else
    differs.

    Eigenvalues are compared as sets, and errors that are relative already by their absolute difference.
    """
    if key == "eigenvalues":
        one, other = (list(map(in_order, each)) for each in (one, other))
    a, b = (list(leaf_numbers(each)) for each in (one, other))
    if len(a) != len(b) or any((isinstance(x, str) or x is None) and x != y for x, y in zip(a, b, strict=True)):
        return math.inf
    pairs = [(x, y) for x, y in zip(a, b, strict=True) if isinstance(x, (int, float)) and isinstance(y, (int, float))]
    largest = max((abs(x) for x, _ in pairs), default=0.0)
    if key.startswith("predicted.") and key.endswith("_error"):
        largest = max(1.0, largest)
    return max((abs(x - y) for x, y in pairs), default=0.0) / (largest or 1.0)


def in_order(eigenvalues: Sequence[Sequence[float]]) -> list[Sequence[float]]:
    """Eigenvalues [real, imaginary] sorted; digits beyond the ninth do not change the order."""
    return sorted(eigenvalues, key=lambda value: [float(f"{part:.9g}") for part in value])


def leaf_numbers(leaf: Any) -> Iterable[Any]:
    """The numbers and words of a leaf in order."""
    if isinstance(leaf, list):
        for each in leaf:
            yield from leaf_numbers(each)
    else:
        yield leaf


def compared(
    now: Mapping[str, Mapping[str, Any]], kept: Mapping[str, Mapping[str, Any]]
) -> dict[str, dict[str, float | str]]:
    """The leaves that differ by more than rounding, by input: key -> relative difference, or what is absent."""
    differing: dict[str, dict[str, float | str]] = {}
    for name, leaves in kept.items():
        wrong: dict[str, float | str] = {k: "absent" for k in leaves if k not in now.get(name, {})}
        for key in leaves.keys() & now.get(name, {}).keys():
            relative = difference(leaves[key], now[name][key], key)
            if relative > TOLERANCE:
                wrong[key] = relative if math.isfinite(relative) else f"{leaves[key]} -> {now[name][key]}"[:200]
        if wrong:
            differing[name] = wrong
    return differing


def run(progress: Callable[..., Iterable[str]]) -> dict[str, Any]:
    """How many of the inputs give what is kept, and which do not."""
    kept = json.loads(KEPT.read_text("utf-8"))
    now = results(progress=progress)
    differing = compared(now, kept)
    verdicts = {n: (kept[n].get("verdict"), now[n].get("verdict")) for n in kept if n.startswith("gap")}
    return {"inputs": len(kept), "equal_to_1e-9": len(kept) - len(differing), "verdicts": len(verdicts),
            "equal_verdicts": sum(a == b for a, b in verdicts.values()), "differing": differing}  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.reference_results", description=__doc__.splitlines()[0])
    parser.add_argument("--keep", action="store_true", help="keep the present results as those to compare with")
    if parser.parse_args().keep:
        KEPT.write_text(json.dumps(results(), separators=(",", ":")).replace('},"', '},\n"') + "\n", "utf-8")
    else:
        print(json.dumps(run(track), indent=1))


if __name__ == "__main__":
    main()
