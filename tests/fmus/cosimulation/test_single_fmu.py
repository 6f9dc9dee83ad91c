"""One FMU by itself: an end that it asks for, outputs of every type, an instance that it refuses, the duration."""

import json
from ctypes import CFUNCTYPE, POINTER, c_bool, c_double, c_int, c_void_p
from types import SimpleNamespace

import numpy as np
import pytest

import motofmi as mf
from fmus.cosimulation import cosimulate as cosimulation
from fmus.cosimulation.simulate import simulate
from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem
from fmus.cosimulation.subsystems.other_outputs import OtherOutputs
from fmus.support.errors import InputError, SimulationError
from motofmi.cli.main import main
from tests.typed_fmu import typed_fmu

pytestmark = pytest.mark.filterwarnings("ignore:no unit in the model description")
END = {"end_time": 0.35, "gain": 2.0}
INPUT = {"time": [0.0, 1.0], "u": [0.0, 1.0]}


def test_the_run_ends_where_the_fmu_asks_for_it(tmp_path, capsys):
    path, out = typed_fmu(tmp_path / "typed.fmu", more=True), tmp_path / "run.csv"
    run = mf.simulate(path, set=END, inputs=INPUT, step=0.1, duration=1.0)
    assert run["time"] == pytest.approx([0, 0.1, 0.2, 0.3, 0.35]) and run.steps == 4
    assert run["typed.u"] == pytest.approx(run["time"])
    assert run.notes[0] == "typed asked for the end of the simulation at 0.35 s, before the duration of 1 s"
    words = ["simulate", str(path), "--step", "0.1", "--set", "end_time=0.3", "--out", str(out)]
    assert main(words) == 0
    shown = capsys.readouterr().out
    assert "note: typed asked for the end of the simulation at 0.3 s" in shown and f"written: {out}" in shown
    assert np.loadtxt(out, delimiter=",", skiprows=1)[:, 0] == pytest.approx([0, 0.1, 0.2, 0.3])
    assert main([*words, "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["rows"] == 4 and found["notes"][0].startswith("typed asked for the end")


@pytest.mark.slow
def test_an_fmu_of_fmi_3_ends_the_run_too(tmp_path):
    with FmuSubsystem(mf.build("damper:7.5", tmp_path, fmi=3).path, "damper") as damper:
        step = damper.calls._step

        def ending(time, size, *rest):
            step(time, size, *rest)
            _, terminate, _, last = damper.calls._answers
            terminate.value, last.value = time + size > 0.29, time + size

        damper.calls._step = ending
        run = simulate(damper, 0.1, 1.0)
    assert run["time"] == pytest.approx([0, 0.1, 0.2, 0.3])
    assert run.notes == ("damper asked for the end of the simulation at 0.3 s, before the duration of 1 s",)


@pytest.mark.parametrize("compiled", [True, False])
def test_a_co_simulation_says_which_fmu_asked_for_the_end(compiled, tmp_path, monkeypatch):
    monkeypatch.setattr(cosimulation, "_linear", lambda *_: None)  # the FMU has no states to linearise
    path = typed_fmu(tmp_path / "typed.fmu", more=True)
    ended = pytest.raises(SimulationError, match=r"one asked for the end of the simulation at 0\.35 s$")
    with FmuSubsystem(path, "one", END) as one, FmuSubsystem(path, "two") as two, ended:
        cosimulation.cosimulate({"one": one, "two": two}, 0.1, 1.0, "jacobi", wiring={"two.u": ["one.y"]},
                                compiled=compiled)  # fmt: skip


@pytest.mark.slow
def test_the_compiled_loop_says_when_an_fmu_of_fmi_3_asked_for_the_end(tmp_path, monkeypatch):
    monkeypatch.setattr(cosimulation, "_linear", lambda *_: None)
    flag = POINTER(c_bool)

    @CFUNCTYPE(c_int, c_void_p, c_double, c_double, c_bool, flag, flag, flag, POINTER(c_double))
    def ending(_instance, time, step, _, event, terminate, early, last):
        event[0], terminate[0], early[0], last[0] = False, time + step > 0.29, False, time + step / 2
        return 0

    path = mf.build("rider:mean_2011", tmp_path, fmi=3).path
    ended = pytest.raises(SimulationError, match=r"stopped at 0\.2 s.*: one asked for the end .* at 0\.25 s$")
    with FmuSubsystem(path, "one") as one, FmuSubsystem(path, "two") as two, ended:
        one.calls.fmu.dll.fmi3DoStep = ending
        wiring = {"two.steer_rate": ["one.torso_rate"]}
        cosimulation.cosimulate({"one": one, "two": two}, 0.1, 1.0, "jacobi", wiring=wiring)


def test_outputs_of_every_type_have_columns_and_notes_name_the_others(tmp_path):
    path = typed_fmu(tmp_path / "typed.fmu", more=True)
    run = mf.simulate(path, set={"flag": True, "count": 7, "mode": "fast"}, step=0.1, duration=0.2)
    assert run.keys()[-3:] == ["typed.shown_flag", "typed.shown_mode", "typed.shown_count"]
    assert run.rows[:, -3:].tolist() == [[1.0, 2.0, 7.0]] * 3
    assert [note.partition(";")[0] for note in run.notes] == [
        "inputs without a column, which keep their value: steps_wanted (Integer)",
        "outputs without a column: shown_label (String)",
    ]


def test_an_array_has_a_column_for_each_element():
    def variable(name, kind, reference, *shape, causality="output"):
        return SimpleNamespace(
            name=name, type=kind, valueReference=reference, shape=shape, dimensions=list(shape), causality=causality
        )

    variables = [variable("y", "Float64", 1, 2), variable("on", "Boolean", 2), variable("z", "Float64", 3, 1, 2),
                 variable("v", "Float64", 4, 3, causality="input")]  # fmt: skip
    values = {1: [1.5, 2.5], 2: [True], 3: [3.5, 4.5]}

    def get(references, count):
        found = [value for reference in references for value in values[reference]]
        assert len(found) == count
        return found

    calls = SimpleNamespace(version=3, fmu=SimpleNamespace(getFloat64=get, getBoolean=get))
    fmu = SimpleNamespace(description=SimpleNamespace(modelVariables=variables), calls=calls)
    others = OtherOutputs(fmu)
    assert others.names == ("y[1]", "y[2]", "on", "z[1][1]", "z[1][2]")
    assert others.variables == ("y", "y", "on", "z", "z")
    assert others.read().tolist() == [1.5, 2.5, 1.0, 3.5, 4.5]
    assert "v (array of Float64)" in others.notes[0]


def test_a_refused_instance_states_the_message_of_the_fmu(tmp_path):
    with pytest.raises(InputError, match="fmi2Instantiate failed: the GUID is of another model"):
        mf.simulate(typed_fmu(tmp_path / "other.fmu", guid=' guid="{other}"'))
    with pytest.raises(InputError, match=r"none\.fmu: modelDescription\.xml has no guid"):
        mf.simulate(typed_fmu(tmp_path / "none.fmu", guid=""))


def test_a_duration_of_zero_is_named(tmp_path):
    with pytest.raises(InputError, match="duration = 0 s: a duration must be positive"):
        mf.simulate(typed_fmu(tmp_path / "typed.fmu"), duration=0)


@pytest.mark.parametrize("text", ["time [s];u [km/h]\n0;3,6\n1,5;7,2\n", "time;u [km/h]\n0.0;3.6\n1.5;7.2\n"])
def test_inputs_with_semicolons_have_a_decimal_point_or_comma(text, tmp_path):
    file = tmp_path / "inputs.csv"
    file.write_text(text)
    run = mf.simulate(typed_fmu(tmp_path / "typed.fmu"), inputs=file, step=0.5, duration=1.5)
    assert run["typed.u"] == pytest.approx([1.0, 4 / 3, 5 / 3, 2.0])
