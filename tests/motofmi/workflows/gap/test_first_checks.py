"""What is refused, or asked for, before anything is fitted."""

from dataclasses import replace

import numpy as np
import pytest

from fmus.declaration.component import Component
from fmus.declaration.variables import input, parameter, state
from fmus.mechanisms import DrivenJoint, MassSpringDamper
from fmus.support.errors import InputError
from motofmi.recordings.reading import read_recording
from motofmi.recordings.recording import Recording
from motofmi.workflows.components import component, ships
from motofmi.workflows.gap.first_checks import (
    notes_on_degrees,
    notes_on_zeros,
    require_distinct,
    require_inputs,
    require_motion,
    require_start,
)

TIME = np.arange(0, 4, 0.01)


def run(units, name="run", shift=0.0):
    columns = {n: np.sin((1 + i) * TIME + shift) for i, n in enumerate(units)}
    return Recording(name, TIME, columns, dict(units))


@pytest.mark.parametrize(
    ("spare", "message"),
    [("N.m", '--map "moment=torque"'), ("A", '--map "moment=torque \\[N.m\\]" \\(its numbers')],
)
def test_an_input_without_a_column_is_asked_for(spare, message):
    recording = run({"angle": "rad", "moment": spare})
    with pytest.raises(InputError, match=message):
        require_inputs(DrivenJoint(), [recording], list(recording.columns))


def test_a_column_without_a_unit_may_be_the_input(tmp_path):
    path = tmp_path / "run.csv"
    np.savetxt(path, np.column_stack([TIME, np.sin(TIME), TIME]), delimiter=",", header="time [s],angle [rad],T", comments="")
    recording = read_recording(path)
    assert recording.unread == ("T",)
    with pytest.raises(InputError, match="T=torque"):
        require_inputs(DrivenJoint(), [recording], list(recording.columns))
    left = read_recording(path, {"T": "unused"})
    assert require_inputs(DrivenJoint(), [left], list(left.columns)) == ["No column is the input torque: it is taken as zero."]


def test_an_output_without_a_column_is_asked_for():
    recording = replace(run({"torque": "N.m"}), unread=("position", "velocity"))
    message = "no column is an output of DrivenJoint .*'position', 'velocity'.*--map \"COLUMN=angle \\[rad\\]\""
    with pytest.raises(InputError, match=message):
        require_motion(DrivenJoint(), [recording], ["torque"])
    with pytest.raises(InputError, match=r'no column is the imposed angle .*--map "deflection=angle"$'):  # in its deg
        require_motion(DrivenJoint(), [run({"torque": "N.m", "deflection": "deg"})], ["torque", "deflection"], "angle")
    with pytest.raises(InputError, match=r'if one of them is the rate, add --map "speed=rate"$'):  # in its rev/min
        require_motion(DrivenJoint(), [run({"torque": "N.m", "speed": "rev/min"})], ["torque", "speed"])
    require_motion(DrivenJoint(), [run({"torque": "N.m", "rate": "rad/s"})], ["torque", "rate"])


@pytest.mark.parametrize(("angle", "doubtful"), [
    (16.0 * np.sin(3 * TIME), True), (0.28 * np.sin(3 * TIME), False),
    (5.0 + 16.0 * TIME, False), (5.0 + 16.0 * TIME + np.sin(9 * TIME), False),
])  # fmt: skip
def test_a_swing_of_revolutions_may_be_in_degrees(angle, doubtful):
    """16 deg labelled rad; a shaft that turns on by ten revolutions, evenly or not, is no swing."""
    columns = {"angle": angle, "torque": np.zeros(len(TIME))}
    recording = Recording("swing", TIME, columns, {"angle": "rad", "torque": "N.m"})
    said = notes_on_degrees(DrivenJoint(), [recording])
    assert bool(said) == doubtful
    assert not said or ("swings by 16" in said[0] and '--map "angle=angle [deg]"' in said[0])
    assert not notes_on_degrees(DrivenJoint(), [replace(recording, converted=frozenset({"angle"}))])  # the file says deg


def test_unused_columns_alone_are_a_note():
    recording = run({"angle": "rad", "torque": "N.m", "temperature": "K"})
    assert "temperature" in require_inputs(DrivenJoint(), [recording], list(recording.columns))[0]


def test_the_fitted_run_does_not_validate_itself():
    fitted = run({"angle": "rad"})
    again = replace(fitted, name="copy", time=fitted.time + 5.0)
    with pytest.raises(InputError, match="validation run copy has the values of the fitted run run"):
        require_distinct([fitted], [again])
    require_distinct([fitted], [run({"angle": "rad"}, shift=1e-9)])


class Massless(Component):
    """A class of a user's whose mass is 0."""

    mass = parameter("kg", "Mass", min=0, max=10, start=0.0)
    force = input("N", "Force")
    speed = state("m/s", "Speed", exposed=True)

    def equations(self, v, m):
        return {"der(speed)": v.force / v.mass}


@pytest.mark.parametrize(("free", "named"), [((), ["spring_damping"]), (("mass",), [])])
def test_a_parameter_of_zero_that_is_not_fitted_is_named(free, named):
    undamped = MassSpringDamper(mass=2.0, spring_stiffness=50.0, spring_damping=0.0)
    assert [note.split()[0] for note in notes_on_zeros(undamped, free)] == named


def test_a_parameter_of_zero_from_which_nothing_starts_is_named():
    with pytest.raises(InputError, match="parameters that are 0: mass"):
        require_start(Massless())
    require_start(DrivenJoint())


def test_values_that_ship_are_no_expectation():
    assert ships(DrivenJoint()) and ships(component("pendulum"))
    assert not ships(DrivenJoint(inertia=3.0)) and not ships(Massless())
