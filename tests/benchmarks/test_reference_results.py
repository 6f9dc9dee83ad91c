"""The comparison of kept results finds what differs, and nothing else."""

import json

import pytest

pytest.importorskip("numba", reason="the simulator of the hidden effects is compiled by numba")
from benchmarks.reference_results import CASES, KEPT, compared, flattened

RESULT = {"verdict": "named", "speed": [1.0, 2.0], "effects": [{"name": "hysteresis", "size": 3.0}], "file": "out.csv"}


def leaves(**changed):
    return {"case": dict(flattened({**RESULT, **changed}))}


def test_rounding_and_places_of_files_are_no_difference():
    assert compared(leaves(speed=[1.0, 2.0 + 1e-9], file="other.csv"), leaves()) == {}


@pytest.mark.parametrize("changed, key", [
    ({"speed": [1.0, 2.0 + 1e-8]}, "speed"), ({"speed": [1.0]}, "speed"), ({"verdict": "tied"}, "verdict"),
    ({"effects": [{"name": "drift", "size": 3.0}]}, "effects.0.name"), ({"effects": []}, "effects.0.name"),
])  # fmt: skip
def test_other_differences_are_found(changed, key):
    assert key in compared(leaves(**changed), leaves())["case"]


def test_every_input_has_a_kept_result_without_an_error():
    kept = json.loads(KEPT.read_text("utf-8"))
    assert kept.keys() == CASES.keys() and len(kept) == 40
    assert not [name for name, result in kept.items() if "error" in result]
