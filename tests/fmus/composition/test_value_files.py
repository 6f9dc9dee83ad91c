"""Value files: what they give, and what is said of one that is wrong."""

import math
import os
import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as some

from fmus import InputError
from fmus.composition.value_files import Library, value_file
from rider_fmu import COMPONENTS, riders
from vehicle_fmu import dampers, motorcycles

GOOD = """
component = "PassiveRider"
description = "A rider"
source = "Somebody's table"
[parameters]
torso_inertia = 0.7
arm_stiffness = { value = 20.0, unit = "N.m/deg" }
arm_damping = { value = 30.0, unit = "N.m.s/rad", assumed = "a guess" }
[printed]
nu_t = { value = 6.0, unit = "Hz" }
"""


@pytest.fixture
def library(tmp_path):
    def with_file(text, name="mine"):
        (tmp_path / f"{name}.toml").write_text(text, "utf-8")
        return Library("rider", tmp_path, COMPONENTS)

    return with_file


def test_a_file_becomes_a_component(library):
    rider = library(GOOD).load("mine", waist_damping=2.0)
    assert rider.name == "rider_mine"
    assert rider.source == "Somebody's table"
    assert rider.assumed == {"arm_damping": "a guess"}
    assert rider.values["torso_inertia"] == 0.7
    assert rider.values["arm_stiffness"] == pytest.approx(20 * 180 / 3.141592653589793)
    assert rider.values["waist_damping"] == 2.0


def test_a_path_will_do_for_a_name(library, tmp_path):
    assert library(GOOD).load(tmp_path / "mine.toml").name == "rider_mine"


@pytest.mark.parametrize("text, replacement, message", [
    ("torso_inertia = 0.7", "torso_inertai = 0.7", r"unknown parameter 'torso_inertai', did you mean 'torso_inertia'\? \(valid: added_steer_inertia, "),
    ("torso_inertia = 0.7", "torso_inertia = 70.0", r"torso_inertia = 70 kg\.m2 is outside its bounds \[0\.001, 20\]"),
    ("torso_inertia = 0.7", "torso_inertia = nan", r"torso_inertia = nan kg\.m2 is outside its bounds"),
    ("torso_inertia = 0.7", "torso_inertia = 'heavy'", r"torso_inertia needs a number \[kg\.m2\], as in torso_inertia = "),
    ("torso_inertia = 0.7", "torso_inertia = true", r"torso_inertia needs a number \[kg\.m2\]"),
    ("torso_inertia = 0.7", "torso_inertia = { unit = 'kg.m2' }", r"torso_inertia needs a number \[kg\.m2\]"),
    ("torso_inertia = 0.7", "torso_inertia = { value = 0.7, unti = 'kg.m2' }", r"unknown key of torso_inertia 'unti', did you mean 'unit'\?"),
    ('"N.m/deg"', '"N.m/(deg.s)"', r"unknown unit \[N\.m/\(deg\.s\)\] .*a unit has no parentheses: .* as in 1/V\.s"),
    ('"N.m/deg"', '"N.m/grade"', r"unknown unit \[N\.m/grade\] at 'grade' \(known symbols: .*deg"),
    ('"N.m/deg"', '"N.m"', r"unit \[N\.m\] cannot be converted to \[N\.m/rad\]"),
    ("[printed]", "[prints]", r"unknown key 'prints', did you mean 'printed'\? \(valid: about, .*\) in mine\.toml"),
    ('"PassiveRider"', '"ActiveRider"', r"unknown component in mine 'ActiveRider', did you mean 'PassiveRider'\?"),
    ('"N.m/deg"', "3", r"unknown unit \[3\]"),
    ("[parameters]", "parameters = 3\n[about]", r"mine\.toml: parameters is not a table"),
    ("[parameters]", "[parameters", r"mine\.toml is not a valid TOML file: "),
])  # fmt: skip
def test_what_is_wrong_with_a_file_is_named_in_one_line(library, text, replacement, message):
    with pytest.raises(InputError, match=message) as error:
        library(GOOD.replace(text, replacement)).load("mine")
    assert "\n" not in str(error.value)


def test_a_name_that_is_not_there(library):
    with pytest.raises(InputError, match=r"unknown rider 'nobody' \(valid: mine\)"):
        library(GOOD).load("nobody")


def test_a_file_that_is_not_there(library, tmp_path):
    with pytest.raises(InputError, match=r"cannot read .*absent\.toml: No such file"):
        library(GOOD).load(tmp_path / "absent.toml")


def test_a_changed_file_is_read_again(library):

    changed = library(GOOD)
    assert changed.load("mine").values["torso_inertia"] == 0.7
    library(GOOD.replace("0.7", "0.8"))
    os.utime(changed.folder / "mine.toml", (0, 0))
    assert changed.load("mine").values["torso_inertia"] == 0.8


text = some.text(some.characters(exclude_categories=["Cs"]), max_size=30)  # anything that UTF-8 can write


@pytest.mark.slow
@given(
    description=text,
    source=text,
    unit=text,
    value=some.floats(allow_nan=False),
    error=some.none() | some.floats(0, allow_nan=False),
)
def test_a_written_value_file_is_read_as_it_was_given(description, source, unit, value, error):
    contents = tomllib.loads(value_file("PassiveRider", {"arm_stiffness": (value, error, unit)}, description, source))
    assert (contents["component"], contents["description"], contents["source"]) == ("PassiveRider", description, source)
    known = {} if error is None or math.isinf(error) else {"standard_error": error}
    assert contents["parameters"] == {"arm_stiffness": {"value": value, "unit": unit} | known}


def test_what_ships():
    published = [*(f"{n}_2008" for n in range(1, 6)), *(f"{n}_2011" for n in range(1, 11)), "mean_2011"]
    assert [n for n in riders.names() if n in published] == published  # in this order: numbers count as numbers
    assert {"sharp_1971", "reference_2011", "benchmark_bicycle"} <= set(motorcycles.names())
    assert {"low_2011", "medium_2011", "high_2011", "progressive", "inerter"} <= set(dampers.names())


@pytest.mark.parametrize(
    "library_, name", [(lib, n) for lib in (riders, motorcycles, dampers) for n in lib.names()], ids=str
)
def test_what_ships_gives_every_parameter_without_an_honest_default(library_, name):
    """A parameter that a file leaves out takes a default of zero only where its description allows for none of it."""
    component, given = library_.load(name), library_.contents(name)["parameters"]
    left_out = {n for n in component.rows("parameter") if n not in given}
    assert all(component.values[n] == 0 for n in left_out), left_out


@pytest.mark.parametrize("named", [False, True])
def test_a_folder_of_effects_is_executed_only_where_the_file_names_effects(named, library, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "any.py").write_text(
        "from pathlib import Path\n\nfrom fmus import Effect, adds_to, parameter\n\n"
        "Path(__file__).with_suffix('.executed').touch()\n\n\n"
        "class Preload(Effect):\n    family, form = 'preload', 'constant'\n"
        "    torque = parameter('N.m', 'Torque', start=2.0)\n\n"
        "    @adds_to('arm_torque')\n    def constant(self, v, m):\n        return v.torque\n"
    )
    given = 'effects_folder = "mine"\n' + 'effects = ["preload.constant"]\n' * named
    rider = library(given + GOOD).load(tmp_path / "mine.toml")
    assert (tmp_path / "mine" / "any.executed").exists() == ("preload.torque" in rider.values) == named
