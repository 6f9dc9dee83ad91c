"""Machines of public benchmarks, from a mass-spring-damper whose values say nothing of them: what is named, and how near the values come.

An electro-mechanical positioning system with dry friction, the Silverbox with its hardening spring, and the Bouc-Wen
oscillator, each simulated from its published equations (see `tests/simulators/machines.py`), with a held-out run of
another excitation.
"""

import time
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from fmus.mechanisms import MassSpringDamper
from motofmi.gap.estimation.fit_result import parameters_of
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.selection.any_component import investigate
from motofmi.recordings.recording import Recording
from tests.simulators.machines import BOUC_WEN, POSITIONING, SILVERBOX, bouc_wen, positioning, silverbox

# Fitted run, held-out run, and the published values by their names here.
LOOP = BOUC_WEN["beta"] * BOUC_WEN["gamma"]
MACHINES = {
    "positioning": (lambda: positioning(1), lambda: positioning(2, 0.25),
                    {"mass": POSITIONING["mass"], "spring_damping": POSITIONING["viscous"], "coulomb_friction.friction_torque": POSITIONING["coulomb"]}),
    "silverbox": (lambda: silverbox(5, 20000), lambda: silverbox(6, 20000, 0.06),
                  {"mass": SILVERBOX["mass"], "spring_stiffness": SILVERBOX["stiffness"], "spring_damping": SILVERBOX["damping"],
                   "hardening_stiffness.cubic_stiffness": SILVERBOX["cubic"]}),
    "bouc_wen": (lambda: bouc_wen(1), lambda: bouc_wen(2, 1),
                 {"mass": BOUC_WEN["mass"], "spring_stiffness": BOUC_WEN["stiffness"], "spring_damping": BOUC_WEN["damping"],
                  "hysteresis.force": BOUC_WEN["alpha"] / LOOP, "hysteresis.width": 1 / LOOP, "hysteresis.shape": -BOUC_WEN["delta"] / BOUC_WEN["gamma"]}),
}  # fmt: skip


def as_recording(name: str, columns: tuple[np.ndarray, np.ndarray, np.ndarray]) -> Recording:
    """Time, force and displacement as a recording."""
    time, force, displacement = columns
    return Recording(name, time, {"force": force, "displacement": displacement}, {"force": "N", "displacement": "m"})


def run(progress: Callable[..., Iterable]) -> dict[str, Any]:
    """By machine: the verdict, what is named, and every published value with what was found."""
    results = {}
    for name, (fitted, held, published) in progress(MACHINES.items(), "machines"):
        recordings = [as_recording(f"{name}_{i}", made()) for i, made in enumerate((fitted, held))]
        test = input_output_experiment(MassSpringDamper(), ["force", "displacement"])
        begun = time.perf_counter()
        verdict = investigate(test, [prepare_sampled_run(recordings[0], test)], validation=recordings[1:]).verdict
        seconds, found = time.perf_counter() - begun, parameters_of(verdict.best)
        results[name] = {
            "verdict": verdict.verdict, "effects": [f"{c.family}.{c.effect.form}" for c in verdict.effects], "reduced_chi2": verdict.best.reduced,
            "values": {n: {"published": value, "found": found[n][0], "standard_error": found[n][1]} for n, value in published.items() if n in found},
            "seconds": seconds,
        }  # fmt: skip
    return results
