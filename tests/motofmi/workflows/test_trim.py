"""Steady turning from Python and from the command line."""

import json

import numpy as np
import pytest

import motofmi as mf
from motofmi.cli.main import main
from motofmi.workflows.trim import QUANTITIES
from tests.motofmi.json_schemas import check_against_schema


@pytest.fixture(scope="module")
def found():
    return mf.trim("tum_2020", speed=20, lean=[-25.0, 0.0, 25.0])


@pytest.mark.slow
def test_left_and_right_differ_in_signs_alone(found):
    even = {"drive_torque", "front_wheel_torque", "front_suspension", "rear_suspension"}
    even |= {f"{end}_{name}" for end in ("front", "rear") for name in (
        "load", "grip_used", "tyre_deflection", "longitudinal_force", "longitudinal_slip")}  # fmt: skip
    for name in set(QUANTITIES) - {"residual"}:
        left, upright, right = found[name]
        # Rounding, against values of about 1 N and above 1e-4 rad.
        assert left == pytest.approx(right if name in even else -right, rel=1e-7, abs=1e-9)
        assert name in even or abs(upright) < 1e-8
    for mode in found.named.values():
        assert mode.eigenvalue[0] == pytest.approx(mode.eigenvalue[2], rel=1e-6, nan_ok=True)
    assert found["lateral_acceleration"] == pytest.approx(20 * found["yaw_rate"])


@pytest.mark.slow
def test_result_as_table_figure_and_dictionary(found):
    table = found.to_dataframe()
    assert list(table["lean [deg]"]) == [-25.0, 0.0, 25.0]
    assert np.array_equal(table["wobble frequency [Hz]"], found["wobble"].frequency)
    assert (
        repr(found)
        == "Trim(tum_2020 without a device at 20 m/s: lean -25 to 25 deg; weave, wobble, capsize, rear_wobble, "
        "bounce, pitch, front_hop, rear_hop, fork_bending)"
    )
    assert "steer_torque [N.m]" in found._repr_html_()
    assert found.plot().get_xlabel() == "real part [1/s]"
    assert set(found.to_dict()) == {
        "vehicle",
        "device",
        "assumed",
        "speed",
        "longitudinal_acceleration",
        "lean",
        *QUANTITIES,
        "eigenvalues",
        "modes",
    }
    with pytest.raises(mf.InputError, match="unknown quantity or mode 'weve', did you mean 'weave'"):
        _ = found["weve"]


@pytest.mark.slow
def test_the_command_writes_the_result_of_the_function(found, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ["trim", "--speed", "20", "--lean", "0:25:25", "--set", "fork_bending=0", "--set", "front_pDy1=1.1"]
    assert main([*words, "--json", "corner.json", "--csv", "corner.csv", "--plot", "corner.png"]) == 0
    shown = capsys.readouterr().out
    assert "steer torque [N.m]" in shown and "weave" in shown and "written: corner.csv" in shown
    written = json.loads((tmp_path / "corner.json").read_text("utf-8"))
    check_against_schema("trim", written)
    same = mf.trim(speed=20, lean=[0, 25], set={"fork_bending": 0.0, "front_pDy1": 1.1})
    assert written["steer_torque"] == pytest.approx(same["steer_torque"].tolist(), abs=1e-9)
    assert written["units"]["steer_torque"] == "N.m" and written["units"]["lean"] == "deg"
    assert same["front_grip_used"][1] > 1.05 * found["front_grip_used"][2]  # less grip, more of it used


@pytest.mark.parametrize("given, message", [
    ({"vehicle": "sharp_1971"}, "motorcycle_sharp_1971 is a Motorcycle, which has no equations for corners"),
    ({"device": "rider:roll_1971"}, "rider_roll_1971 acts at more than the handlebar port"),
    ({"lean": 85.0}, "lean angles must be from -80 to 80"), ({"lean": np.nan}, "lean angles must be from -80 to 80"),
    ({"speed": 500.0}, "speed = 500 m/s is outside its bounds"), ({"speed": [20.0, 30.0]}, "trim takes one speed"),
    ({"set": {"front_pDy": 1.0}}, "unknown parameter 'front_pDy'"),
])  # fmt: skip
def test_what_cannot_be_trimmed_is_said_at_once(given, message):
    with pytest.raises(mf.InputError, match=message):
        mf.trim(**{"vehicle": "tum_2020", "speed": 20.0, "lean": 10.0, **given})


@pytest.mark.slow
def test_the_vehicle_that_is_given_stays_as_it_is():
    given = mf.vehicle("tum_2020")
    before = dict(given.supplement)
    locked = mf.trim(given, speed=20.0, lean=10.0, set={"front_suspension": 0.0})
    assert "front_suspension" in before and given.supplement == before
    assert locked["front_suspension"] == 0.0 != mf.trim(given, speed=20.0, lean=10.0)["front_suspension"]


def test_a_supplement_that_is_no_number_is_refused(tmp_path):
    text = 'component = "LinearDamper"\n[parameters]\ndamping = 1.0\n[supplement]\nextra = "much"\n'
    (tmp_path / "mine.toml").write_text(text, "utf-8")
    with pytest.raises(mf.InputError, match=r"mine.toml: extra under \[supplement\] needs a finite number, not 'much'"):
        mf.component(tmp_path / "mine.toml")
