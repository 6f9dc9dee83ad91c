"""Correct FMUs of FMI 2 and 3 have no problem: events, arrays, structural parameters, every type, clocks. Faults of FMI 3."""

import pytest

from fmus.checks.check import Limits, check
from tests.fmus.checks import bench
from tests.fmus.checks.bench3 import BENCH3

pytestmark = pytest.mark.slow
LIMITS = Limits(time=20.0)


@pytest.mark.parametrize(("name", "xml", "source", "flags"), [
    ("bench", bench.BENCH2, "fmu2.c", ()), ("ball", bench.BALL, "fmu2.c", ("-DBALL",)), ("bench", BENCH3, "fmu3.c", ()),
])  # fmt: skip
def test_a_correct_fmu_has_no_problem(name, xml, source, flags, libraries, tmp_path):
    path = bench.written(tmp_path / "good.fmu", xml, libraries(source, *flags), name)
    # fmpy takes aliases and output clocks of FMI 3 for initial unknowns.
    assert check(path, LIMITS, other_tools="fmiVersion=\"2" in xml) == []


E = "error"
ME, CS = "ModelExchange", "CoSimulation"
FAULTS = {
    "wrong_element": (ME, "derivatives", E, "d y / d u is 1.5, differences give 1"),
    "wrong_adjoint": (ME, "adjoint", E, "the adjoint derivative d "),
    "count_states": (ME, "continuous", E, "the binary has 5 continuous states, the description 2"),
    "count_indicators": (ME, "continuous", E, "the binary has 2 event indicators, the description 1"),
    "refuse_size": (CS, "structural", E, "fmi3SetUInt64 returns fmi3Error"),
    "forget_size": (ME, "structural", E, "fmi3SetFloat64 returns fmi3Error"),
    "no_event_mode": (CS, "load", E, "returns no instance with eventModeUsed = true"),
    "last_time": (CS, "run", E, "reports the last successful time"),
    "error_clock": (ME, "clocks", E, "fmi3GetClock returns fmi3Error"),
    "error_set_clock": (CS, "clocks", E, "fmi3SetClock returns fmi3Error"),
    "negative_interval": (ME, "clocks", E, "gives the interval -1 s for clock timer"),
    "null_binary": (CS, "values", E, "gives a null pointer for binary data"),
    "no_item": (CS, "values", E, "colour_out is 9, outside its bounds 1 to 2"),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_of_fmi3_is_reported(fault, libraries, tmp_path):
    kind, name, severity, message = FAULTS[fault]
    found = check(bench.written(tmp_path / "faulty.fmu", bench.only(kind, BENCH3), libraries("fmu3.c"), fault=fault), LIMITS, other_tools=False)
    said = [p for p in found if p.check == name and p.severity == severity and message in p.message]
    assert said and said[0].section.startswith("FMI 3.0"), "\n".join(map(str, found))


XML = {
    "reference twice": ('name="truth_out" valueReference="26"', 'name="truth_out" valueReference="25"', "references", "has the value reference 25 of truth_in"),
    "dimension of nothing": ('start="0 1"><Dimension valueReference="1" />', 'start="0 1"><Dimension valueReference="99" />', "arrays", "99, which no variable has"),
    "dimension of a real": ('start="0 1"><Dimension valueReference="1" />', 'start="0 1"><Dimension valueReference="36" />', "arrays", "neither a structural parameter nor a constant"),
    "three starts for two": ('start="0 1"', 'start="0 1 2"', "arrays", "has 3 start values for 2 elements"),
    "size zero": ('start="2" min="1"', 'start="0" min="0"', "arrays", "the start size 0, it has to be positive"),
    "clock that is none": ('clocks="33"', 'clocks="36"', "clocks", "names the clock 36, which is no clock"),
    "periodic output clock": ('causality="output" intervalVariability="triggered"', 'causality="output" intervalVariability="countdown"', "clocks", "has to be triggered"),
    "constant without interval": ('causality="input" intervalVariability="countdown"', 'causality="input" intervalVariability="constant"', "clocks", "gives none"),
    "no time": ('causality="independent" variability="continuous"', 'causality="local" variability="continuous"', "attributes", "0 variables are independent"),
    "alias twice": ('<Alias name="shown.y" />', '<Alias name="u" />', "names", "the name 'u' is not unique"),
    "start that is no item": ('declaredType="colours" start="1"', 'declaredType="colours" start="7"', "types", "start 7 is no item of 'colours'"),
}  # fmt: skip


@pytest.mark.parametrize("fault", XML)
def test_a_faulty_description_of_fmi3_is_reported(fault, tmp_path):
    old, new, name, message = XML[fault]
    assert old in BENCH3
    found = check(bench.written(tmp_path / "faulty.fmu", BENCH3.replace(old, new, 1)), LIMITS, other_tools=False)
    assert [p for p in found if p.check == name and p.severity == "error" and message in p.message], "\n".join(map(str, found))


def test_scheduled_execution_is_said_to_be_not_run(libraries, tmp_path):
    xml = BENCH3.replace("<UnitDefinitions>", '<ScheduledExecution modelIdentifier="bench" /><UnitDefinitions>', 1)
    found = check(bench.written(tmp_path / "good.fmu", bench.only(ME, xml), libraries("fmu3.c")), LIMITS, other_tools=False)
    assert [(p.severity, p.where) for p in found] == [("note", "ScheduledExecution")] and "is not run" in found[0].message
