"""Components by name, modes, transfer functions and builds from Python: values, conversions, and errors that name what is valid."""

import json

import matplotlib
import numpy as np
import pytest

import motofmi as mf
from motofmi.cli.main import main
from tests.motofmi.json_schemas import check_against_schema

matplotlib.use("Agg")


def test_components_by_name_by_kind_by_value_and_by_file(tmp_path):
    assert mf.rider("mean_2011").values == mf.rider("rider:mean_2011").values == mf.component("mean_2011").values
    assert (
        mf.damper(7.5).values["damping"]
        == mf.damper("7.5").values["damping"]
        == mf.component("damper:7.5").values["damping"]
        == 7.5
    )
    assert mf.vehicle("sharp_1971", steering_damping=0.0).values["steering_damping"] == 0.0
    rider = mf.rider("mean_2011")
    assert mf.rider(rider) is rider and mf.rider(rider, arm_damping=20.0).values["arm_damping"] == 20.0
    (tmp_path / "mine.toml").write_text('component = "LinearDamper"\n[parameters]\ndamping = 3.0\n', "utf-8")
    assert mf.damper(tmp_path / "mine.toml").values["damping"] == 3.0
    (tmp_path / "bench.py").write_text(
        "from motofmi import Component, input, output\n\n\nclass Wire(Component):\n"
        '    given = input("V", "in")\n    taken = output("V", "out")\n\n    def equations(self, v, m):\n        return {"taken": v.given}\n', "utf-8")  # fmt: skip
    assert mf.component(f"{tmp_path / 'bench.py'}:Wire").outputs == ("taken",)


WRONG = {
    "rider": (lambda: mf.rider("mean_2012"), "unknown rider 'mean_2012', did you mean 'mean_2011'"),
    "vehicle": (lambda: mf.vehicle("sharp_1972"), "unknown motorcycle 'sharp_1972', did you mean 'sharp_1971'"),
    "kind": (lambda: mf.rider("damper:7.5"), "'damper:7.5' is a LinearDamper, not a rider"),
    "value": (lambda: mf.rider("mean_2011", arm_dampin=1.0), "did you mean 'arm_damping'"),
    "mechanism": (lambda: mf.mechanism("pendulm"), "did you mean 'pendulum'"),
    "set": (lambda: mf.modes("sharp_1971", speed=20, set={"steering_dampin": 1.0}), "did you mean 'steering_damping'"),
    "speed": (lambda: mf.modes("sharp_1971", speed=[30, 20]), "ascending"),
    "mode": (lambda: mf.modes("sharp_1971", speed=20)["rear-wobble"], "did you mean 'rear_wobble'"),
    "no device": (lambda: mf.transfer_functions("sharp_1971"), "not a device"),
    "output": (lambda: mf.transfer_functions("damper:7.5")["handlebar_torqe"], "did you mean 'handlebar_torque'"),
    "frequency": (lambda: mf.transfer_functions("damper:7.5", 0.0), "finite and positive"),
    "kind of entry": (lambda: mf.catalogue()["rider"], "did you mean 'riders'"),
    "version": (lambda: mf.build("damper:7.5", fmi=4), "unknown FMI version '4'"),
    "set of several": (lambda: mf.build(["damper:7.5", "damper:5"], set={"damping": 1.0}), "single component"),
    "no file": (lambda: mf.check("nowhere.fmu"), "there is no file nowhere.fmu"),
    "folder": (lambda: mf.check("."), r"\. is a folder; give paths of \.fmu archives, .* \./\*\.fmu"),
}


@pytest.mark.parametrize(("call", "message"), WRONG.values(), ids=WRONG)
def test_a_wrong_name_or_value_is_an_error_that_lists_what_is_valid(call, message):
    with pytest.raises(mf.InputError, match=message):
        call()


def test_modes_are_those_of_the_command_line(capsys):
    assert (
        main(["modes", "--device", "rider:mean_2011", "--speed", "10:50:10", "--set", "arm_damping=20", "--json", "-"])
        == 0
    )
    printed = json.loads(capsys.readouterr().out)
    check_against_schema("modes", printed)
    found = mf.modes("sharp_1971", "rider:mean_2011", np.arange(10, 51, 10), set={"arm_damping": 20.0})
    assert printed.keys() - {"units"} == found.to_dict().keys()
    np.testing.assert_array_equal(printed["modes"]["weave"]["damping_ratio"], found["weave"].damping_ratio)
    assert found.unstable == printed["unstable"] and found.title == "sharp_1971 with mean_2011"


@pytest.mark.slow
def test_modes_of_fmus_are_those_of_the_components(tmp_path):
    bike, rider = (mf.build(name, tmp_path).path for name in ("sharp_1971", "rider:1_2011"))
    of_fmus, of_components = mf.modes(bike, rider, [20.0, 40.0]), mf.modes("sharp_1971", "rider:1_2011", [20.0, 40.0])
    # The FMUs give exact derivatives; rounding in another order remains.
    np.testing.assert_allclose(of_fmus["wobble"].eigenvalue, of_components["wobble"].eigenvalue, rtol=1e-9)


@pytest.mark.slow
def test_devices_side_by_side():
    both = mf.compare_modes("sharp_1971", {"rider": "rider:mean_2011", "damper": mf.damper(7.5)}, [20.0, 40.0])
    np.testing.assert_array_equal(
        both["damper"]["wobble"].eigenvalue, mf.modes("sharp_1971", "damper:7.5", [20.0, 40.0])["wobble"].eigenvalue
    )
    assert list(both.to_dict()["devices"]) == ["rider", "damper"] and set(both.to_dataframe()["device"]) == {
        "rider",
        "damper",
    }
    assert [text.get_text() for text in both.plot().get_legend().get_texts()][:2] == ["rider", "damper"]
    with pytest.raises(mf.InputError, match="the same name"):
        mf.compare_modes("sharp_1971", ["damper:7.5", "damper:7.5"], 20.0)


@pytest.mark.slow
def test_a_damper_is_a_torque_against_the_rate():
    response = mf.transfer_functions(mf.damper(7.5), [1.0, 2.0])
    np.testing.assert_allclose(response["handlebar_torque"], -7.5 * 2j * np.pi * response.frequency, rtol=1e-12)
    assert response.units["handlebar_torque"] == response.to_xarray()["handlebar_torque"].attrs["units"] == "N.m/rad"
    assert list(response.to_dataframe().index) == [1.0, 2.0]


@pytest.mark.slow
def test_built_archives_are_clean(tmp_path):
    built = mf.build([mf.damper(7.5), "rider:mean_2011"], tmp_path)
    assert [fmu.path.name for fmu in built] == ["damper_7_5.fmu", "rider_mean_2011.fmu"] and len(
        built.to_dataframe()
    ) == 2
    with pytest.raises(mf.InputError, match=r"take built\[0\]"):
        _ = built.path
    found = mf.check(built[0].path)
    assert (
        found.clean
        and found.to_dict() == {"fmu": str(built[0].path), "problems": []}
        and "clean" not in repr(found[built[0].path])
    )
