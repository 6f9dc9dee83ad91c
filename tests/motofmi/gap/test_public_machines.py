"""Machines of public benchmarks, simulated from their published equations, and a mass-spring-damper that says nothing of them."""


import numpy as np
import pytest
from scipy.signal import savgol_filter

from benchmarks.gap_machines import as_recording
from fmus.composition.imposed_motion import ImposedMotion
from fmus.effects.placement import laws_at
from fmus.mechanisms import MassSpringDamper, TwoMass
from fmus.support.errors import InputError
from motofmi.gap.estimation.fit_result import parameters_of
from motofmi.gap.estimation.initial_fit import initial_fit
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.selection.any_component import investigate
from motofmi.recordings.reading import read_recording
from motofmi.recordings.recording import Recording
from tests import SHARED_DATA
from tests.simulators.hidden_mechanisms import excitation, simulate_two
from tests.simulators.machines import BOUC_WEN, POSITIONING, SILVERBOX, positioning, silverbox

MEASURED = SHARED_DATA / "measured" / "mr_damper"


@pytest.mark.slow
@pytest.mark.study
@pytest.mark.skipif(
    not MEASURED.exists(), reason=f"the measured runs of a magnetorheological damper are not at {MEASURED}"
)
def test_a_real_magnetorheological_damper_rubs():
    """Its friction lags its rate; friction and damping together are the force that is read at the largest rate.

    Friction alone is not comparable with a reading: how the force divides into friction and damping depends on the
    law of friction. The straight line through the force over the rate (Bingham) has 1.02 and 1.09 kN in the two runs.
    """
    fitted, held = (read_recording(MEASURED / f"{name}.csv") for name in ("10mm1Hz1A", "25mm0p5Hz1A"))
    test = input_output_experiment(MassSpringDamper(), ["force", "displacement"], "displacement")
    verdict = investigate(test, [prepare_sampled_run(fitted, test)], validation=[held]).verdict
    assert (verdict.verdict, [c.family for c in verdict.effects]) == ("named", ["coulomb_friction"])
    values = {name: value for name, (value, *_) in parameters_of(verdict.best).items()}
    # A quadratic over 50 ms (1/20 of a cycle) leaves the rate of a 1 Hz motion within 1 %.
    rate = savgol_filter(fitted["displacement"], int(0.05 * fitted.rate) | 1, 2, deriv=1, delta=1 / fitted.rate)
    largest = np.quantile(np.abs(rate), 0.99)
    read = np.mean(np.abs(fitted["force"][np.abs(rate) > 0.97 * largest]))
    friction = values["coulomb_friction.friction_torque"]
    # 3 %: by that the strokes of the other run differ at the largest rate
    assert friction + values["spring_damping"] * largest == pytest.approx(read, rel=0.03)
    assert friction == pytest.approx(1050, rel=0.1)  # the mean of the two straight lines; they differ by 7 %
    before, after = verdict.validation_gap
    assert after.rms < 0.25 * before.rms  # half of it where friction does not lag


def test_shaped_hysteresis_is_the_published_law():
    """z' = alpha y' - beta (gamma |y'| z + delta y' |z|) with width 1 / (beta gamma), force alpha width, shape -delta /
    gamma."""
    p, width = BOUC_WEN, 1 / (BOUC_WEN["beta"] * BOUC_WEN["gamma"])
    law = next(e for e in laws_at(MassSpringDamper()) if e.form == "shaped")
    own = {
        "hysteresis.force": p["alpha"] * width,
        "hysteresis.width": width,
        "hysteresis.shape": -p["delta"] / p["gamma"],
    }
    joined = MassSpringDamper().with_effects(law()).with_values(**own)
    for v, z in ((0.3, 20.0), (-0.3, 20.0), (0.2, -35.0)):
        state = {"displacement": 0.0, "velocity": v, "hysteresis.sticking": z / own["hysteresis.force"]}
        rates, _ = joined.derivatives(np.array([state[n] for n in joined.states]), np.zeros(1))
        published = p["alpha"] * v - p["beta"] * (p["gamma"] * abs(v) * z + p["delta"] * v * abs(z))
        found = dict(zip(joined.states, rates, strict=True))
        assert own["hysteresis.force"] * found["hysteresis.sticking"] == pytest.approx(published, rel=1e-12)
        assert found["velocity"] == pytest.approx(-2.0 * v - z)  # m = 1, c = 2


