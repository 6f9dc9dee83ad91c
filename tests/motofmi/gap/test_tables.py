"""The words and tables of the gap's reports hold what verdict.json holds."""

from motofmi.reports.gap_tables import before_and_after, modes_over_speed, places, statistics_section, verdict_section

TIED = {
    "verdict": "tied", "effects": [], "tied": ["drift", "reflex"], "closest": None, "alternatives": [], "reason": None,
    "criteria": {"further_run_delta_chi2": 10.0}, "candidates": [
        {"name": "drift", "form": "both", "delta_chi2": 60.0, "delta_bic": 52.7, "probability": 0.6},
        {"name": "backlash", "form": "gap", "delta_chi2": 0.0, "delta_bic": -7.3, "probability": 0.0}],
    "complete": False, "explained": None, "ended": None, "disagreement": None,
    "remainder": {"rms": 0.1, "share": 0.02, "unit": "N.m", "nearest": None},
    "next_experiment": {"sentence": "Sweep down.", "expected_delta_chi2": 81.4}, "limitations": ["No held-out run."],
    "where": [{"run": "up", "axis": "order", "order": 3, "from": 3, "to": 3, "unit": "1", "excess": 12.0, "p_value": 1e-9}] * 50,
    "gap": {"before": 2.0, "after": 1.0, "holdout_before": None, "holdout_after": None, "noise_floor": 1.0,
            "rms": {"before": 0.2, "after": 0.1, "holdout_before": None, "holdout_after": None, "noise_floor": 0.1, "unit": "N.m"}},
}  # fmt: skip


def test_a_tie_names_its_members_the_next_experiment_and_the_limits():
    section = verdict_section(TIED)
    text = " ".join(section.paragraphs)
    for word in ("drift, reflex", "Sweep down.", "81", "No held-out run."):
        assert word in text
    assert not any(table.rows for table in section.tables)  # nothing was found, so that no table says what
    (candidates,) = statistics_section(TIED).tables
    assert [row[0] for row in candidates.rows] == ["drift"]  # what gains nothing is left out
    assert dict(zip(candidates.headings, candidates.rows[0], strict=True))["probability"] == "0.600"


def test_what_is_unknown_says_what_is_nearest():
    said = verdict_section(
        {**TIED, "verdict": "unknown", "tied": [], "closest": {"name": "backlash", "delta_bic": 9.0}}
    ).paragraphs
    assert any("backlash" in sentence and "from 0.2 to 0.1 N.m" in sentence for sentence in said)


def test_missing_validation_values_are_left_out():
    rows = {row[0]: row[1:] for row in before_and_after(TIED).rows}
    assert "validation runs, after" not in rows and rows["fitted runs, before"] == ("2.000", "0.2")
    assert len(places(TIED, most=7).rows) == 7


def test_a_p_value_below_every_number_is_not_zero():
    sure = {**TIED, "where": [{**TIED["where"][0], "p_value": 0.0}, *TIED["where"]]}
    assert [row[-1] for row in places(sure, most=2).rows] == ["< 1e-300", "1e-09"]


def test_modes_are_listed_side_by_side():
    modes = {"speed": [10.0, 20.0], "before": {"weave": {"frequency": [0.0, 2.5], "damping_ratio": [None, 0.1]}},
             "after": {"weave": {"frequency": [None, 2.4], "damping_ratio": [None, -0.2]}}}  # fmt: skip
    section = modes_over_speed({**TIED, "modes": modes})
    table = section.tables[0]
    assert table.rows == [
        ("weave", "20", "2.500\u00a0Hz, 0.1000", "2.400\u00a0Hz, -0.2000"),
    ]
    assert table.headings[2:] == ("without", "with, at rest")
    moving = modes_over_speed({**TIED, "modes": {**modes, "in_motion": modes["before"]}})
    assert moving.tables[0].headings[-1] == "with, describing function" and "least-squares" in moving.paragraphs[-1]
    assert "do not change" in modes_over_speed(TIED).paragraphs[0]


def test_the_table_of_a_comparison_has_what_each_model_closes_on_validation_runs():
    """A candidate with the larger delta BIC closes less on validation runs, which decide: the tables say so."""
    candidates = [
        {"name": "coulomb_friction", "form": "coulomb", "delta_chi2": 9.0, "delta_bic": 4.0, "probability": 0.1, "validation": 0.9},
        {"name": "backlash", "form": "gap", "delta_chi2": 50.0, "delta_bic": 45.0, "probability": 0.9, "validation": None},
    ]  # fmt: skip
    models = [
        {"effects": [{"name": "coulomb_friction", "form": "coulomb"}, {"name": "drift", "form": "both"}], "loss_fitted": -3.0,
         "loss_validation": -2.5, "closed": {"share": 0.95, "low": 0.9, "high": 0.99}, "standing": "in the confidence set"},
        {"effects": [], "loss_fitted": 0.0, "loss_validation": None, "closed": None, "standing": "base"},
    ]  # fmt: skip
    section = statistics_section({**TIED, "candidates": candidates, "compared": models})
    alone, together = section.tables
    assert [row[-1] for row in alone.rows] == ["90.0", ""] and "validation" in alone.headings[-1]
    assert "probability" not in alone.headings and alone.rows[0] == ("coulomb_friction", "coulomb", "9.0", "4.0", "90.0")
    assert together.rows == [
        ("coulomb_friction (coulomb) and drift (both)", "-3.00", "-2.50", "95.0", "in the confidence set"),
        ("base", "0.00", "", "", "base"),
    ]
    assert any("that decides" in sentence for sentence in section.paragraphs)
