"""A joint with dry friction whose angle is imposed, and a torque of something else in the recorded one.

    u = J a + c w + k q + T_c sign(w) + other

The other torque is low-passed noise. Where it is more than half of the variance, nothing is named.
"""

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

import motofmi as mf
from motofmi.recordings.recording import Recording
from tests.few_laws import only_families
from tests.simulators.three_sines import three_sines

RATE, SECONDS = 100, 60
FRICTION = 4.0  # N.m
UNITS = {"torque": "N.m", "angle": "rad"}


def imposed(seed: int, other: float) -> Recording:
    """A run whose other torque has `other` [1] times the rms of the joint's."""
    generator, time = np.random.default_rng(seed), np.arange(RATE * SECONDS) / RATE
    angle, rate, acceleration = three_sines(generator, time)
    own = acceleration + 2 * rate + 10 * angle + FRICTION * np.sign(rate)
    slow = sosfiltfilt(butter(2, 1.0, fs=RATE, output="sos"), generator.standard_normal(len(time)))
    torque = own + other * np.std(own) * slow / np.std(slow) + 0.01 * generator.standard_normal(len(time))
    return Recording(f"run {seed}", time, {"torque": torque, "angle": angle}, UNITS)


@pytest.mark.parametrize(("other", "named"), [(0.3, True), (1.5, False)])
def test_nothing_is_named_where_most_of_the_torque_is_of_something_else(monkeypatch, other, named):
    only_families(monkeypatch, ("coulomb_friction", "hardening_stiffness"))
    found = mf.find_gap([imposed(1, other)], validation=[imposed(2, other)], component="driven_joint", impose="angle")
    said = [s for s in found.limitations if "% of the variance of the recorded torque" in s]
    if named:
        assert found.verdict == "named" and [e["name"] for e in found.effects] == ["coulomb_friction"]
        assert not said
    else:
        assert found.verdict == "unknown" and len(said) == 1
        share = float(said[0].split("No effect is named: ")[1].split(" %")[0])
        # of the variances of the joint's torque and the other one together; a fifth for what friction and base take of it
        assert share / 100 == pytest.approx(other**2 / (1 + other**2), rel=0.2)
        assert "more than 50 %" in said[0]
