"""A repeated excitation gives the noise of a recording: what decides where no model is consistent with so little noise.

A joint with a friction of the library and a ripple that is in no library, driven by a multisine of 5 s that is repeated
or by one as long as the recording.
"""

import numpy as np
import pytest

import motofmi as mf
from motofmi.recordings.recording import Recording
from tests.few_laws import only_families
from tests.simulators.hidden_mechanisms import simulate

JOINT = {"J": 0.1, "k": 10.0, "c": 0.1, "sliding": 0.02}
FRICTION = 0.25  # N.m
NOISE = 1e-4  # of the motion


def driven(name: str, period: float, seed: int, noise: float = NOISE, **hidden) -> Recording:
    """60 s at 100 Hz of the joint under a multisine up to 4 Hz of this period [s] and 2 N.m (rms)."""
    rng, time = np.random.default_rng(seed), np.arange(0, 60, 0.01)
    orders = np.arange(1, int(4 * period))
    phases = rng.uniform(0, 2 * np.pi, len(orders))
    size = 2 * np.sqrt(2 / len(orders))
    table = size * np.cos(2 * np.pi * np.outer(time, orders) / period + phases).sum(axis=1)
    motion, torque = simulate(JOINT, hidden, lambda t: np.interp(t, time, table), time)
    angle = motion[:, 0] + noise * motion[:, 0].std() * rng.standard_normal(len(time))
    return Recording(name, time, {"torque": torque, "angle": angle}, {"torque": "N.m", "angle": "rad"})


@pytest.mark.study
@pytest.mark.parametrize("period", [5.0, 60.0])
def test_the_dominant_effect_is_named_although_no_model_is_consistent_with_the_noise(monkeypatch, period):
    only_families(monkeypatch, ("coulomb_friction", "progressive_damping", "drift"))
    hidden = {"friction": FRICTION, "ripple": (0.03, 0.1)}
    held = driven("held", 60.0, 3, **hidden)
    found = mf.find_gap([driven("fitted", period, 1, **hidden)], validation=held, component="driven_joint").to_dict()
    assert found["verdict"] == "named" and [e["name"] for e in found["effects"]] == ["coulomb_friction"]
    friction = found["effects"][0]["parameters"]["friction_torque"]
    # The ripple is 12 % of the friction, and is not related to the direction of the motion.
    assert friction["value"] == pytest.approx(FRICTION, rel=0.05)
    assert found["noise_source"] == ("repeats" if period == 5.0 else "flexible_model")
    assert not (found["complete"] and period == 5.0)  # a flexible model regards a part of the ripple as noise
    said = any("the best single effect is not consistent with it" in sentence for sentence in found["limitations"])
    assert said == (period == 5.0)


@pytest.mark.study
def test_a_repeated_excitation_gives_no_name_where_nothing_is_missing(monkeypatch):
    only_families(monkeypatch, ("coulomb_friction", "progressive_damping", "drift"))
    found = mf.find_gap([driven("fitted", 5.0, 1)], validation=driven("held", 60.0, 3), component="driven_joint")
    assert found.verdict == "none"


@pytest.mark.study
def test_each_run_has_the_noise_of_its_own_repetitions(monkeypatch):
    only_families(monkeypatch, ("coulomb_friction", "drift"))
    hidden = {"friction": FRICTION, "ripple": (0.03, 0.1)}
    runs = [driven(f"run_{k}", 5.0, k, noise, **hidden) for k, noise in enumerate((NOISE, 20 * NOISE))]
    found = mf.find_gap(runs, validation=driven("held", 60.0, 3, **hidden), component="driven_joint").selection
    assert found.comparison is not None and {run.noise_source for run in found.best.runs} == {"repeats"}
    deviations = [np.sqrt(run.densities[0](np.array([10.0, 30.0])).mean()) for run in found.best.runs]
    assert deviations[1] / deviations[0] > 3  # 20, but that the accuracy of a simulation limits the first one
