"""Scenarios say themselves in which report they appear: a new file in the folder is all that a new one takes."""

import inspect

import pytest

import motofmi.scenarios
from fmus.support.errors import InputError
from motofmi.reports.charts import Axis, Chart, Curve, Panel
from motofmi.reports.report import Section
from motofmi.scenarios import the_full_rider
from motofmi.workflows.scenarios import Answered, answered, scenario, scenario_names, scenarios_of

# They are no questions: one writes the report of those on the full rider, one the pages of the components.
WRITERS = {"the_full_rider", "what_is_in_each_component"}
NEW = """
from motofmi.reports.report import Section
from motofmi.workflows.scenarios import InReport

REPORT = InReport("tour", 35, "a new question")


def run(seed: int = 0) -> int:
    return 2 * seed


def section(answer: int) -> Section:
    return Section("New?", [f"The answer is {answer}."])
"""


def test_every_question_has_a_run_and_a_section():
    for name in set(scenario_names()) - WRITERS:
        module = scenario(name)
        assert inspect.signature(module.run).return_annotation is not inspect.Signature.empty, name
        assert callable(module.section) and module.__doc__, name


def test_reports_have_an_order():
    assert next(iter(scenarios_of("tour"))) == "what_are_weave_wobble_and_capsize" and len(scenarios_of("tour")) == 7
    assert list(scenarios_of("full rider"))[-1] == "what_does_lean_do_to_weave" and len(scenarios_of("full rider")) == 5
    assert all(scenario(name).REPORT.step for report in ("tour", "full rider") for name in scenarios_of(report))


def test_the_report_of_the_full_rider_says_first_what_was_asked_and_links_its_pictures(tmp_path):
    chart = Chart([Panel(Axis("speed", "m/s"), Axis("frequency", "Hz"), [Curve("weave", [1.0, 2.0], [3.0, 4.0])])])
    found = [
        Answered(name, "a step", Section(f"{name}?", [f"The answer is {name}.", "And why."], [(chart, "A curve.")]), 0.1)
        for name in ("one", "two")
    ]
    files = [the_full_rider.picture(each, tmp_path) for each in found]
    written = the_full_rider.report(found, files)
    assert (written.asked, written.lead, len(written.figures)) == (the_full_rider.ASKED, "The answer is two.", 1)
    page = written.html(tmp_path)
    assert all(f'href="{name}.png"' in page and (tmp_path / f"{name}.png").stat().st_size > 1000 for name in ("one", "two"))
    assert page.index("The answer is two.") < page.index("All answers") < page.index("And why.")


def test_a_new_scenario_is_one_file(tmp_path, monkeypatch):
    (tmp_path / "is_this_new.py").write_text(NEW.replace('"tour"', '"only here"'))
    (tmp_path / "is_this_in_the_tour.py").write_text(NEW)
    monkeypatch.setattr(motofmi.scenarios, "__path__", [*motofmi.scenarios.__path__, str(tmp_path)])
    assert "is_this_new" in scenario_names()
    assert list(scenarios_of("tour"))[4] == "is_this_in_the_tour"
    (answer,) = answered("only here", seed=21, out=tmp_path)
    assert (answer.step, answer.section.paragraphs) == ("a new question", ["The answer is 42."])


def test_a_wrong_name_is_answered_with_the_nearest():
    with pytest.raises(InputError, match="did you mean 'is_a_rider_a_damper'"):
        scenario("is_a_rider_a_dampr")


def test_scenarios_do_not_use_the_command_line():
    for name in scenario_names():
        assert "motofmi.cli" not in inspect.getsource(scenario(name)), name
