"""Laws are no candidates where a motion does not distinguish them from others, and a limitation says so."""

import numpy as np
import pytest

import motofmi as mf
from fmus import Component, input, parameter, state
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.base_fit import FittedBase, fitted_base
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.recordings.recording import Recording

FRICTION = 0.2  # N.m/kg.m2
TIME = np.arange(0, 30, 0.02)


class Wheel(Component):
    """A wheel whose angle is recorded."""

    decay = parameter("1/s", "Damping per unit of inertia", min=0, start=0.01)
    angle = state("rad", "Angle", exposed=True)
    rate = state("rad/s", "Rate")

    def equations(self, v, m):
        return {"der(angle)": v.rate, "der(rate)": -v.decay * v.rate}


def slowing(seed: int, v0: float) -> Recording:
    """A wheel that dry friction slows down, with noise of 1 mrad."""
    noise = 1e-3 * np.random.default_rng(seed).standard_normal(len(TIME))
    angle = v0 * TIME - FRICTION * TIME**2 / 2 + noise
    return Recording(f"run_{seed}", TIME, {"angle": angle}, {"angle": "rad"})


def turning(angle: np.ndarray) -> Recording:
    return Recording("turning", TIME[: len(angle)], {"angle": angle}, {"angle": "rad"})


def coasting(velocity: np.ndarray) -> Recording:
    return Recording("coasting", TIME, {"velocity": velocity}, {"velocity": "m/s"})


def base_of(component: Component, recording: Recording) -> FittedBase:
    experiment = input_output_experiment(component, list(recording.columns))
    return fitted_base(experiment, [prepare_sampled_run(recording, experiment)], {}, (), Criteria())


def families(base: FittedBase) -> set[str]:
    return {effect.family for effect in base.candidates}


def test_laws_of_both_directions_are_candidates_only_where_a_motion_is_reversed():
    one_way = base_of(Wheel(), slowing(3, 12.0))
    assert not {"hysteresis", "damping_asymmetry"} & families(one_way)
    (sentence,) = [each for each in one_way.left_out if each.startswith("angle: the motion is never reversed.")]
    assert "hysteresis" in sentence
    noise = 1e-3 * np.random.default_rng(3).standard_normal(len(TIME))
    there_and_back = base_of(Wheel(), turning(np.sin(TIME) + noise))
    assert "damping_asymmetry" in families(there_and_back)
    assert not any("the motion is never reversed" in each for each in there_and_back.left_out)


class Rail(Component):
    """A cart on a rail without a spring."""

    mass = parameter("kg", "mass", min=0.1, start=2.0)
    damping = parameter("N.s/m", "viscous friction", min=0, start=1.0)
    force = input("N", "force")
    position = state("m", "position", exposed=True)
    velocity = state("m/s", "velocity")

    def equations(self, v, m):
        return {"der(position)": v.velocity, "der(velocity)": (v.force - v.damping * v.velocity) / v.mass}


@pytest.mark.parametrize(("places", "left_out"), [((0.3, 0.5), True), ((0.3, 0.31), False), ((0.3,), False)])
def test_a_spring_without_one_centre_in_all_runs_is_no_candidate(places, left_out):
    """The cart moves by 20 mm to either side of its place in each run."""
    runs = []
    for i, place in enumerate(places):
        position = place + 0.02 * np.sin(TIME) + 1e-5 * np.random.default_rng(i).standard_normal(len(TIME))
        columns = {"force": -0.04 * np.sin(TIME), "position": position}
        runs.append(Recording(f"run_{i}", TIME, columns, {"force": "N", "position": "m"}))
    experiment = input_output_experiment(Rail(), ["force", "position"])
    found = fitted_base(experiment, [prepare_sampled_run(run, experiment) for run in runs], {}, (), Criteria())
    assert ("hardening_stiffness" not in families(found)) == left_out
    assert {"coulomb_friction", "hysteresis"} <= families(found)  # they have no centre
    assert any("have another centre in each run" in each for each in found.left_out) == left_out


@pytest.mark.parametrize("pushed", [False, True])
def test_a_hysteresis_is_a_candidate_only_where_an_input_drives_the_motion(pushed):
    """In a free decay its describing function is that of a spring and a damper that depend on the amplitude."""
    noise = 1e-5 * np.random.default_rng(5).standard_normal(len(TIME))
    columns = {"position": 0.02 * np.exp(-0.1 * TIME) * np.cos(3 * TIME) + noise} | ({"force": np.cos(3 * TIME)} if pushed else {})
    base = base_of(Rail(), Recording("run", TIME, columns, {"force": "N", "position": "m"}))
    assert ("hysteresis" in families(base)) == pushed
    assert any("hysteresis" in each and "No run has an input that varies" in each for each in base.left_out) is not pushed


