"""Springs whose deflection is not recorded, and friction, in motions of one direction, from their exact solutions.

    J w' = -(T + c w):          w = (w_0 + T/c) exp(-c t / J) - T/c until w = 0, then at rest
    J x'' + c x' + k x = 0:     x' = A (exp(-a t) - exp(-b t)), with a + b = c / J and a b = k / J
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import motofmi as mf
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.preprocessing.springs_like_friction import without_springs_like_friction
from motofmi.recordings.recording import Recording
from tests import as_study

RATIO, DAMPING = 2.5, 0.1  # T / J [rad/s2], c / J [1/s]
FAST, SLOW = 3.58, 0.42  # b, a [1/s]
TIME = np.arange(0, 25, 0.02)


def recording(name: str, rate: np.ndarray, noise: float) -> Recording:
    measured = rate + noise * np.random.default_rng(list(name.encode())).standard_normal(len(rate))
    return Recording(name, TIME[: len(rate)], {"rate": measured}, {"rate": "rad/s"})


def coast_down(name: str, start: float) -> Recording:
    rate = (start + RATIO / DAMPING) * np.exp(-DAMPING * TIME) - RATIO / DAMPING
    return recording(name, np.maximum(rate, 0.0), 0.03)


def turned(name: str, start: float) -> Recording:
    """The angle of such a coast-down."""
    level, rest = RATIO / DAMPING, np.log1p(start * DAMPING / RATIO) / DAMPING
    time = np.minimum(TIME, rest)
    angle = (start + level) / DAMPING * (1 - np.exp(-DAMPING * time)) - level * time
    measured = angle + 0.002 * np.random.default_rng(list(name.encode())).standard_normal(len(TIME))
    return Recording(name, TIME, {"angle": measured}, {"angle": "rad"})


def door(name: str, start: float) -> Recording:
    rate = start * (np.exp(-SLOW * TIME) - np.exp(-FAST * TIME))
    return recording(name, rate[:750], 0.002)


@pytest.mark.slow
@pytest.mark.parametrize("at_rest", [as_study(False), True])
def test_the_spring_of_a_joint_does_not_take_the_place_of_friction_in_a_coast_down(at_rest):
    """The joint has a spring. With it nothing was named, or the verdict was unknown where the runs end at rest."""
    runs = [coast_down("fitted", 50.0), coast_down("validation", 80.0)]
    if not at_rest:
        runs = [Recording(r.name, r.time[m], {"rate": r["rate"][m]}, dict(r.units)) for r in runs for m in [r["rate"] > 1.0]]
    found = mf.find_gap(runs[:1], validation=runs[1:], component="driven_joint")
    (effect,) = found.effects
    torque = effect["parameters"]["friction_torque"]
    assert found.verdict == "named" and effect["name"] == "coulomb_friction"
    inertia = mf.mechanism("driven_joint").values["inertia"]
    # four standard errors; 1e-3 for the transition of friction through zero rate
    assert torque["value"] == pytest.approx(RATIO * inertia, abs=4 * torque["standard_error"] + 1e-3 * RATIO * inertia)
    assert any("angle is not recorded, and its rate has one sign: stiffness is taken as zero" in each for each in found.limitations)


@pytest.mark.slow
def test_a_joint_that_rotates_by_revolutions_has_no_spring():
    """With one, the base had less than 1 % of the angle left, and the verdict was none."""
    found = mf.find_gap([turned("fitted", 50.0)], validation=[turned("validation", 80.0)], component="driven_joint")
    (effect,) = found.effects
    torque, inertia = effect["parameters"]["friction_torque"], mf.mechanism("driven_joint").values["inertia"]
    assert found.verdict == "named" and effect["name"] == "coulomb_friction"
    assert torque["value"] == pytest.approx(RATIO * inertia, abs=4 * torque["standard_error"] + 1e-3 * RATIO * inertia)
    assert any("angle increases or decreases by more than a revolution: stiffness is taken as zero" in each for each in found.limitations)


@pytest.mark.slow
def test_a_spring_that_moves_a_joint_is_kept():
    runs = [door("fitted", 2.0), door("validation", 1.5)]
    found = mf.find_gap(runs[:1], validation=runs[1:], component="driven_joint")
    assert found.verdict == "none"
    assert not any("stiffness is taken as zero" in each for each in found.limitations)
    stiffness, inertia = found.to_dict()["base"]["stiffness"], mf.mechanism("driven_joint").values["inertia"]
    assert stiffness["value"] == pytest.approx(SLOW * FAST * inertia, abs=4 * stiffness["standard_error"])


@pytest.mark.slow
def test_a_stiffness_that_is_asked_for_is_fitted():
    runs = [coast_down("fitted", 50.0), coast_down("validation", 80.0)]
    found = mf.find_gap(runs[:1], validation=runs[1:], component="driven_joint", free=["stiffness", "damping"])
    assert not any("stiffness is taken as zero" in each for each in found.limitations)


@pytest.mark.slow
def test_friction_of_a_drive_in_one_direction_is_an_offset_of_its_torque_in_the_first_lines():
    """Without a reversal the two are not distinguishable. Torques are constant over 0.5 s, each with its exact solution."""
    inertia, damping, friction, step = 0.05, 0.02, 0.3, 0.5  # kg.m2, N.m.s/rad, N.m, s
    runs = []
    for name, seed in (("fitted", 1), ("validation", 2)):
        random = np.random.default_rng(seed)
        torques, rate, rates = random.uniform(0.6, 2.0, 60), 0.0, []
        for torque in torques:
            end = (torque - friction) / damping
            rates.append(end + (rate - end) * np.exp(-damping / inertia * np.arange(50) * step / 50))
            rate = end + (rate - end) * np.exp(-damping / inertia * step)
        columns = {"torque": np.repeat(torques, 50), "rate": np.concatenate(rates) + 0.02 * random.standard_normal(3000)}
        runs.append(Recording(name, 0.01 * np.arange(3000), columns, {"torque": "N.m", "rate": "rad/s"}))
    found = mf.find_gap(runs[:1], validation=runs[1:], component="driven_joint")
    assert found.verdict == "none"
    said = found.reason.replace("values plus ", "").split()
    assert "dry friction (the rate has one sign)" in found.reason
    # two digits are printed
    assert float(next(word for word in said if word.startswith("-"))) == pytest.approx(-friction, abs=0.005)


def driven(sign: float, seed: int, gravity: float, friction: float = 0.3, load: float = 0.15) -> Recording:
    """A joint that a torque with random steps of 0.5 s turns one way through revolutions, beside a constant load."""
    inertia, damping, random = 0.05, 0.02, np.random.default_rng(seed)
    torques = sign * random.uniform(1.2, 2.0, 40)

    def rates(t, x):
        torque = torques[min(int(2 * t + 1e-9), len(torques) - 1)] + load - friction * np.tanh(x[1] / 0.01)
        return [x[1], (torque - damping * x[1] - gravity * np.sin(x[0])) / inertia]

    time = 0.01 * np.arange(2000)
    # from a rate at which no friction changes its sign
    angle = solve_ivp(rates, (0, time[-1]), [0.0, 20.0 * sign], t_eval=time, max_step=0.01, rtol=1e-8).y[0]
    columns = {"torque": np.repeat(torques, 50), "angle": angle + 0.01 * random.standard_normal(len(time))}
    return Recording(f"run_{seed}", time, columns, {"torque": "N.m", "angle": "rad"})


def test_a_driven_joint_that_rotates_has_friction_and_no_spring():
    """A spring with a distant centre took the place of friction, since the rate rises and falls with the torque."""
    only = [driven(sign, seed, 0.0) for seed, sign in enumerate((1, -1, 1, -1))]
    found = mf.find_gap(only[:2], validation=only[2:], component="driven_joint")
    (effect,) = found.effects
    torque = effect["parameters"]["friction_torque"]
    assert found.verdict == "named" and effect["name"] == "coulomb_friction"
    assert torque["value"] == pytest.approx(0.3, abs=4 * torque["standard_error"])
    assert any("torque of every run is fitted as the recorded values plus 0.15 N.m" in each for each in found.limitations)
    assert any("no spring. Not candidates there: hardening_stiffness" in each for each in found.limitations)


@pytest.mark.parametrize(("gravity", "kept"), [(0.0, False), (0.6, True)])
def test_a_driven_pendulum_that_rotates_keeps_its_gravity(gravity, kept):
    recording = driven(1, 5, gravity)
    experiment = input_output_experiment(mf.mechanism("pendulum"), list(recording.columns))
    found, _ = without_springs_like_friction(experiment, [prepare_sampled_run(recording, experiment)])
    assert np.ptp(recording["angle"]) > 100 * np.pi
    assert ("gravity_stiffness" in [f.name for f in found.free]) == kept


def test_a_pendulum_that_rotates_by_revolutions_keeps_its_gravity():
    """Its rate falls on the way up and rises on the way down; that of a wheel with the same friction only falls."""
    def rates(_, x, gravity):
        return [x[1], -gravity * np.sin(x[0]) - 0.2 - 0.02 * x[1]]

    for gravity, kept in ((16.0, True), (0.0, False)):
        angle = solve_ivp(rates, (0, 10), [0.0, 14.0], args=(gravity,), t_eval=0.01 * np.arange(1000), rtol=1e-9).y[0]
        recording = Recording("run", 0.01 * np.arange(1000), {"angle": angle}, {"angle": "rad"})
        experiment = input_output_experiment(mf.mechanism("pendulum"), ["angle"])
        found, sentences = without_springs_like_friction(experiment, [prepare_sampled_run(recording, experiment)])
        assert np.ptp(angle) > 4 * np.pi
        assert ("gravity_stiffness" in [f.name for f in found.free]) == kept
        assert bool(sentences) != kept
