"""`plan_experiment` and `motofmi gap --plan`: a result that writes nothing unless asked to, and a figure with its whole label."""

import json

import pytest

import motofmi as mf
from motofmi.cli.main import main
from motofmi.frequency_response.excitation import sweep
from motofmi.reports.plan_figure import plan_figure
from tests.motofmi.json_schemas import check_against_schema


@pytest.fixture(scope="module")
def plan():
    return mf.plan_experiment(
        {"handlebar_inertia": {"value": 0.125, "standard_error": 0.00125}},
        [(0.5, 12), sweep(12, 0.5, 30.0)],
        duration=30.0,
    )


@pytest.mark.slow
def test_a_plan_says_from_which_strength_effects_are_named(plan):
    friction = next(e for e in plan.effects if (e["name"], e["form"]) == ("coulomb_friction", "coulomb"))
    assert friction["unit"] == "N.m" and 0 < friction["noticed_from"] < friction["named_from"]
    assert plan.runs == [{"from": 0.5, "to": 12}, {"excitation": "sweep_12_to_0.5_Hz"}]
    assert "2 runs of 30 s at 2 deg" in repr(plan) and "<table>" in plan._repr_html_()
    assert len(plan.to_dataframe()) == len(plan.effects)


@pytest.mark.slow
def test_the_figure_holds_all_that_it_shows(plan, tmp_path):
    figure = plan_figure(plan.effects)
    figure.draw_without_rendering()
    axes, frame = figure.axes[0], figure.bbox
    for drawn in (axes.xaxis.label, *axes.get_yticklabels(), *axes.texts):
        box = drawn.get_window_extent()
        assert frame.x0 <= box.x0 and box.x1 <= frame.x1 and frame.y0 <= box.y0, drawn.get_text()
    assert plan.save(tmp_path) == [tmp_path / "plan.json", tmp_path / "plan.png"]
    written = json.loads((tmp_path / "plan.json").read_text("utf-8"))
    check_against_schema("plan", written)
    assert written["effects"] == plan.to_dict()["effects"]


@pytest.mark.study
def test_the_command_writes_only_into_the_given_folder(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["gap", "--plan", "--duration", "20", "--sweep", "1:4"]) == 0
    assert not list(tmp_path.iterdir()) and "coulomb_friction" in capsys.readouterr().out
    assert main(["gap", "--plan", "--duration", "20", "--sweep", "1:4", "--out", "plan"]) == 0
    assert f"written: {(tmp_path / 'plan' / 'plan.png').relative_to(tmp_path)}" in capsys.readouterr().out


@pytest.mark.parametrize(("arguments", "message"), [
    ({"rig": "nowhere.json"}, "cannot read nowhere.json"), ({"noise": {"torq": 1.0}}, "did you mean 'torque'"), ({"noise": {"torque": -1.0}}, "cannot be negative"),
])  # fmt: skip
def test_what_cannot_be_planned(arguments, message):
    with pytest.raises(mf.InputError, match=message):
        mf.plan_experiment(**arguments)