@pytest.mark.parametrize("turns, expected", [(0.9, True), (1.1, False)])
def test_an_angle_beyond_a_revolution_has_no_sensor_nonlinearity(turns, expected):
    base = base_of(Wheel(), turning(2 * np.pi * turns * np.sin(TIME[:500])))
    assert ("sensor_nonlinearity" in families(base)) == expected
    assert any("the angle exceeds a revolution" in sentence for sentence in base.left_out) != expected


def test_a_deflection_that_is_not_recorded_has_laws_only_where_the_rate_changes_its_sign():
    """A spring beside the mass of a coast-down would explain any deceleration over the distance."""
    noise = 0.01 * np.random.default_rng(1).standard_normal(len(TIME))
    mass = mf.mechanism("mass_spring_damper")
    one_way, swinging = (base_of(mass, coasting(v + noise)) for v in (9.0 - FRICTION * TIME, np.sin(TIME)))
    of_deflection = {"hardening_stiffness", "asymmetry", "backlash", "viscoelastic_arm"}
    assert not of_deflection & families(one_way)
    assert {"coulomb_friction", "progressive_damping"} <= families(one_way)
    (sentence,) = [each for each in one_way.left_out if "displacement is not recorded" in each]
    assert all(law in sentence for law in of_deflection)
    assert "drift (" in sentence and "drift" not in families(one_way)
    assert {"hardening_stiffness", "asymmetry", "coulomb_friction"} <= families(swinging)
    assert not any("displacement is not recorded" in each for each in swinging.left_out)


@pytest.mark.slow
@pytest.mark.study
def test_friction_is_no_hysteresis_where_a_motion_is_never_reversed():
    result = mf.find_gap([slowing(1, 20.0), slowing(3, 12.0)], validation=[slowing(2, 16.0)], component=Wheel())
    (effect,) = result.effects
    torque = effect["parameters"]["friction_torque"]
    assert (result.verdict, effect["name"], result.tied) == ("named", "coulomb_friction", [])
    assert torque["value"] == pytest.approx(FRICTION, abs=4 * torque["standard_error"] + 1e-3 * FRICTION)
    assert any("the motion is never reversed" in sentence for sentence in result.limitations)


class Cart(Component):
    """A mass whose velocity is recorded, and a force that may be."""

    damping = parameter("1/s", "Damping per mass", min=0, start=0.05)
    push = input("N/kg", "Force per mass")
    velocity = state("m/s", "Velocity", start=5.0, exposed=True)

    def equations(self, v, m):
        return {"der(velocity)": v.push - v.damping * v.velocity}


UNDRIVEN = {"drift", "sensor_drift", "sensor_nonlinearity"}


@pytest.mark.parametrize(("shape", "pushed", "left_out"), [
    ("coast-down", False, UNDRIVEN), ("swing", False, {"drift"}), ("coast-down", True, set()),
])  # fmt: skip
def test_changes_over_time_are_candidates_only_where_the_amplitude_is_not_the_time(shape, pushed, left_out):
    """In a coast-down v' = -f(v) a sensor y = g(v) gives y' = -h(y): it is a drag as well."""
    noise = 0.03 * np.random.default_rng(4).standard_normal(len(TIME))
    motion = np.exp(-0.1 * TIME) * (np.cos(3 * TIME) if shape == "swing" else 5.0) + noise
    columns = {"velocity": motion} | ({"push": np.sin(TIME)} if pushed else {})
    base = base_of(Cart(), Recording("run", TIME, columns, {"velocity": "m/s", "push": "N/kg"}))
    assert UNDRIVEN - families(base) == left_out
    # The noise of the velocity is no return of the mass.
    assert ("damping_asymmetry" in families(base)) == (shape == "swing")
    said = [each for each in base.left_out if each.startswith("No run has an input that varies")]
    assert bool(said) == bool(left_out) and all(name in said[0] for name in left_out)


class Vane(Wheel):
    """A wheel with the weight of a vane, of which the equations have the linear part alone."""

    weight = parameter("1/s2", "Torque of gravity per unit of inertia", min=0, start=1.0)

    def equations(self, v, m):
        return {"der(angle)": v.rate, "der(rate)": -v.decay * v.rate - v.weight * v.angle}


@pytest.mark.parametrize(("component", "candidate"), [(Wheel(), False), (Vane(), True)])
def test_the_sine_of_gravity_is_a_candidate_where_the_base_has_its_linear_part(component, candidate):
    """Both declare no stiffness; a heading has no restoring force."""
    noise = 1e-3 * np.random.default_rng(3).standard_normal(len(TIME))
    found = base_of(component, turning(np.sin(TIME) + noise))
    assert ("geometric_nonlinearity" in families(found)) == candidate
    said = [s for s in found.left_out if s.startswith("angle: nothing in the base depends on it.")]
    assert len(said) == (not candidate) and all("geometric_nonlinearity" in s for s in said)
