"""Trials of FMI 3 one by one: early return, intermediate updates, clocks, model partitions, strings and binary data."""

from xml.etree import ElementTree as Xml

import pytest

from fmus.checks.host import host_folder, library_suffix
from fmus.checks.model import Model
from fmus.checks.trial_process import Place, problems_of
from tests.fmus.checks import bench
from tests.fmus.checks.bench3 import BENCH3

ME, CS, SE = "ModelExchange", "CoSimulation", "ScheduledExecution"
E, W = "error", "warning"


@pytest.fixture
def tried(libraries, tmp_path):
    """The problems that one trial reports of the small FMU, in this process."""

    def problems(name, kind, fault="", xml=BENCH3):
        binary = tmp_path / "binaries" / host_folder("3") / f"bench{library_suffix()}"
        binary.parent.mkdir(parents=True)
        binary.write_bytes(libraries("fmu3.c"))
        (tmp_path / "resources").mkdir()
        if fault:
            (tmp_path / "resources" / "fault.txt").write_text(fault)
        model = Model(Xml.fromstring(bench.only(kind, xml)))
        return list(problems_of(name, kind, Place(tmp_path, tmp_path), model))

    return problems


NAMES = [("early_return", CS), ("intermediate_update", CS), ("clocks", CS), ("clocks", ME), ("partitions", SE), ("load", SE), ("run", SE), ("settable", CS),
         ("values", ME)]  # fmt: skip


@pytest.mark.parametrize(("name", "kind"), NAMES)
def test_the_correct_fmu_has_no_problem(name, kind, tried):
    assert tried(name, kind) == []


FAULTS = {
    "late_update": ("intermediate_update", CS, E, "calls an intermediate update at 1.02 s, outside of the step from 0 s to 0.02 s"),
    "backward_update": ("intermediate_update", CS, E, "calls an intermediate update at -0.001 s, outside of the step"),
    "no_update": ("intermediate_update", CS, W, "calls no intermediate update in 50 steps, which it says that it provides"),
    "early_unasked": ("run", CS, E, "returns early, which was not allowed, after a step from 0 s"),
    "early_before": ("early_return", CS, E, "returns early at 0 s, before the time 0.005 s that was asked for"),
    "deaf": ("early_return", CS, W, "offers an early return, but returned early in none of 5 steps that asked for it"),
    "error_note": ("clocks", ME, E, "fmi3GetBinary returns fmi3Error"),
    "error_partition": ("partitions", SE, E, "fmi3ActivateModelPartition returns fmi3Error"),
    "stays_locked": ("partitions", SE, E, "the partition of sampler ends with preemption locked 1 times"),
    "negative_interval": ("partitions", SE, E, "gives the interval -1 s for clock timer"),
    "unsteady_text": ("run", CS, E, "word_out is not UTF-8 at 0.02 s"),
    "long_data": ("values", CS, E, "data_out has 5 bytes, its maxSize is 4"),
    "other_data": ("values", CS, W, "data_in is '00' after initialisation, its start in the description is '64617461'"),
    "far_time": ("run", CS, W, "the FMU's own time is 7 s at the communication point 2 s, more than a step away"),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_reported(fault, tried):
    name, kind, severity, message = FAULTS[fault]
    found = tried(name, kind, fault)
    said = [p for p in found if p.severity == severity and message in p.message]
    assert said and said[0].section.startswith("FMI 3.0"), "\n".join(map(str, found))


def test_an_early_return_that_the_description_does_not_announce_is_reported(tried):
    xml = BENCH3.replace(' mightReturnEarlyFromDoStep="true"', "")
    assert [p.message for p in tried("early_return", CS, xml=xml)] == ["returns early at 0.693 s, which mightReturnEarlyFromDoStep does not say"]


def test_data_that_a_reset_forgets_is_reported(tried):
    assert "word_out is b'new'" in tried("reset", CS, "keeps_text")[0].message
