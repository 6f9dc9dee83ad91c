"""FMUs of others: units that are missing or stated, parameters of other types, inputs from a file in any unit."""

import re
import zipfile

import pandas as pd
import pytest

import motofmi as mf
from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem
from fmus.cosimulation.subsystems.stated_units import MissingUnitsWarning
from fmus.support.errors import InputError
from motofmi.cli.main import main
from tests.coupled import RIDER
from tests.typed_fmu import typed_fmu

WITHOUT = ("seen_flag", "seen_count", "seen_mode", "label_length")
STATED = {**dict.fromkeys(("u", "y"), "m/s"), **dict.fromkeys(WITHOUT, "1")}


def test_a_missing_unit_is_unknown_and_warned_of_once(tmp_path):
    path = typed_fmu(tmp_path / "typed.fmu", unit="")
    with pytest.warns(MissingUnitsWarning, match=r"no unit in the model description: typed\.u, typed\.y, .*--unit u=UNIT") as warned:
        run = mf.simulate(path, set={"u": 2.0, "gain": 3.0})
    assert len(warned) == 1
    assert run.columns[:3] == ("time [s]", "typed.u", "typed.y") and run.units["typed.y"] == ""
    assert run["typed.y"][-1] == 6.0
    assert run.plot("typed.y")[0].get_ylabel() == "y"


def test_a_unit_can_be_stated(tmp_path):
    path = typed_fmu(tmp_path / "typed.fmu", unit="")
    run = mf.simulate(path, units=STATED, inputs={"time": [0.0, 2.0], "u [km/h]": [36.0, 72.0]})
    assert run.columns[1] == "typed.u [m/s]" and run["typed.y"][[0, -1]] == pytest.approx([10.0, 20.0])
    with pytest.raises(InputError, match="unknown variable of typed 'seen_flg', did you mean 'seen_flag'"):
        mf.simulate(path, units={"seen_flg": "1"})
    with pytest.raises(InputError, match=r"unknown unit \[furlong\]"):
        mf.simulate(path, units={"u": "furlong"})
    with pytest.raises(InputError, match=r"typed\.u has the unit \[m/s\] in its model description; it cannot be stated as \[km/h\]"):
        mf.simulate(typed_fmu(tmp_path / "typed.fmu"), units={"u": "km/h"})


def test_inputs_are_converted_to_the_unit_of_the_fmu(tmp_path):
    path = typed_fmu(tmp_path / "typed.fmu", unit="km/h")
    file = tmp_path / "in.csv"
    file.write_text("time [ms],u [m/s]\n0,10\n1000,20\n")
    stated = dict.fromkeys(WITHOUT, "1")
    assert mf.simulate(path, units=stated, inputs=file, duration=1.0)["typed.y"][[0, -1]] == pytest.approx([36.0, 72.0])
    file.write_text("time [s],u [N]\n0,10\n1,20\n")
    with pytest.raises(InputError, match=r"the column u of the inputs: unit \[N\] cannot be converted to \[km/h\]"):
        mf.simulate(path, units=stated, inputs=file)


@pytest.mark.slow
def test_simulate_writes_units_and_a_figure_and_takes_values_of_every_type(tmp_path, capsys):
    path, out, figure = typed_fmu(tmp_path / "typed.fmu"), tmp_path / "run.csv", tmp_path / "run.png"
    words = ["simulate", str(path), "--out", str(out), "--plot", str(figure), "--duration", "0.5"]
    for name in WITHOUT:
        words += ["--unit", f"{name}=1"]
    values = [word for value in ("flag=true", "count=3", "mode=fast", "label=abcd", "u=5") for word in ("--set", value)]
    assert main([*words, *values]) == 0
    rows = pd.read_csv(out)
    assert list(rows)[:3] == ["time [s]", "typed.u [m/s]", "typed.y [m/s]"]
    assert rows.iloc[-1, 3:].tolist() == [1.0, 3.0, 2.0, 4.0] and figure.stat().st_size > 1000
    for wrong, message in (("count=1.5", "count = 1.5 does not fit a variable of type Integer"), ("flag=perhaps", "does not fit a variable of type Boolean"),
                           ("mode=quick", "unknown item of mode 'quick'"), ("gian=1", "unknown variable of typed 'gian', did you mean 'gain'"),
                           ("gain=fast", "gain = 'fast' does not fit a variable of type Real")):  # fmt: skip
        assert main([*words, "--set", wrong]) == 2
        assert message in capsys.readouterr().err


@pytest.mark.filterwarnings("default::fmus.cosimulation.subsystems.stated_units.MissingUnitsWarning")
def test_the_command_prints_one_line_for_missing_units(tmp_path, capsys):
    path = typed_fmu(tmp_path / "typed.fmu", unit="")
    assert main(["simulate", str(path), "--out", str(tmp_path / "run.csv"), "--duration", "0.2"]) == 0
    (line,) = [each for each in capsys.readouterr().err.splitlines() if "unit" in each]
    assert line.startswith("motofmi simulate: warning: no unit in the model description: typed.u")


@pytest.mark.slow
def test_a_device_without_units_is_coupled_with_one_warning(tmp_path):
    # An archive of another tool: the description of the rider without its units.
    path = without_units(mf.build(RIDER, tmp_path).path)
    with pytest.warns(MissingUnitsWarning) as warned:
        found = mf.modes("sharp_1971", path, speed=[30.0])
    assert len(warned) == 1
    exact = mf.modes("sharp_1971", RIDER, speed=[30.0])
    assert found["weave"].eigenvalue == pytest.approx(exact["weave"].eigenvalue, rel=1e-9)  # rounding of the C code
    with pytest.warns(MissingUnitsWarning):
        run = mf.cosimulate("sharp_1971", path, duration=0.1, initial={"steer_rate": 0.5})
    assert "device.handlebar_torque" in run.columns
    units = {"steer_angle": "rad", "steer_rate": "rad/s", "frame_rate": "rad/s", "handlebar_torque": "N.m", "frame_torque": "N.m",
             "torso_angle": "rad", "torso_rate": "rad/s"}  # fmt: skip
    with FmuSubsystem(path) as fmu:
        assert set(units) == {*fmu.inputs, *fmu.outputs}
    assert "device.handlebar_torque [N.m]" in mf.cosimulate("sharp_1971", path, duration=0.1, units=units).columns
    with pytest.raises(InputError, match="unknown variable 'handlebar_torqe', did you mean 'handlebar_torque'"):
        mf.modes("sharp_1971", path, speed=[30.0], units={"handlebar_torqe": "N.m"})
    with pytest.raises(InputError, match=r"device.handlebar_torque \[N\] cannot drive vehicle.handlebar_torque \[N\.m\]"):
        mf.cosimulate("sharp_1971", path, duration=0.1, units={**units, "handlebar_torque": "N"})


def without_units(path):
    """The archive with no unit in its description."""
    with zipfile.ZipFile(path) as archive:
        contents = {name: archive.read(name) for name in archive.namelist()}
    text = contents["modelDescription.xml"].decode()
    text = re.sub(r"<UnitDefinitions>.*</UnitDefinitions>", "", text, flags=re.DOTALL)
    contents["modelDescription.xml"] = re.sub(r' (unit|displayUnit)="[^"]*"', "", text).encode()
    bare = path.with_name("bare.fmu")
    with zipfile.ZipFile(bare, "w") as archive:
        for name, data in contents.items():
            archive.writestr(name, data)
    return bare
