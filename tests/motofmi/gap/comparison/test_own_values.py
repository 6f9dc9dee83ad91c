"""Fitted and validation runs of two pendulums: nothing is named, and the value that differs is stated."""

import re

import pytest

import motofmi as mf
from tests import as_study
from tests.few_laws import FAMILIES, only_families
from tests.simulators.swings import swing

VALUES = {"J": 0.1, "k": 4.0, "c": 0.003, "T_c": 0.0, "c_2": 0.0}


@pytest.mark.parametrize(("friction", "stiffness"), [as_study(0.0, 2.8), (0.01, 2.8), (0.01, 20.0)])
def test_nothing_is_named_where_the_validation_run_is_of_another_pendulum(monkeypatch, friction, stiffness):
    """With 20 N.m/rad for 4 N.m/rad its frequency is more than twice as high, too far for a fit from the other values."""
    only_families(monkeypatch, (*FAMILIES, "geometric_nonlinearity"))
    values = VALUES | {"T_c": friction}
    runs = [swing(f"from {q} rad", q, 12.0, 40.0, values, noise=1e-3, seed=k) for k, q in enumerate((0.5, 0.3))]
    held = swing("held", 0.4, 12.0, 40.0, values | {"k": stiffness}, noise=1e-3, seed=7)
    result = mf.find_gap(runs, validation=held, component="pendulum").to_dict()
    assert result["verdict"] == "unknown" and not result["effects"]
    values = re.search(r"gravity_stiffness is ([\d.]+) .*? and ([\d.]+) ", result["disagreement"])
    assert [float(value) for value in values.groups()] == pytest.approx([4.0, stiffness], rel=2e-3)  # friction adds 1e-3
    assert result["disagreement"] in result["limitations"]
    amplitudes = re.search(r"The angle has ([\d.]+) and ([\d.]+) rad \(rms\)", result["disagreement"])
    # Two decaying swings from 0.5 and 0.3 rad, and one from 0.4 rad: below their starts over sqrt(2)
    assert all(0.05 < float(rms) < 0.3 for rms in amplitudes.groups())
