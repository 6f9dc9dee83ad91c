"""The thresholds of a verdict are those that it was given, and stand in verdict.json."""

import ast
from dataclasses import asdict, fields
from itertools import pairwise

import numpy as np
import pytest

from motofmi.gap.criteria import Criteria
from motofmi.gap.localisation.eigenvalue_places import cells
from motofmi.gap.models.eigenvalue_model import EigenvalueModel
from motofmi.gap.preprocessing.eigenvalues import read_eigenvalues
from motofmi.gap.selection.model_selection import select_model
from motofmi.gap.verdict import as_result
from motofmi.workflows.gap.vehicle import vehicle_effects, vehicle_experiment, with_mode_names
from tests import ROOT
from tests.simulators.hidden_vehicle import SHARP, spectrum, write
from vehicle_fmu import motorcycles


@pytest.fixture(scope="module")
def verdict_with(tmp_path_factory):
    """The verdict on Sharp's motorcycle with a front frame that twists, by the criteria that are given."""
    file, speeds = tmp_path_factory.mktemp("criteria") / "eigenvalues.csv", np.arange(8.0, 57.0, 6.0)
    write(file, spectrum(SHARP, speeds, {"compliance": 3e-5, "axis": 0.4}), speeds, np.random.default_rng(8), 0.01)
    vehicle = motorcycles.load("sharp_1971")
    experiment = vehicle_experiment(vehicle)
    library = [e for e in vehicle_effects(vehicle, linear=True) if e.family in ("frame_compliance", "rider_lean")]
    return lambda criteria: select_model(
        EigenvalueModel(experiment), [with_mode_names(read_eigenvalues(file), experiment)], library, criteria=criteria
    )


def test_every_threshold_says_what_it_decides():
    """The string below each field, with a unit in brackets."""
    body = ast.parse((ROOT / "motofmi" / "gap" / "criteria.py").read_text("utf-8")).body[-1].body
    strings = {node.target.id: after.value.value for node, after in pairwise(body)
               if isinstance(node, ast.AnnAssign) and isinstance(after, ast.Expr)}  # fmt: skip
    assert list(strings) == [f.name for f in fields(Criteria)]
    assert [name for name, text in strings.items() if "[1]" not in text or len(text) < 60] == []


@pytest.mark.study
def test_a_first_effect_must_gain_what_the_criteria_ask_for(verdict_with):
    verdict = verdict_with(Criteria())
    assert (verdict.verdict, [c.family for c in verdict.effects]) == ("named", ["frame_compliance"])
    gain = verdict.effects[0].delta_bic
    assert verdict_with(Criteria(first_effect_delta_bic=gain + 1)).verdict in ("none", "unknown")


@pytest.mark.study
def test_what_is_adequate_is_asked_of_the_criteria_which_are_in_the_result(verdict_with):
    strict = Criteria(adequate_reduced_chi2=0.0, scatter_deviations=-1e3, unspecified_form_closed_share=1.0)
    verdict = verdict_with(strict)
    assert verdict.verdict == "unknown"
    assert as_result(verdict, "1/s", "given", cells)["criteria"] == asdict(strict)