@pytest.mark.study
def test_a_base_is_found_from_values_that_say_nothing_of_the_machine():
    """The mass of 1 kg, 400 N/m and 2 N.s/m against an axis of 95 kg without a spring, and a circuit that moves
    micrograms."""
    axis = as_recording("axis", positioning(1, duration=12))
    test = input_output_experiment(MassSpringDamper(), list(axis.columns))
    found = dict(
        zip(
            free_names(test),
            np.exp(initial_fit(FreeInitialStateModel(test), [prepare_sampled_run(axis, test)]).shared),
            strict=True,
        )
    )
    assert found["mass"] == pytest.approx(
        POSITIONING["mass"], rel=0.2
    )  # dry friction is not in the base: its damper takes it up
    assert found["spring_stiffness"] < 50  # N/m: 5 N over the 0.2 m that it goes, a third of its friction
    circuit = as_recording("circuit", silverbox(5, 3000))
    test = input_output_experiment(MassSpringDamper(), list(circuit.columns))
    found = dict(
        zip(
            free_names(test),
            np.exp(initial_fit(FreeInitialStateModel(test), [prepare_sampled_run(circuit, test)]).shared),
            strict=True,
        )
    )
    # The hardening spring is stiffer in the mean than where it is at rest
    assert found["mass"] == pytest.approx(SILVERBOX["mass"], rel=0.05)
    assert SILVERBOX["stiffness"] < found["spring_stiffness"] < 1.25 * SILVERBOX["stiffness"]


@pytest.mark.slow
@pytest.mark.parametrize("seen", [("angle", "load_angle"), ("load_angle",)])
def test_two_masses_much_slower_than_their_own_values(seen):
    """At 0.1 Hz, where the values that they have ring at 8.5 Hz; nothing follows from the load's motion alone."""
    rng, frequency = np.random.default_rng(1), 0.1
    joint = {
        "J": 0.1,
        "J2": 0.2,
        "k": 0.1 * (2 * np.pi * frequency) ** 2,
        "c": 0.006,
        "c1": 0.0013,
        "c2": 0.0019,
        "sliding": 1e-3,
    }
    time = np.arange(0, 15 / frequency, 1 / (60 * frequency))
    drive = excitation("multisine", rng, time[-1], 2.5 * frequency, 1.0).derivative()
    motion, torque = simulate_two(joint, {}, drive, time)
    twist = np.ptp(motion[:, 0] - motion[:, 1])
    shown = dict(
        zip(("angle", "load_angle"), motion.T + 0.003 * twist * rng.standard_normal((2, len(time))), strict=True)
    )
    recording = Recording(
        "slow", time, {"torque": torque, **{n: shown[n] for n in seen}}, {"torque": "N.m", **dict.fromkeys(seen, "rad")}
    )
    test = input_output_experiment(TwoMass(), list(recording.columns))
    found = initial_fit(FreeInitialStateModel(test), [prepare_sampled_run(recording, test)])
    assert (
        found.reduced < 1.3
    )  # of 1,800 numbers or fewer, with a noise that a flexible model leaves; 5,000 and more where it is not found
    values = dict(zip(free_names(test), np.exp(found.shared), strict=True))
    # Drive and load may be exchanged where only the load is measured: the response from torque to load angle is the
    # same for a family of values, with one frequency of the free oscillation.
    squared = values["stiffness"] * (1 / values["drive_inertia"] + 1 / values["load_inertia"])
    assert squared == pytest.approx(joint["k"] * (1 / joint["J"] + 1 / joint["J2"]), rel=0.05)
    if "angle" in seen:
        assert values["stiffness"] / values["drive_inertia"] == pytest.approx(joint["k"] / joint["J"], rel=0.1)


def test_a_motion_that_no_input_accelerates_cannot_be_imposed():
    with pytest.raises(InputError, match="torque does not accelerate load_angle"):
        ImposedMotion(TwoMass(), "load_angle", "torque")


def free_names(test):
    return [free.name for free in test.free]


@pytest.mark.slow
@pytest.mark.study
def test_the_hardening_spring_of_the_silverbox():
    recordings = [as_recording(f"circuit_{seed}", silverbox(seed, 3000)) for seed in (5, 6)]
    test = input_output_experiment(MassSpringDamper(), list(recordings[0].columns))
    verdict = investigate(test, [prepare_sampled_run(recordings[0], test)], validation=recordings[1:]).verdict
    assert (verdict.verdict, [c.family for c in verdict.effects]) == ("named", ["hardening_stiffness"])
    found = parameters_of(verdict.best)
    for name, published in (("mass", "mass"), ("spring_stiffness", "stiffness"), ("spring_damping", "damping")):
        # The part of a held input above half of the sampling rate is not in the recording.
        assert found[name][0] == pytest.approx(SILVERBOX[published], rel=0.02)
    assert found["hardening_stiffness.cubic_stiffness"][0] == pytest.approx(SILVERBOX["cubic"], rel=0.05)
