"""A joint with a further body, or a Maxwell element, at several scales of time: the effect named does not depend on how
fast the joint moves.

With the time t / r, inertias J / r^2 and the damping c / r the motion is the same function of t.
"""

import numpy as np
import pytest
from scipy.signal import StateSpace, lsim

import motofmi as mf
from motofmi.recordings.recording import Recording
from tests.few_laws import only_families
from tests.motofmi.gap.smoothly_driven_joint import DAMPING, INERTIA, STIFFNESS, smooth_torque, with_noise

BODY, FREQUENCY, RATIO = 0.012, 0.6, 0.1  # kg.m2, Hz, 1
OMEGA = 2 * np.pi * FREQUENCY
# angle, rate, twist and rate of the body, whose acceleration is -OMEGA^2 twist - 2 RATIO OMEGA (body's rate - rate)
SWING = [0, 2 * RATIO * OMEGA, -(OMEGA**2), -2 * RATIO * OMEGA]
REACTION = np.array([-STIFFNESS, -DAMPING, 0, 0]) - BODY * np.array(SWING)
WITH_BODY = StateSpace(
    [[0, 1, 0, 0], REACTION / INERTIA, [0, -1, 0, 1], SWING], [[0], [1 / INERTIA], [0], [0]], [[1, 0, 0, 0]], [[0]]
)

SERIES, RELAXATION = 0.5 * STIFFNESS, 0.15  # N.m/rad and s
# angle, rate, and the deflection of the damper in series
MAXWELL = StateSpace(
    [[0, 1, 0], [-(STIFFNESS + SERIES) / INERTIA, -DAMPING / INERTIA, SERIES / INERTIA], [1 / RELAXATION, 0, -1 / RELAXATION]],
    [[0], [1 / INERTIA], [0]], [[1, 0, 0]], [[0]],
)  # fmt: skip


def run_at(rate: float, seed: int, system: StateSpace = WITH_BODY) -> Recording:
    """A smooth torque of 100 s, sampled at 20 Hz; the time is divided by `rate`."""
    random, fine = np.random.default_rng(seed), np.arange(0.0, 100.0, 0.005)
    torque = smooth_torque(fine, random)
    _, angle, _ = lsim(system, torque, fine)
    columns = {"torque": torque[::10], "angle": with_noise(angle[::10], random)}
    return Recording(f"run_{seed}", fine[::10] / rate, columns, {"torque": "N.m", "angle": "rad"})


@pytest.mark.parametrize("rate", [1.0, 50.0, 1000.0])
def test_a_further_body_is_named_at_any_scale_of_time(rate, monkeypatch):
    """With starting values of 0.6 Hz to 16 Hz at all scales, a delay was named at 600 Hz."""
    only_families(monkeypatch, ("extra_mode", "hysteresis", "channel_delay", "coulomb_friction"))
    joint = mf.mechanism("driven_joint", inertia=INERTIA / rate**2, damping=DAMPING / rate, stiffness=STIFFNESS)
    found = mf.find_gap(run_at(rate, 1), validation=run_at(rate, 2), component=joint)
    (effect,) = found.effects
    assert effect["name"] == "extra_mode"
    frequency, inertia = (effect["parameters"][name] for name in ("frequency", "inertia"))
    assert frequency["value"] == pytest.approx(rate * FREQUENCY, abs=4 * frequency["standard_error"])
    assert inertia["value"] == pytest.approx(BODY / rate**2, abs=4 * inertia["standard_error"])
    assert frequency["standard_error"] < 0.01 * rate * FREQUENCY


@pytest.mark.parametrize("rate", [1.0, 1000.0])
def test_a_maxwell_element_is_named_at_any_scale_of_time(rate, monkeypatch):
    """A relaxation time of 0.15 ms is below the bound of 1 ms for the arms of a rider."""
    only_families(monkeypatch, ("extra_mode", "viscoelastic_arm", "channel_delay", "coulomb_friction"))
    joint = mf.mechanism("driven_joint", inertia=INERTIA / rate**2, damping=DAMPING / rate, stiffness=STIFFNESS)
    found = mf.find_gap(run_at(rate, 1, MAXWELL), validation=run_at(rate, 2, MAXWELL), component=joint)
    (effect,) = found.effects
    assert effect["name"] == "viscoelastic_arm"
    time, stiffness = (effect["parameters"][name] for name in ("relaxation_time", "series_stiffness"))
    assert time["value"] == pytest.approx(RELAXATION / rate, abs=4 * time["standard_error"])
    assert stiffness["value"] == pytest.approx(SERIES, abs=4 * stiffness["standard_error"])
    assert time["standard_error"] < 0.02 * RELAXATION / rate
