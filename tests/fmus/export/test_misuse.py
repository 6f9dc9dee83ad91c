"""Random calls out of order and with wrong arguments, under the sanitisers and valgrind: nothing may be reported.

Here are some thousands per component; `python -m benchmarks` has the study with a million (benchmarks/fmu_misuse.py).
"""

import shutil

import pytest

from benchmarks.fmu_misuse import calls_under, compiled_misuse, have_sanitisers
from fmus.export.compilers import host_compiler
from tests import as_study
from tests.importer import COMPONENTS

pytestmark = pytest.mark.skipif(host_compiler() is None, reason="no C compiler on this machine")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "fmi"), [("rider", 2), ("oscillator", 3), as_study("motorcycle", 3), as_study("progressive", 2), as_study("oscillator", 2)]
)
def test_random_calls_under_the_sanitisers(name, fmi, tmp_path):
    if not have_sanitisers():
        pytest.skip("the compiler has no address and undefined-behaviour sanitisers")
    program = compiled_misuse(COMPONENTS[name](), fmi, tmp_path, sanitised=True)
    found = calls_under([program.path], program, 20_000, seed=1)
    # All happen, so that the calls reach the inside of the functions and their refusals.
    assert found["report"] == "" and min(found["ok"], found["error"]) > 2000 and found["steps"] > 1000


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
def test_no_leak_under_valgrind(fmi, tmp_path):
    if shutil.which("valgrind") is None:
        pytest.skip("valgrind is not installed")
    program = compiled_misuse(COMPONENTS["oscillator"](), fmi, tmp_path, sanitised=False)
    found = calls_under(
        ["valgrind", "--quiet", "--error-exitcode=9", "--leak-check=full", program.path], program, 3000, seed=2
    )
    assert found["report"] == "" and found["ok"] > 300
