"""Correct FMUs of FMI 2 and 3 have no problem: events, arrays, structural parameters, every type, clocks. Faults of FMI 3."""

import re

import pytest

from fmus.checks.check import Limits, check
from tests import sampled
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
ME, CS, SE = "ModelExchange", "CoSimulation", "ScheduledExecution"
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
    "null_binary": (CS, "run", E, "gives a null pointer for the binary value data_out"),
    "no_item": (CS, "values", E, "colour_out is 9, outside its bounds 1 to 2"),
}  # fmt: skip


@pytest.mark.parametrize("fault", sampled(FAULTS, 3))
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
    "two starts for a scalar": ('unit="1" start="0.1"', 'unit="1" start="0.1 0.2"', "arrays", "has 2 start values, but no dimension: a scalar has one"),
    "two texts for a scalar": ('<Start value="grey" />', '<Start value="grey" /><Start value="red" />', "arrays", "has 2 start values, but no dimension"),
    "size zero": ('start="2" min="1"', 'start="0" min="0"', "arrays", "the start size 0, it has to be positive"),
    "clock that is none": ('clocks="33"', 'clocks="36"', "clocks", "names the clock 36, which is no clock"),
    "periodic output clock": ('causality="output" intervalVariability="triggered"', 'causality="output" intervalVariability="countdown"', "clocks", "has to be triggered"),
    "constant without interval": ('causality="input" intervalVariability="countdown"', 'causality="input" intervalVariability="constant"', "clocks", "gives none"),
    "clocks without event mode": (' hasEventMode="true"', "", "clocks", "has the clock trigger, so that hasEventMode has to be true"),
    "output clock with priority": ('name="tick" valueReference="34"', 'name="tick" priority="1" valueReference="34"', "clocks", "an output clock with a priority"),
    "triggered clock with interval": ('intervalVariability="triggered" priority="1"', 'intervalVariability="triggered" intervalDecimal="1" priority="1"', "clocks", "a triggered clock must not have"),
    "counts without resolution": ('intervalDecimal="0.1"', 'intervalDecimal="0.1" intervalCounter="1"', "clocks", "has an interval in counts, but no resolution"),
    "clocked continuous variable": ('name="z" valueReference="36"', 'name="z" clocks="33" valueReference="36"', "clocks", "variability continuous, which has to be discrete or tunable"),
    "previous of an unclocked variable": ('name="z" valueReference="36"', 'name="z" previous="36" valueReference="36"', "clocks", "is no discrete clocked variable"),
    "previous of itself": ('clocks="39"', 'clocks="39" previous="40"', "clocks", "names itself as its previous value"),
    "previous of another type": ('clocks="39"', 'clocks="39" previous="36"', "clocks", "has the previous value z, which is no discrete variable of type Int32"),
    "early return without updates": (' providesIntermediateUpdate="true"', "", "interface", "canReturnEarlyAfterIntermediateUpdate is true, but providesIntermediateUpdate is not"),
    "intermediate integer": ('<Int32 name="ticks"', '<Int32 intermediateUpdate="true" name="ticks"', "interface", "has intermediateUpdate, but variability discrete"),
    "no time": ('causality="independent" variability="continuous"', 'causality="local" variability="continuous"', "attributes", "0 variables are independent"),
    "alias twice": ('<Alias name="shown.y" />', '<Alias name="u" />', "names", "the name 'u' is not unique"),
    "start that is no item": ('declaredType="colours" start="1"', 'declaredType="colours" start="7"', "types", "start 7 is no item of 'colours'"),
}  # fmt: skip


@pytest.mark.parametrize("fault", sampled(XML, 4))
def test_a_faulty_description_of_fmi3_is_reported(fault, tmp_path):
    old, new, name, message = XML[fault]
    assert old in BENCH3
    found = check(bench.written(tmp_path / "faulty.fmu", BENCH3.replace(old, new, 1)), LIMITS, other_tools=False)
    assert [p for p in found if p.check == name and p.severity == "error" and message in p.message], "\n".join(map(str, found))


def test_scheduled_execution_runs_without_preemption(libraries, tmp_path):
    found = check(bench.written(tmp_path / "good.fmu", bench.only(SE, BENCH3), libraries("fmu3.c")), LIMITS, other_tools=False)
    assert [(p.severity, p.where) for p in found] == [("note", SE)] and "without preemption" in found[0].message


def test_scheduled_execution_needs_priorities_and_no_local_clocks(tmp_path):
    xml = bench.only(SE, BENCH3).replace(' priority="0"', "").replace('name="tick" valueReference="34" causality="output"', 'name="tick" valueReference="34" causality="local"')
    found = check(bench.written(tmp_path / "faulty.fmu", xml), LIMITS, other_tools=False)
    said = {p.where: p.message for p in found if p.check == "clocks"}
    assert "without priority" in said["sampler"] and "scheduled execution does not permit" in said["tick"]


@pytest.mark.parametrize(("xml", "section"), [(bench.BENCH2, "FMI 2.0.4, 2.2.8"), (BENCH3, "FMI 3.0, 2.4.8")])
def test_an_absent_list_of_initial_unknowns_is_an_error_also_for_co_simulation(xml, section, tmp_path):
    """The schema makes the list optional; the text says of which variables it consists."""
    xml = re.sub(r"<InitialUnknowns>.*</InitialUnknowns>|<InitialUnknown [^>]*/>", "", bench.only(CS, xml), flags=re.DOTALL)
    found = check(bench.written(tmp_path / "faulty.fmu", xml), LIMITS, other_tools=False)
    said = [p for p in found if p.check == "structure"]
    assert [(p.severity, p.section) for p in said] == [("error", section)] and "does not list" in said[0].message
