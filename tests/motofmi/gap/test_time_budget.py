"""A time budget ends the search with a verdict, a report and the sentence on what was not done; without one nothing
changes."""

import json
import re
import time
from html import unescape

import pytest

from fmus.effects.placement import laws_at
from fmus.support.deadline import deadline, time_is_up
from fmus.support.errors import InputError
from fmus.support.parallel import parallel_map
from motofmi.cli.main import main
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.selection import model_selection
from motofmi.gap.selection.any_component import investigate
from motofmi.gap.selection.within_time import CONCLUDING_SHARE
from motofmi.recordings.reading import write_recording
from motofmi.workflows.components import component
from motofmi.workflows.gap.find_gap import find_gap
from tests import as_study
from tests.motofmi.json_schemas import check_against_schema
from tests.simulators.hidden_joint import joint_run

LIBRARY = (("coulomb_friction", "coulomb"), ("coulomb_friction", "stribeck"), ("hardening_stiffness", "cubic"))
REPORT = 60.0  # s for reading, the evaluations that are under way, model, FMU and report; 8 s on two quiet cores


def runs(folder, hidden):
    names = []
    for seed, name in ((1, "fitted"), (2, "validation")):
        write_recording(joint_run(hidden, seed=seed, name=name), folder / f"{name}.csv")
        names.append(str(folder / f"{name}.csv"))
    return names


@pytest.mark.parametrize("start_method", ["fork", "loky"])
def test_a_deadline_holds_in_worker_processes_and_ends_with_its_context(monkeypatch, start_method):
    monkeypatch.setenv("MOTOFMI_START_METHOD", start_method)
    with deadline(1e-9):
        assert parallel_map(lambda _: time_is_up(), [1, 2], "asking", workers=2) == [True, True]
        with deadline(100.0):
            assert parallel_map(lambda _: time_is_up(), [1, 2], "asking", workers=2) == [False, False]
        assert time_is_up()
    assert not time_is_up()


@pytest.mark.parametrize("given", [0, -3.0, float("nan"), float("inf")])
def test_a_time_that_is_no_budget_is_refused_at_once(given, capsys):
    with pytest.raises(InputError, match=r"time is (0|-3|nan|inf): expected a number of seconds above 0, as in 60"):
        find_gap(["missing.csv"], time=given)
    assert main(["gap", "missing.csv", "--component", "driven_joint", "--time", str(given)]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


@pytest.mark.slow
@pytest.mark.parametrize("seconds", [1e-3, as_study(4.0)])
def test_a_budget_that_is_too_short_for_all_ends_with_verdict_report_and_limitation(tmp_path, seconds):
    fitted, validation = runs(tmp_path, {"friction": 0.3})
    began = time.monotonic()
    out = tmp_path / "out"
    words = ["gap", fitted, "--component", "driven_joint", "--holdout", validation, "--time", f"{seconds:g}"]
    assert main([*words, "--out", str(out)]) == 0
    assert time.monotonic() - began < (1 + CONCLUDING_SHARE) * seconds + REPORT
    said = json.loads((out / "verdict.json").read_text("utf-8"))
    check_against_schema("verdict", said)
    assert said["limitations"][0].startswith(f"The time budget of {seconds:g} s ended during the stage '")
    assert (said["verdict"], said["effects"]) == ("unknown", []) and said["gap"]["holdout_before"] > 0
    assert said["report"] == "report.html" and (out / said["model"]).exists()
    shown = unescape(re.sub("<[^>]+>", "", (out / "report.html").read_text("utf-8")))  # terms are marked in the page
    assert said["limitations"][0].split(":")[0] in shown


def joint(hidden):
    """Experiment, runs and a library of three effects for `investigate`."""
    recording, driven_joint = joint_run(hidden, seed=5, duration=4.0), component("driven_joint")
    experiment = input_output_experiment(driven_joint, list(recording.columns))
    library = [e for e in laws_at(driven_joint) if (e.family, e.form) in LIBRARY]
    return {"experiment": experiment, "runs": [prepare_sampled_run(recording, experiment)], "library": library}


def ended_during(name, monkeypatch):
    """The investigation of friction whose time is up once the named function of model selection is called."""
    asked = joint({"friction": 0.3})
    begun, clock, ahead = getattr(model_selection, name), time.monotonic, [0.0]

    def late(*arguments, **options):
        ahead[0] = 1e6
        return begun(*arguments, **options)

    monkeypatch.setattr(model_selection, name, late)
    monkeypatch.setattr("fmus.support.deadline.monotonic", lambda: clock() + ahead[0])
    with deadline(1000.0):
        return investigate(**asked, given={"angle": 2e-3}).verdict


@pytest.mark.slow
def test_what_is_known_when_time_ends_during_pairs_is_the_verdict_of_single_effects(monkeypatch):
    verdict = ended_during("pairs_of", monkeypatch)
    assert "ended during the stage 'pairs of effects': pairs of effects were not compared" in verdict.ended
    assert verdict.verdict in ("named", "tied")
    assert "coulomb_friction" in [c.family for c in (*verdict.effects, *verdict.tied)]


@pytest.mark.slow
def test_before_all_single_effects_are_fitted_nothing_is_named(monkeypatch):
    verdict = ended_during("search_candidates", monkeypatch)
    assert "single effects" in verdict.ended and (verdict.verdict, verdict.effects) == ("unknown", [])


@pytest.mark.study
def test_a_budget_that_is_not_used_up_changes_nothing():
    asked = joint({"friction": 0.3})
    with deadline(1e6):
        limited = investigate(**asked)
    free = investigate(**asked)
    assert repr(limited) == repr(free) and limited.verdict.ended == ""
    assert [(c.family, c.delta_bic) for c in limited.verdict.candidates] == [
        (c.family, c.delta_bic) for c in free.verdict.candidates
    ]
