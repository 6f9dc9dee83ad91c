"""Runs of a simulated rig with a hidden effect, reduced as the workflow takes them, and what a test lets compete for them."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from fmus.effects import Effect
from motofmi.gap.preprocessing.steer_test_run import SteerTestRun, prepare_steer_test_run
from motofmi.workflows.gap.rig import rig_effects
from tests.simulators.as_recordings import as_recording
from tests.simulators.hidden_rig import RIDER, Rig, record

RIG = {"handlebar_inertia": {"value": 0.125, "standard_error": 0.00125}}  # what rig.json says of the bar


def prepared(made: Mapping[str, Any]) -> list[SteerTestRun]:
    """Runs of arrays by name."""
    return [
        prepare_steer_test_run(as_recording(name, arrays), "steer_angle", "steer_torque", "steer_angle_command")
        for name, arrays in made.items()
    ]


def runs_of(hidden, *tests, seed=3, rider=RIDER, **rig) -> list[SteerTestRun]:
    """Runs of a rider who hides something, one for each excitation."""
    rng = np.random.default_rng(seed)
    return prepared(
        {f"run_{i}": record(excitation, hidden, rider, rng, Rig(**rig)) for i, excitation in enumerate(tests)}
    )


def library(*families: str) -> list[type[Effect]]:
    """The effects of these families."""
    return [e for e in rig_effects() if e.family in families]
