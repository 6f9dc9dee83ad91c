"""The gap workflow on coast-downs whose speed alone is recorded, from their exact solutions.

    v' = -(f + k v^2):   v = sqrt(f / k) tan(atan(v0 sqrt(k / f)) - sqrt(f k) t)
"""

from dataclasses import replace

import numpy as np
import pytest

import motofmi as mf
from fmus import Component, parameter, state
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.base_fit import fitted_base
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.preprocessing.one_way import one_way_rates
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.recordings.recording import Recording

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
@pytest.mark.parametrize("hidden", EXACT)
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
    (sentence,) = [each for each in result.limitations if each.startswith("run_1: speed has one sign")]
    assert "laws of its deflection, hysteresis and asymmetry of damping are no candidates" in sentence


class Wheel(Component):
    """A wheel whose angle is recorded."""

    decay = parameter("1/s", "Damping per unit of inertia", min=0, start=0.01)
    angle = state("rad", "Angle", exposed=True)
    rate = state("rad/s", "Rate")

    def equations(self, v, m):
        return {"der(angle)": v.rate, "der(rate)": -v.decay * v.rate}


@pytest.mark.slow
@pytest.mark.study
def test_friction_is_no_hysteresis_where_a_motion_is_never_reversed():
    def slowing(seed: int, v0: float) -> Recording:
        time = np.arange(0, 30, 0.02)
        angle = v0 * time - FRICTION * time**2 / 2 + 1e-3 * np.random.default_rng(seed).standard_normal(len(time))
        return Recording(f"run_{seed}", time, {"angle": angle}, {"angle": "rad"})

    result = mf.find_gap([slowing(1, 20.0), slowing(3, 12.0)], validation=[slowing(2, 16.0)], component=Wheel())
    (effect,) = result.effects
    torque = effect["parameters"]["friction_torque"]
    assert (result.verdict, effect["name"], result.tied) == ("named", "coulomb_friction", [])
    assert torque["value"] == pytest.approx(FRICTION, abs=4 * torque["standard_error"] + 1e-3 * FRICTION)


def candidates_of(component: Component, recording: Recording) -> set[str]:
    """The families of the candidate effects of a component."""
    experiment = input_output_experiment(component, list(recording.columns))
    _, candidates, _ = fitted_base(experiment, [prepare_sampled_run(recording, experiment)], {}, (), Criteria())
    return {effect.family for effect in candidates}


def turning(time: np.ndarray, angle: np.ndarray) -> Recording:
    return Recording("turning", time, {"angle": angle}, {"angle": "rad"})


def test_a_hysteresis_is_a_candidate_only_where_a_motion_is_reversed():
    time = np.arange(0, 30, 0.02)
    noise = 1e-3 * np.random.default_rng(3).standard_normal(len(time))
    assert "hysteresis" not in candidates_of(Wheel(), turning(time, 12.0 * time - FRICTION * time**2 / 2 + noise))
    assert "hysteresis" in candidates_of(Wheel(), turning(time, np.sin(time) + noise))


@pytest.mark.parametrize("turns, expected", [(0.9, True), (1.1, False)])
def test_an_angle_beyond_a_revolution_has_no_sensor_nonlinearity(turns, expected):
    time = np.arange(0, 10, 0.02)
    candidates = candidates_of(Wheel(), turning(time, 2 * np.pi * turns * np.sin(time)))
    assert ("sensor_nonlinearity" in candidates) == expected


def test_a_deflection_that_is_not_recorded_has_laws_only_where_the_rate_changes_its_sign():
    """A spring beside the mass of a coast-down would explain any deceleration over the distance."""
    slowing, time = coast_down("both", 1, 20.0), np.arange(0, 60, 0.05)
    swinging = replace(slowing, time=time, columns={"speed": np.sin(time)})

    def of_velocity(run: Recording) -> set[str]:
        columns = {"velocity": run["speed"]}
        return candidates_of(
            mf.mechanism("mass_spring_damper"), Recording("run", run.time, columns, {"velocity": "m/s"})
        )

    assert not {"hardening_stiffness", "asymmetry", "backlash", "viscoelastic_arm"} & of_velocity(slowing)
    assert {"coulomb_friction", "progressive_damping"} <= of_velocity(slowing)
    assert {"hardening_stiffness", "asymmetry", "coulomb_friction"} <= of_velocity(swinging)


def test_a_rate_has_one_sign_apart_from_noise_about_standstill():
    run = coast_down("both", 1, 20.0)
    elements = mf.mechanism("mass_spring_damper").elements.values()

    def one_way(velocity: np.ndarray) -> frozenset[str]:
        return one_way_rates(Recording("run", run.time, {"velocity": velocity}, {"velocity": "m/s"}), elements)

    speed, wave = run["speed"], np.sin(run.time)
    assert one_way(speed) == one_way(-speed) == {"velocity"}
    assert one_way(speed - 0.52) == {"velocity"}  # noise of 0.01 about zero at the end
    assert one_way(wave) == one_way(speed - 5.0) == frozenset()
