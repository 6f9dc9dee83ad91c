"""Faults that show only while inputs vary or parameters are off their start values, and FMUs that refuse such values."""

import pytest

from fmus.checks.check import Limits, check
from tests import sampled
from tests.fmus.checks import bench
from tests.fmus.checks.bench3 import BENCH3

pytestmark = pytest.mark.slow
LIMITS = Limits(time=20.0)
ME, CS = "ModelExchange", "CoSimulation"
NOT_BACK, OTHER_RUN = "a value is not back at its start after a run", "differs from that of a new instance: y is"
OTHER_VALUES, OTHER_STEPS = "values after a state was restored differ", "steps with inputs that vary after a state was"
TOUCHED = "values of one instance change with the inputs or parameters of another: y is"

# Name -> version, kind, word for faults.h, check, part of the message
FAULTS = {
    "reset keeps a maximum": ("2", CS, "maximum_reset", "varied_reset", OTHER_RUN),
    "reset keeps a maximum, model exchange": ("2", ME, "maximum_reset", "varied_reset", OTHER_RUN),
    "reset keeps a maximum, FMI 3": ("3", CS, "maximum_reset", "varied_reset", OTHER_RUN),
    "reset keeps an input": ("2", CS, "input_reset", "varied_reset", f"{NOT_BACK} and a reset: u is"),
    "reset keeps a parameter": ("2", CS, "parameter_reset", "varied_reset", f"{NOT_BACK} with changed parameters and a reset: k is 2.02, not 2"),
    "reset keeps a parameter, FMI 3": ("3", ME, "parameter_reset", "varied_reset", f"{NOT_BACK} with changed parameters and a reset: A is -0.99, not -1"),
    "restore forgets a maximum": ("2", CS, "maximum_restore", "varied_state", f"{OTHER_STEPS} restored differ from those after it was saved: y is"),
    "restore forgets a maximum, model exchange": ("2", ME, "maximum_restore", "varied_state", OTHER_VALUES),
    "restore forgets a maximum, FMI 3": ("3", CS, "maximum_restore", "varied_state", f"{OTHER_STEPS} restored"),
    "restore forgets an input": ("2", CS, "input_restore", "varied_state", f"{OTHER_VALUES} from those when it was saved: u is"),
    "restore forgets a parameter": ("2", ME, "parameter_restore", "varied_state", f"{OTHER_VALUES} from those when it was saved: k is 2, not 2.02"),
    "restore forgets a parameter, FMI 3": ("3", CS, "parameter_restore", "varied_state", f"{OTHER_VALUES} from those when it was saved: A is -1, not -0.99"),
    "bytes without a maximum": ("2", CS, "maximum_bytes", "varied_state", f"{OTHER_STEPS} read from bytes and restored"),
    "bytes without a maximum, FMI 3": ("3", ME, "maximum_bytes", "varied_state", "after a state was read from bytes and restored"),
    "instances share a maximum": ("2", CS, "shared_maximum", "varied_instances", TOUCHED),
    "instances share a maximum, FMI 3": ("3", CS, "shared_maximum", "varied_instances", TOUCHED),
    "instances share an input": ("2", CS, "shared_input", "varied_instances", TOUCHED),
    "instances share a parameter": ("2", ME, "shared_parameter", "varied_instances", TOUCHED),
}  # fmt: skip


def found_in(libraries, tmp_path, version, kind, word):
    xml, source = (bench.BENCH2, "fmu2.c") if version == "2" else (BENCH3, "fmu3.c")
    path = bench.written(tmp_path / "bench.fmu", bench.only(kind, xml), libraries(source), fault=word)
    return check(path, LIMITS, other_tools=False)


@pytest.mark.parametrize("fault", sampled(FAULTS, 3))
def test_a_fault_that_start_values_do_not_show(fault, libraries, tmp_path):
    version, kind, word, name, message = FAULTS[fault]
    found = found_in(libraries, tmp_path, version, kind, word)
    said = [p for p in found if p.check == name and p.severity == "error" and message in p.message]
    assert said and said[0].call and said[0].section.startswith("FMI"), "\n".join(map(str, found))


def test_an_instance_that_inherits_memory_from_an_earlier_one_is_a_warning(libraries, tmp_path):
    """Two runs differ, as they do for an FMU with random numbers, which the standard permits."""
    (said,) = found_in(libraries, tmp_path, "2", CS, "static_maximum")
    assert (said.check, said.severity) == ("varied_reset", "warning") and "two runs of the same experiment differ" in said.message


def test_a_parameter_without_an_effect_that_a_reset_keeps_is_a_warning(libraries, tmp_path):
    (said,) = found_in(libraries, tmp_path, "2", CS, "unused_reset")
    assert (said.check, said.severity) == ("varied_reset", "warning")
    assert "which changes nothing in the run that follows: g is 0.2525, not 0.25" in said.message


REFUSALS = {
    "discard_varied": "inputs that vary are not accepted (fmi2SetReal returns fmi2Discard",
    "error_varied": "inputs that vary are not accepted (fmi2SetReal returns fmi2Error",
    "warn_varied": "inputs that vary are not accepted (fmi2SetReal returns fmi2Warning), so that resets, restored states",
    "error_changed": "parameters off their start values are not accepted (fmi2SetReal returns fmi2Error",
}


@pytest.mark.parametrize("kind", [CS, ME])
@pytest.mark.parametrize("word", sampled(REFUSALS, 2))
def test_an_fmu_that_refuses_such_values_has_no_fault(word, kind, libraries, tmp_path):
    (said,) = found_in(libraries, tmp_path, "2", kind, word)
    assert said.severity == "note" and said.message.startswith(REFUSALS[word])


def test_outputs_that_are_not_finite_for_other_inputs_are_no_fault_of_the_reset(libraries, tmp_path):
    found = found_in(libraries, tmp_path, "2", CS, "nan_varied")
    (said,) = [p for p in found if p.check.startswith("varied")]
    assert said.severity == "note" and "y is nan at" in said.message


def test_an_fmu_that_warns_of_every_value_is_compared_with_inputs_that_vary(libraries, tmp_path):
    assert found_in(libraries, tmp_path, "2", CS, "warn_always") == []
