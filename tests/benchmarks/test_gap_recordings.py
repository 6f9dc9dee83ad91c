"""The benchmark of recordings: what is skipped, and how a verdict is judged."""

import numpy as np
import pytest

from benchmarks import gap_recordings
from benchmarks._recordings import SOURCES, Published, Source


def quiet(items, _):
    return items


def said(name="coulomb_friction", value=0.55, error=0.03, **changed):
    parameters = {"friction_torque": {"value": value, "standard_error": error, "unit": "N.m"}}
    effects = [{"name": name, "form": "coulomb", "parameters": parameters}]
    return {"verdict": "named", "complete": False, "effects": effects, "tied": [], "explained": None, "remainder": None} | changed


SOURCE = Source("a/b", ["run.csv"], ["other.csv"], frozenset({"coulomb_friction"}), "driven_joint",
                published=Published("coulomb_friction.friction_torque", 0.5, 0.6))  # fmt: skip


def test_recordings_that_are_not_there_are_skipped_with_the_command_that_gets_them(tmp_path):
    found = gap_recordings.run(quiet, tmp_path)
    assert found["recordings"] == {} and set(found["skipped"]) == set(SOURCES)
    assert all("git clone https://github.com/" in reason for reason in found["skipped"].values())


def test_the_known_effect_and_the_published_value_judge_a_verdict():
    assert gap_recordings.row(SOURCE, said())["right"] and gap_recordings.row(SOURCE, said())["value"]["within"]
    assert not gap_recordings.row(SOURCE, said(name="drift"))["right"]
    assert not gap_recordings.row(SOURCE, said(effects=[], verdict="unknown"))["right"]
    # 0.75 - 1.96 * 0.03 is above the published 0.6
    assert not gap_recordings.row(SOURCE, said(value=0.75))["value"]["within"]


def test_parts_and_factors_make_the_files_of_a_command(tmp_path):
    time = np.arange(300) / 100
    rows = np.column_stack([time, np.sin(time), np.cos(time)])
    np.savetxt(tmp_path / "run.csv", rows, delimiter=",", header="time [s],current [A],angle [rad]", comments="")
    source = Source("a/b", ["run.csv"], [], frozenset(), "driven_joint", columns="time [s],torque [N.m],angle [rad]",
                    factors={1: 3.03}, parts=(slice(0, 200), slice(200, 300)))  # fmt: skip
    (tmp_path / "made").mkdir()
    arguments = source.command(tmp_path, tmp_path / "made")
    fitted, validation = (np.loadtxt(arguments[i], delimiter=",", skiprows=1) for i in (0, 2))
    assert fitted == pytest.approx(rows[:200] * [1, 3.03, 1]) and len(validation) == 100
