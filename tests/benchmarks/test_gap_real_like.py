"""The benchmark of real-like machines: its simulator against a second derivation, and how answers are counted."""

import numpy as np
import pytest

from benchmarks.gap_real_like import find, run, summary
from tests.simulators.real_like_cases import Machine, draw


@pytest.mark.slow
@pytest.mark.parametrize("setting", ["driven", "closed_loop", "imposed"])
def test_without_effects_the_motion_is_that_of_the_linear_mechanism(setting):
    machine = Machine(np.random.default_rng(3), setting, "none", "none", 0.0)
    drive = machine.drive(np.random.default_rng(4))
    q, _, torque = machine.motion(drive)
    linear_q, linear_torque = machine.linear_motion(drive)
    # lsim holds its input linear between steps of 1/160 to 1/360 of a period; the rate in its torque is a difference.
    assert np.max(np.abs(q - linear_q)) < 2e-3 * np.max(np.abs(q))
    assert np.std(torque - linear_torque) < 1e-2 * np.std(torque)
    assert np.max(np.abs(q)) == pytest.approx(machine.angle, rel=2e-3)


@pytest.mark.slow
def test_what_a_linear_base_takes_up_has_no_size():
    machine = Machine(np.random.default_rng(3), "driven", "none", "none", 0.0)
    made = machine.motion(machine.drive(np.random.default_rng(4)))
    spring = machine.beyond_linear(made, lambda q, s, z, t: (machine.p["k"] * q + 0.1, 0.0))
    cubic = machine.beyond_linear(made, lambda q, s, z, t: (machine.p["k"] * q**3 / machine.angle**2, 0.0))
    assert spring < 1e-9 * machine.p["k"] * machine.angle and cubic > 1e-3 * machine.p["k"] * machine.angle


@pytest.mark.slow
def test_a_case_is_the_same_each_time_and_its_sensors_are_nearly_white():
    one, other = draw(0, 5), draw(0, 5)
    assert one.hidden == "none" and one.family == ""
    for (time, columns), (time_again, again) in zip(
        (one.fitted, one.validation), (other.fitted, other.validation), strict=True
    ):
        assert np.array_equal(time, time_again) and np.all(np.diff(time) > 0)
        assert all(np.array_equal(columns[n], again[n]) for n in columns)


@pytest.mark.slow
def test_an_effect_that_explains_a_part_of_the_noise_only_is_not_named(tmp_path):
    """Nothing is hidden, and the base misses 0.008 % of the motion; a hung body reduces its chi-square from 0.7 to 0.4."""
    found = find(draw(8, 211), tmp_path)
    assert (found["verdict"], found["names"]) == ("none", [])
    assert found["gap"]["rms"]["after"] == found["gap"]["rms"]["before"]
    (sentence,) = [text for text in found["limitations"] if "within the tolerance" in text]
    assert sentence.startswith("extra_mode would reduce chi-square")


def test_the_first_name_counts_and_ties_are_apart():
    row = {
        "hidden": "friction",
        "family": "coulomb_friction",
        "setting": "driven",
        "names": [],
        "tied": [],
        "cpu_seconds": 1.0,
    }
    nothing = row | {"hidden": "none", "family": "", "verdict": "none"}
    rows = [row | {"verdict": "named", "names": ["coulomb_friction", "drift"]}, row | {"verdict": "named", "names": ["drift"]},
            row | {"verdict": "tied", "tied": ["hysteresis", "coulomb_friction"]}, row | {"verdict": "unknown"}, nothing]  # fmt: skip
    rates = summary(rows)["rates"]
    assert rates["dominant effect named first"]["rate"] == 0.25
    assert rates["dominant effect named first, or in the tie"]["rate"] == 0.5
    assert rates["wrong first name"]["rate"] == 0.25 and rates["no name"]["rate"] == 0.5
    assert rates["nothing hidden: a name"]["rate"] == 0 and rates["nothing hidden: none"]["rate"] == 1


@pytest.mark.study
def test_a_case_that_hides_nothing_is_found_and_not_run_again(tmp_path):
    first = run(lambda items, _: items, cases=1, seed=5, out=tmp_path)
    assert first["confusion"] == {"none -> none": 1}
    assert run(lambda items, _: items, cases=1, seed=5, out=tmp_path) == first
