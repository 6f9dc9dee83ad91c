"""FMUs given by their paths, as the vehicle or as devices: parameters set by name, and several of them together."""

import numpy as np
import pytest

import motofmi as mf
from fmus.support.errors import InputError
from motofmi.cli.main import main
from motofmi.workflows.parts import with_archives

SPEEDS = [20.0, 40.0]


@pytest.fixture(scope="module")
def fmus(tmp_path_factory):
    """A motorcycle, a rider and a damper as archives."""
    folder = tmp_path_factory.mktemp("fmus")
    built = mf.build(["sharp_1971", "rider:mean_2011", "damper:7.5"], out=folder)
    return dict(zip(("vehicle", "rider", "damper"), (each.path for each in built), strict=True))


SET = {"arm_damping": 40.0, "vehicle.steering_damping": 2.0}


def test_parameters_of_fmus_are_those_of_their_components(fmus):
    """The same names set in the components, whose linearisation is exact."""
    expected = mf.modes("sharp_1971", "rider:mean_2011", SPEEDS, set=SET)
    found = mf.modes(fmus["vehicle"], fmus["rider"], SPEEDS, set=SET)
    unchanged = mf.modes(fmus["vehicle"], fmus["rider"], SPEEDS)
    for mode in ("weave", "wobble"):
        # directional derivatives of the FMUs are exact but for rounding, of 1e-16 times stiffnesses of 1e5
        assert np.allclose(found[mode].eigenvalue, expected[mode].eigenvalue, rtol=1e-9)
        assert not np.allclose(unchanged[mode].eigenvalue, expected[mode].eigenvalue, rtol=1e-3)


def test_devices_given_as_fmus_and_by_name_act_together(fmus):
    expected = mf.modes("sharp_1971", ["rider:mean_2011", "damper:7.5"], SPEEDS)
    for given in (["rider", "damper"], ["rider"]):
        names = [] if "damper" in given else ["damper:7.5"]
        vehicle, devices = with_archives(None, names, [fmus[name] for name in given], ("sharp_1971", [None]))
        found = mf.modes(vehicle, devices, SPEEDS)
        assert np.allclose(found["weave"].eigenvalue, expected["weave"].eigenvalue, rtol=1e-9)


def test_an_fmu_takes_the_place_of_what_is_usual_but_not_of_what_is_given(fmus):
    usual = ("sharp_1971", ["rider:mean_2011"])
    assert with_archives(None, [], [], usual) == ("sharp_1971", ["rider:mean_2011"])
    assert with_archives(None, [], [fmus["damper"]], usual) == ("sharp_1971", [fmus["damper"]])
    assert with_archives(None, ["none"], [fmus["vehicle"]], usual) == (fmus["vehicle"], ["none"])
    with pytest.raises(InputError, match=r"two vehicles are given, jbike and .*sharp_1971\.fmu"):
        with_archives("jbike", [], [fmus["vehicle"]], usual)


@pytest.mark.parametrize("settings, sentence", [
    ({"damping": 3.0}, "'damping' is a parameter of device and device_2: write device_2.damping=3"),
    ({"device.dumping": 3.0}, "unknown parameter 'device.dumping'"),
    ({"device.damping": -3.0}, "outside its bounds"),
])  # fmt: skip
def test_a_parameter_that_cannot_be_set_is_refused(fmus, settings, sentence):
    with pytest.raises(InputError, match=sentence):
        mf.cosimulate("sharp_1971", [fmus["damper"], "damper:2"], set=settings, duration=0.01)


def test_a_system_takes_no_vehicle_beside_it_at_the_command_line(fmus, tmp_path, capsys):
    path = tmp_path / "ridden.ssp"
    assert main(["build", str(fmus["vehicle"]), str(fmus["rider"]), "--ssp", str(path), "--set", "arm_damping=40"]) == 0
    expected = mf.modes("sharp_1971", "rider:mean_2011", SPEEDS, set={"arm_damping": 40.0})
    assert np.allclose(mf.modes(ssp=path, speed=SPEEDS)["weave"].eigenvalue, expected["weave"].eigenvalue, rtol=1e-9)
    for command in (["modes"], ["cosimulate", "--out", str(tmp_path / "run.csv")]):
        for beside in (["--vehicle", "jbike"], ["--device", "damper:3"], ["--fmu", str(fmus["rider"])]):
            assert main([*command, "--ssp", str(path), *beside]) == 2
            assert "takes neither vehicle nor device" in capsys.readouterr().err
