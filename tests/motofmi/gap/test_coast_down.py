"""The gap workflow on coast-downs whose speed alone is recorded, from their exact solutions.

    v' = -(f + k v^2):   v = sqrt(f / k) tan(atan(v0 sqrt(k / f)) - sqrt(f k) t)
"""

from dataclasses import replace

import numpy as np
import pytest

import motofmi as mf
from fmus import Component, parameter, state
from motofmi.gap.preprocessing.one_way import one_way_rates
from motofmi.recordings.joined import with_short_joined
from motofmi.recordings.recording import Recording
from tests import as_study

FRICTION, DRAG, DAMPING = 0.2, 0.003, 0.03  # per unit of mass: N/kg, N.s2/m2.kg, 1/s
EXACT = {
    "nothing": lambda t, v0: v0 * np.exp(-DAMPING * t),
    "friction": lambda t, v0: v0 - FRICTION * t,
    "drag": lambda t, v0: 1 / (1 / v0 + DRAG * t),
    "both": lambda t, v0: np.sqrt(FRICTION / DRAG)
    * np.tan(np.arctan(v0 * np.sqrt(DRAG / FRICTION)) - np.sqrt(FRICTION * DRAG) * t),
}
_FRICTION = {"coulomb_friction": ("friction_torque", FRICTION)}
_DRAG = {"progressive_damping": ("coefficient", DRAG)}
EXPECTED = {"nothing": {}, "friction": _FRICTION, "drag": _DRAG, "both": _FRICTION | _DRAG}


class Drum(Component):
    """A drum that coasts down."""

    decay = parameter("1/s", "Damping per unit of mass", min=0, start=0.003)
    speed = state("m/s", "Speed", exposed=True, start=26.0)

    def equations(self, v, m):
        return {"der(speed)": -v.decay * v.speed}


def coast_down(hidden: str, seed: int, v0: float) -> Recording:
    """60 s, or down to 0.5 m/s, with noise of 0.01 m/s."""
    time = np.arange(0, 60, 0.05)
    speed = EXACT[hidden](time, v0)
    until = int(np.argmax(speed < 0.5)) or len(time)
    noise = 0.01 * np.random.default_rng(seed).standard_normal(until)
    return Recording(f"run_{seed}", time[:until], {"speed": speed[:until] + noise}, {"speed": "m/s"})


@pytest.mark.slow
@pytest.mark.parametrize("hidden", ["nothing", as_study("friction"), as_study("drag"), "both"])
def test_the_friction_and_the_drag_of_a_coast_down_are_named(hidden):
    """Without a limit on the offset of the speed's sensor, friction beside linear damping would be an offset."""
    fitted = [coast_down(hidden, 1, 20.0), coast_down(hidden, 3, 12.0)]
    result = mf.find_gap(fitted, validation=[coast_down(hidden, 2, 16.0)], component=Drum())
    found = {e["name"]: e["parameters"] for e in result.effects}
    expected = EXPECTED[hidden]
    assert result.verdict == ("named" if expected else "none")
    assert set(found) == set(expected)
    for name, (parameter_name, value) in expected.items():
        known = found[name][parameter_name]
        # four standard errors; 1e-3 for the transition of friction through zero rate, which is not reached
        assert known["value"] == pytest.approx(value, abs=4 * known["standard_error"] + 1e-3 * value)
    assert any(each.startswith("run_1, run_3: speed has one sign") for each in result.limitations)
    assert any("speed: the motion is never reversed. Not candidates there: damping_asymmetry;" in each for each in result.limitations)


def test_a_rate_has_one_sign_apart_from_noise_about_standstill():
    run = coast_down("both", 1, 20.0)
    elements = mf.mechanism("mass_spring_damper").elements.values()

    def one_way(velocity: np.ndarray) -> frozenset[str]:
        return one_way_rates(Recording("run", run.time, {"velocity": velocity}, {"velocity": "m/s"}), elements)

    speed, wave = run["speed"], np.sin(run.time)
    assert one_way(speed) == one_way(-speed) == {"velocity"}
    assert one_way(speed - 0.52) == {"velocity"}  # noise of 0.01 about zero at the end
    assert one_way(wave) == one_way(speed - 5.0) == frozenset()


def test_the_speed_of_joined_coast_downs_does_not_oscillate():
    """From the end of one to the begin of the next it returns by its whole range."""
    runs = [coast_down("both", seed, 20.0) for seed in (1, 2)]
    short = [Recording(r.name, r.time[:150], {"velocity": r["speed"][:150]}, {"velocity": "m/s"}) for r in runs]
    (joined,), _ = with_short_joined(short, 200)
    elements = mf.mechanism("mass_spring_damper").elements.values()
    assert one_way_rates(joined, elements, free=True) == {"velocity"}
    wave = replace(joined, columns={"velocity": 5 + np.sin(joined.time)})
    assert one_way_rates(wave, elements, free=True) == frozenset()
