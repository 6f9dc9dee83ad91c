"""The commands `modes` and `device`."""

import json

import numpy as np
import pytest

from motofmi.cli.main import main
from tests.motofmi.cli.test_command_line import result_of
from vehicle_fmu import MODES


def test_modes_has_its_keys(capsys):
    found = result_of(capsys, "modes", "--vehicle", "sharp_1971", "--device", "rider:mean_2011", "--speed", "1:60:0.5")
    assert found["speed"] == pytest.approx(np.linspace(1, 60, 119))
    assert [len(row) for row in found["eigenvalues"]] == [10] * 119
    assert set(found["modes"]) == set(MODES)
    weave = found["modes"]["weave"]
    real, imaginary = np.array(weave["eigenvalue"]).T
    assert (imaginary >= 0).all()
    assert weave["frequency"] == pytest.approx(imaginary / (2 * np.pi))
    for ratio, growth, im in zip(weave["damping_ratio"], real, imaginary, strict=True):
        # A mode that has split into real roots has a frequency of 0 and no damping ratio.
        assert ratio is None if im == 0 else ratio == pytest.approx(-growth / np.hypot(growth, im))
    assert weave["damping_ratio"].count(None) == 7  # at 1.5 to 4.5 m/s: it is real from 1.14 to 4.74 m/s
    (band,) = found["unstable"]["weave"]
    assert band == pytest.approx([33.8, 56.3], abs=0.1)
    assert found["unstable"]["wobble"] == []


@pytest.mark.slow
def test_an_absent_mode_is_null(capsys):
    found = result_of(capsys, "modes", "--speed", "10,20")
    assert found["modes"]["rider_wobble"] == {
        "eigenvalue": [None, None],
        "frequency": [None, None],
        "damping_ratio": [None, None],
    }
    assert "rider_wobble" not in found["unstable"]


@pytest.mark.slow
@pytest.mark.parametrize(
    "text, speeds", [("30", [30]), ("1:10:4", [1, 5, 9, 10]), ("2:3:0.5", [2, 2.5, 3]), ("5,7.5", [5, 7.5])]
)
def test_speeds_have_both_ends(capsys, text, speeds):
    assert result_of(capsys, "modes", "--speed", text)["speed"] == speeds


@pytest.mark.slow
def test_a_device_may_be_a_value_or_a_file(capsys, tmp_path):
    (tmp_path / "mine.toml").write_text(
        'component = "LinearDamper"\n[parameters]\ndamping = { value = 7.5, unit = "N.m.s/rad" }\n', "utf-8"
    )
    by_file = result_of(capsys, "modes", "--device", str(tmp_path / "mine.toml"), "--speed", "20")
    by_value = result_of(capsys, "modes", "--device", "damper:7.5", "--speed", "20")
    by_name = result_of(capsys, "modes", "--device", "high_2011", "--speed", "20")
    assert by_file["modes"] == by_value["modes"] == by_name["modes"]


def test_json_goes_to_a_file_and_the_table_to_the_screen(capsys, tmp_path):
    assert main(["modes", "--speed", "20", "--json", str(tmp_path / "new" / "modes.json")]) == 0
    out = capsys.readouterr().out
    assert "weave" in out and "speed" in out
    assert json.loads((tmp_path / "new" / "modes.json").read_text("utf-8"))["speed"] == [20]
    assert [p.name for p in (tmp_path / "new").iterdir()] == ["modes.json"]


# device -------------------------------------------------------------------------------------------


def test_device_gives_the_transfer_functions_of_the_port(capsys):
    found = result_of(capsys, "device", "damper:7.5", "--frequency", "0.5:12:0.05")
    omega = 2 * np.pi * np.array(found["frequency"])
    assert len(omega) == 231
    for torque, sign in (("handlebar_torque", -1), ("frame_torque", 1)):
        assert np.array(found[torque]) @ [1, 1j] == pytest.approx(
            sign * 1j * omega * 7.5
        )  # 2011, eq. 14, in the port's signs


def test_device_takes_settings_and_says_what_is_assumed(capsys):
    found = result_of(capsys, "device", "rider:4_2008", "--frequency", "1", "--set", "torso_inertia=0.9")
    assert set(found["assumed"]) == {"arm_damping", "waist_damping"}
    assert main(["device", "rider:4_2008", "--frequency", "1"]) == 0
    assert "assumed: arm_damping" in capsys.readouterr().out


@pytest.mark.parametrize(
    "arguments, said",
    [
        (["modes", "--set", "arm_damping=10", "--set", "arm_damping=20"], "arm_damping is given twice, 10.0 and 20.0"),
        (["simulate", "damper:5", "--set", "a=x", "--set", "a=2"], "a is given twice, x and 2.0"),
        (["modes", "--unit", "torque=N.m", "--unit", "torque=Ncm"], "torque is given twice, N.m and Ncm"),
    ],
)
def test_a_name_with_two_values_is_refused(capsys, arguments, said):
    assert main(arguments) == 2
    assert said in capsys.readouterr().err


def test_a_value_that_is_no_number_is_not_taken_for_two_values(capsys):
    assert main(["modes", "--set", "trail=nan"]) == 2
    assert "twice" not in capsys.readouterr().err


def test_the_same_value_twice_is_one_value(capsys):
    assert main(["device", "damper:5", "--set", "damping=4", "--set", "damping=4.0"]) == 0
