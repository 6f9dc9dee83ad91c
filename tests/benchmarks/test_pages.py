"""Studies behind pages of the documentation, in small."""

import pytest

from benchmarks import (
    full_rider_questions,
    gap_components,
    hosts,
    magnetorheological_damper,
    steer_by_wire_bicycle,
    tutorials,
)


def test_a_tutorial_is_its_words_and_its_cells():
    found = {path.stem: tutorials.content(path) for path in tutorials.pages()}
    assert {"test_rig", "simulator", "recording_to_rider"} <= set(found)
    text, cells = found["test_rig"]
    assert "import motofmi as mf" in cells[0] and "jupytext" not in text
    assert any(cell.startswith("%%bash") for cell in found["simulator"][1])


def test_the_tutorial_of_the_rig_imports_nothing_of_the_inside():
    """What a newcomer copies: motofmi itself, and packages of others."""
    cells = next(tutorials.content(path)[1] for path in tutorials.pages() if path.stem == "test_rig")
    lines = [line.strip() for cell in cells for line in cell.splitlines() if line.strip().startswith(("import ", "from "))]
    assert lines == ["import motofmi as mf", "import numpy as np", "from scipy.integrate import solve_ivp"]


@pytest.mark.slow
def test_the_inertia_of_the_limbs_grows_with_the_square_of_the_angle():
    found = full_rider_questions.posture()
    # The next term of an even function is of fourth order in the angle: 0.14 rad, and arms that are nearly straight.
    assert found["8"] / found["4"] == pytest.approx(4, rel=0.1)


def test_without_recordings_the_studies_of_damper_and_bicycle_are_skipped(tmp_path):
    assert "--data" in magnetorheological_damper.run(list, data=tmp_path)["skipped"]
    assert "git clone" in steer_by_wire_bicycle.run(list, data=tmp_path)["skipped"]


def test_errors_of_hosts_are_kept_as_shares_and_in_their_unit():
    found = hosts.plain({"a": {"exact": 3 + 4j, "error": 0.3 + 0.4j}, "b": {"exact": 1.0 + 0j, "error": -0.2 + 0j}})
    assert found["a"] == {"real": 3.0, "imag": 4.0, "error": pytest.approx(0.5), "share": pytest.approx(0.1)}
    assert found["largest_share"] == pytest.approx(0.2)


def test_a_value_in_a_table_has_the_digits_of_its_error():
    value = {"value": 0.119876, "standard_error": 0.0014, "unit": "m", "true": 0.12}
    row = {"component": "tanks", "hidden": "overflow", "verdict": "named", "effects": [{"name": "overflow"}],
           "values": {"threshold": value}, "cpu_seconds": 14.6}  # fmt: skip
    table = gap_components.table({"components": [row]})
    assert "| tanks | overflow | `overflow` | threshold 0.1199 +- 0.0014 m (0.12) | 15 |" in table
