"""One FMU by itself: an end that it asks for, outputs of every type, an instance that it refuses, the duration."""

import json
import zipfile
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
SYSTEM = """<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription" version="1.0" name="s">
  <ssd:System name="s"><ssd:Elements>
    <ssd:Component name="source" type="application/x-fmu-sharedlibrary" source="resources/typed.fmu"><ssd:Connectors /></ssd:Component>
  </ssd:Elements></ssd:System>
</ssd:SystemStructureDescription>
"""
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


def test_inputs_of_another_time_are_refused_and_those_of_a_part_are_noted(tmp_path, capsys):
    path, late = typed_fmu(tmp_path / "typed.fmu"), {"time": [5.0, 6.0], "u": [1.0, 2.0]}
    with pytest.raises(InputError, match=r"given from 5 to 6 s, the run is from 0 to 2 s: shift the times of the inputs, or give"):
        mf.simulate(path, inputs=late, step=0.1, duration=2.0)
    run = mf.simulate(path, inputs=late, step=0.1, start=5.0, duration=1.0)
    assert run["typed.u"] == pytest.approx(1.0 + run["time"] - 5.0) and not run.notes
    longer = mf.simulate(path, inputs=late, step=0.1, start=5.0, duration=2.0)
    assert longer["typed.u"][-1] == 2.0 and longer.notes[0].startswith("the inputs are given from 5 to 6 s, the run is from 5 to 7 s")
    with pytest.raises(InputError, match="given from 5 to 6 s, the run is from 0 to 2 s"):
        mf.cosimulate("sharp_1971", speed=20, duration=2.0, inputs={"time": [5.0, 6.0], "steer_torque": [1.0, 2.0]})


def with_start(path, start="2", stop="4"):
    """The same archive with another start and stop time of the default experiment."""
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    old, new = b'startTime="0" stopTime="2"', f'startTime="{start}" stopTime="{stop}"'.encode()
    assert old in members["modelDescription.xml"]
    members["modelDescription.xml"] = members["modelDescription.xml"].replace(old, new)
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return path


def test_a_run_begins_at_the_start_time_of_the_default_experiment_or_at_the_one_given(tmp_path):
    path, out = with_start(typed_fmu(tmp_path / "typed.fmu", more=True)), tmp_path / "run.csv"
    run = mf.simulate(path, inputs={"time": [2.0, 4.0], "u": [0.0, 1.0]}, step=0.5)
    assert run["time"] == pytest.approx([2, 2.5, 3, 3.5, 4]) and run["typed.u"] == pytest.approx([0, 0.25, 0.5, 0.75, 1])
    run = mf.simulate(path, step=0.5, duration=1.0, set={"end_time": 2.6})
    assert run["time"] == pytest.approx([2, 2.5, 2.6])
    assert run.notes[0] == "typed asked for the end of the simulation at 2.6 s, before the duration of 1 s"
    assert main(["simulate", str(path), "--start", "3", "--step", "0.5", "--out", str(out)]) == 0
    assert np.loadtxt(out, delimiter=",", skiprows=1)[:, 0] == pytest.approx([3, 3.5, 4])
    assert mf.simulate(path, start=4.0, step=1.0)["time"] == pytest.approx([4, 5, 6, 7, 8, 9])  # nothing is left: 5 s
    with pytest.raises(InputError, match="start = nan s: a start time must be finite, as in 0"):
        mf.simulate(path, start=float("nan"))


@pytest.mark.parametrize(("step", "rows"), [(1e-12, "2,000,000,000,000"), (1e-320, "more than 1e308"), (1e-100, r"2e\+100")])
def test_a_step_that_gives_too_many_rows_is_refused_with_one_that_fits(step, rows, tmp_path, capsys):
    path = typed_fmu(tmp_path / "typed.fmu")
    expected = f"over a duration of 2 s gives {rows} rows of output; expected at most 10,000,000: give a step of 2e-07 s or more"
    with pytest.raises(InputError, match=expected):
        mf.simulate(path, step=step)
    assert main(["simulate", str(path), "--step", "1e-12"]) == 2
    assert "gives 2,000,000,000,000 rows of output" in capsys.readouterr().err


def test_the_step_that_a_refusal_names_is_accepted():
    with pytest.raises(InputError, match=r"give a step of 7\.8e-07 s or more"):
        cosimulation.steps(1e-9, 7.74, 10_000_000)
    assert cosimulation.steps(7.8e-07, 7.74, 10_000_000)[1] <= 10_000_000
    with pytest.raises(InputError, match="expected at most 1,000,000,000"):
        cosimulation.steps(1e-12, 10.0)


@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize(("status", "shown", "advised"), [(2, "fmi2Discard", True), (3, "fmi2Error", False), (9, "9, which the standard does not have", False)])
def test_a_failed_step_names_its_status_and_a_smaller_step_is_advised_for_a_discarded_one_only(status, shown, advised, compiled, tmp_path, monkeypatch):
    monkeypatch.setattr(cosimulation, "_linear", lambda *_: None)
    path = typed_fmu(tmp_path / "typed.fmu", more=True)

    @CFUNCTYPE(c_int, c_void_p, c_double, c_double, c_int)
    def failing(_instance, time, _step, _):
        return status if time > 0.25 else 0

    with FmuSubsystem(path, "one") as one, FmuSubsystem(path, "two") as two:
        one.calls.fmu.dll.fmi2DoStep = failing
        monkeypatch.setattr(one.calls, "step", lambda time, step: status_of(one, failing(None, time, step, 0)))
        with pytest.raises(SimulationError, match=f"one: fmi2DoStep failed with status {shown}") as failed:
            cosimulation.cosimulate({"one": one, "two": two}, 0.1, 1.0, "jacobi", wiring={"two.u": ["one.y"]}, compiled=compiled)
    assert ("take a smaller step than 0.1 s" in str(failed.value)) == advised


def status_of(fmu, status):
    if status > 1:
        fmu.calls.fail("fmi2DoStep", status)


def test_an_fmu_without_a_real_input_is_refused_in_one_line(tmp_path, capsys):
    path, system = typed_fmu(tmp_path / "typed.fmu"), tmp_path / "system.ssp"
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    xml = members["modelDescription.xml"]
    members["modelDescription.xml"] = xml.replace(b'causality="input"><Real start="0" unit="m/s"/>', b'causality="parameter" variability="tunable"><Real start="0" unit="m/s"/>')
    assert members["modelDescription.xml"] != xml
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    with zipfile.ZipFile(system, "w") as archive:
        archive.writestr("SystemStructure.ssd", SYSTEM)
        archive.write(path, "resources/typed.fmu")
    assert main(["cosimulate", "--ssp", str(system), "--out", str(tmp_path / "run.csv")]) == 2
    said = capsys.readouterr().err.splitlines()[-1]
    assert "the FMU source (model typed) has no real input" in said and "expected at least one input of type Real" in said
    assert "or run it by itself with motofmi simulate" in said


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
