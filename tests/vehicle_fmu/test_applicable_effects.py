"""A user's effects on a vehicle: left out where it lacks what they need, refused where they name what nothing has."""

import re

import pytest

import motofmi as mf
from fmus import InputError
from fmus.effects import load_folder
from fmus.effects.library import applicable_effects, obstacle
from vehicle_fmu import motorcycles

EFFECT = '''from fmus import Effect, adds_to, parameter


class Drag(Effect):
    """Resistance of the steering head."""

    family, form, element = "drag", "square", "{element}"
    resistance = parameter("N.m.s2/rad2", "Resistance", min=0, max=1e3)

    @adds_to("{target}")
    def square(self, v, m):
        return {term}
'''
TERM = "-v.resistance * v.rate * m.absolute(v.rate)"
HEAD = {"element": "steering_head", "target": "force", "term": TERM}
TABLE = "speed,mode,real,imag,real_se,imag_se\n" + "".join(f"{v},weave,-1,20,0.1,0.1\n" for v in range(10, 15))


@pytest.fixture
def own(tmp_path):
    """The effect in a folder, with a part of it replaced."""

    def written(**changed):
        (tmp_path / "effects").mkdir()
        (tmp_path / "effects" / "drag.py").write_text(EFFECT.format(**HEAD | changed))
        return tmp_path / "effects"

    return written


def test_an_effect_that_the_vehicle_can_have_applies(own):
    effects = load_folder(own())
    assert applicable_effects(motorcycles.load("sharp_1971"), effects) == effects


@pytest.mark.parametrize("term, reason", [
    ("-v.resistance * v.rte", r"unknown name in its terms 'rte', did you mean 'rate'\? \(valid: .*steer_rate"),
    ("-v.resistnace * v.rate", "unknown name in its terms 'resistnace', did you mean 'resistance'"),
    ("-v.resistance * v.steer_rte", "unknown name in its terms 'steer_rte', did you mean 'steer_rate'"),
    ("-v.resistance * m.modulus(v.rate)", "AttributeError: .*modulus"),
])  # fmt: skip
def test_a_name_that_nothing_has_is_an_error_of_the_effect(own, term, reason):
    folder = own(term=term)
    (effect,) = load_folder(folder)
    with pytest.raises(InputError, match=rf"effect drag\.square of {re.escape(str(folder / 'drag.py'))}: {reason}"):
        applicable_effects(motorcycles.load("sharp_1971"), [effect])


@pytest.mark.parametrize("changed, reason", [
    ({"element": "spring"}, r"unknown element of Bicycle 'spring' \(valid: "),
    ({"target": "front_tyre_load"}, "adds to 'front_tyre_load', which Bicycle does not have"),
    ({"target": "mass(yaw_rate, yaw_rate)"}, r"adds to 'mass\(yaw_rate, yaw_rate\)', which Bicycle does not have"),
    ({"term": "-v.resistance * v.yaw_rate"}, "unknown variable of Bicycle 'yaw_rate'"),
    ({"element": "steer_angle", "target": "steer_torque"}, "unknown variable of Bicycle 'rate'"),
])  # fmt: skip
def test_an_effect_for_which_the_vehicle_lacks_something_is_left_out_with_the_reason(own, changed, reason):
    (effect,), bicycle = load_folder(own(**changed)), motorcycles.load("benchmark_bicycle")
    assert applicable_effects(bicycle, [effect]) == []
    with pytest.raises(InputError, match=reason):
        raise InputError(obstacle(bicycle, effect))


def test_the_gap_workflow_refuses_an_effect_with_a_wrong_name_before_it_fits(own, tmp_path):
    (tmp_path / "eigenvalues.csv").write_text(TABLE)
    with pytest.raises(InputError, match=r"drag\.py: unknown name in its terms 'rte'"):
        mf.find_gap(tmp_path / "eigenvalues.csv", vehicle="sharp_1971", effects=own(term="-v.resistance * v.rte"))


@pytest.mark.slow
def test_the_gap_workflow_says_which_effect_is_left_out_and_why(own, tmp_path):
    (tmp_path / "eigenvalues.csv").write_text(TABLE)
    found = mf.find_gap(tmp_path / "eigenvalues.csv", vehicle="benchmark_bicycle",
                        effects=own(target="front_tyre_load"))  # fmt: skip
    assert (
        "drag.square is left out: an effect adds to 'front_tyre_load', which Bicycle does not have."
        in found.limitations
    )
