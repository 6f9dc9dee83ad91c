"""The work of recorded forces, and the note where its sign is that of a reaction."""

from dataclasses import replace

import numpy as np
import pytest

import motofmi as mf
from fmus.declaration.component import Component
from fmus.declaration.variables import input, state
from fmus.mechanisms import DrivenJoint, MassSpringDamper, TwoMass
from motofmi.gap.preprocessing.work_of_inputs import PARTS, driven_motion, note_on_signs, work
from motofmi.recordings.recording import Recording
from tests.simulators.hidden_joint import joint_run
from tests.simulators.three_sines import three_sines

RATE, DAMPING, AMPLITUDE, CYCLES = 1000.0, 30.0, 0.02, 16
OMEGA = 2 * np.pi
TIME = np.arange(CYCLES * RATE + 1) / RATE


class OnBoth(Component):
    """One force on two masses: its work is that on both, which one of the motions does not give."""

    force = input("N", "Force on both masses")
    first = state("m/s", "Velocity of the first mass", exposed=True)
    second = state("m/s", "Velocity of the second mass", exposed=True)

    def equations(self, v, m):
        return {"der(first)": v.force, "der(second)": v.force / 2}


def recording(force, displacement):
    return Recording("run", TIME, {"force": force, "displacement": displacement}, {"force": "N", "displacement": "m"})


def shaken_damper(spring=0.0, sign=1.0):
    """A damper with a spring under a sinusoidal displacement."""
    x, v = AMPLITUDE * np.sin(OMEGA * TIME), AMPLITUDE * OMEGA * np.cos(OMEGA * TIME)
    return recording(sign * (DAMPING * v + spring * x), x)


@pytest.mark.parametrize("spring", [0.0, 500.0])
def test_the_work_on_a_damper_is_that_of_the_ellipse(spring):
    """pi c omega A^2 per cycle; a spring exchanges energy only."""
    per_cycle = np.pi * DAMPING * OMEGA * AMPLITUDE**2
    found = work(shaken_damper(spring), "force", "displacement", "velocity")
    # 1e-4: trapezoids of 1000 samples per cycle
    np.testing.assert_allclose(found, per_cycle * CYCLES / PARTS, rtol=1e-4)


def test_the_force_of_a_reaction_is_noted_with_the_option():
    right, wrong = shaken_damper(), shaken_damper(sign=-1.0)
    assert note_on_signs(MassSpringDamper(), right) == []
    (note,) = note_on_signs(MassSpringDamper(), wrong)
    assert '--map "force=-force"' in note and "reaction" in note


def test_a_standstill_at_the_end_does_not_hide_a_reaction():
    wrong = shaken_damper(sign=-1.0)
    rest = np.full(500, wrong["displacement"][-1]), np.zeros(500)
    columns = {n: np.concatenate([wrong[n], y]) for n, y in zip(("displacement", "force"), rest, strict=True)}
    longer = replace(wrong, time=np.arange(len(columns["force"])) * TIME[1], columns=columns)
    assert len(note_on_signs(MassSpringDamper(), longer)) == 1


def test_nothing_is_named_with_the_force_of_a_reaction_and_the_sign_is_the_reason():
    runs = []
    for seed in (1, 2):
        time = np.arange(1500) / 100
        x, v, a = three_sines(np.random.default_rng(seed), time)
        force = -(a + 20 * v + 40 * x + 2 * np.sign(v))
        columns, units = {"force": force, "displacement": x}, {"force": "N", "displacement": "m"}
        runs.append(Recording(f"run_{seed}", time, columns, units))
    found = mf.find_gap(runs[0], validation=runs[1], component="mass_spring_damper", impose="displacement")
    assert found.verdict == "unknown" and "reverse its sign" in found.reason
    assert found.to_dict()["closest"] is None and found.alternatives == []


def test_a_recorded_rate_shows_the_sign_as_a_deflection_does():
    right = shaken_damper()
    columns = {"force": -right["force"], "velocity": np.gradient(right["displacement"], TIME)}
    wrong = replace(right, columns=columns, units={"force": "N", "velocity": "m/s"})
    assert len(note_on_signs(MassSpringDamper(), wrong)) == 1


def test_a_joint_that_exchanges_much_energy_has_no_note():
    assert note_on_signs(DrivenJoint(), joint_run({}, "random", seed=5, duration=12.0)) == []


def test_a_moving_mass_that_is_braked_is_no_reaction():
    """The brake takes the kinetic energy: negative work, on a passive mass that moves one way."""
    braked = recording(np.full_like(TIME, -1.0), 20.0 * TIME - TIME**2 / 2)
    assert note_on_signs(MassSpringDamper(), braked) == []


def test_a_weight_that_is_lowered_is_no_reaction():
    """A spring that is released slowly, with an oscillation over a tenth of its travel."""
    lowered = 1.0 - TIME / TIME[-1] + 0.05 * np.sin(40 * np.pi * TIME / TIME[-1])
    assert note_on_signs(MassSpringDamper(), recording(lowered, lowered)) == []


def test_a_recording_without_an_input_has_no_note():
    assert note_on_signs(MassSpringDamper(), recording(np.zeros_like(TIME), np.sin(TIME))) == []


def test_an_input_belongs_to_the_motion_that_it_accelerates():
    assert driven_motion(DrivenJoint()) == {"torque": ("angle", "rate")}
    assert driven_motion(TwoMass()) == {"torque": ("angle", "rate")}  # and not the load behind the shaft
    assert driven_motion(OnBoth()) == {}
