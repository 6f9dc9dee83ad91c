"""The first lines of a report never contradict each other or the numbers, for any contents of `verdict.json`."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from fmus.effects.damping import CoulombFriction
from motofmi.gap import verdict
from motofmi.gap.alternatives import with_errors
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.fit_result import standard_errors
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.selection.any_component import Investigation
from motofmi.gap.selection.result import Verdict
from motofmi.reports.gap_before_after import label_of_best
from motofmi.reports.gap_summary import answer, bars, headline, laws, nearest, next_run, value_text
from motofmi.workflows.components import component, ships
from motofmi.workflows.gap.limitations import limitations_of
from tests.simulators.hidden_joint import joint_run

NAMES = ("coulomb_friction", "hysteresis", "drift")


def drawn(rng):
    """Contents with every combination of verdict, misfit before and after, share, and end of the search."""
    kind = str(rng.choice(["named", "tied", "none", "unknown"]))
    before, after, held_before, held_after = 10.0 ** rng.uniform(-4, 2, 4)
    held, share = rng.random() < 0.7, rng.uniform(-0.5, 1.0)
    parameters = {"friction_torque": {"value": 0.5, "standard_error": 0.01, "unit": "N.m"}}
    effect = {"name": NAMES[0], "form": str(rng.choice(["coulomb", "open"])), "element": "spring", "sentence": "Dry friction.",
              "equations": ["force += friction_torque tanh(rate/sliding_rate)"] * int(rng.integers(2)), "parameters": parameters}  # fmt: skip
    return {
        "verdict": kind, "effects": [effect] if kind == "named" else [], "tied": list(NAMES[:2]) if kind == "tied" else [],
        "closest": {"name": NAMES[0], "delta_bic": 5.0} if kind == "unknown" and rng.random() < 0.8 else None,
        "reason": "No effect is named: few blocks." if kind == "unknown" and rng.random() < 0.5 else None,
        "alternatives": [{"effects": [effect], "closed": share if rng.random() < 0.5 else None}] * int(rng.integers(8))
        if kind == "tied" else [{"effects": [effect], "closed": share}] * (kind in ("unknown", "none") and rng.random() < 0.5),
        "complete": bool(rng.random() < 0.5) and kind in ("named", "none"),
        "ended": "The time budget of 60 s ended." if rng.random() < 0.3 else None,
        "explained": {"share": share, "low": share - 0.1, "high": share + 0.1} if held and kind != "none" else None,
        "remainder": {"rms": float(held_after if held else after), "share": float(rng.uniform(0, 1)) * 10.0 ** -int(rng.integers(4)), "unit": "rad", "nearest": None},
        "criteria": {"tolerance": 0.01},
        "disagreement": None,
        "gap": {"rms": {"before": before, "after": after, "holdout_before": held_before if held else None,
                        "holdout_after": held_after if held else None, "unit": "rad"}},
    }  # fmt: skip


@pytest.mark.parametrize("seed", range(300))
def test_no_line_contradicts_the_numbers(seed):
    result = drawn(np.random.default_rng(seed))
    lines = [headline(result), *laws(result), *nearest(result), *bars(result)]
    text = "\n".join(lines)
    assert lines[0].startswith(result["verdict"])
    for a, b in re.findall(r"from (\S+) to (\S+) rad", text):
        assert float(b) <= float(a)
    for share in re.findall(r"closes? (-?[\d.]+)%", text):
        assert float(share) >= 0
    if result["verdict"] == "unknown":  # an effect that closes most of the misfit is no absence of effects
        assert "no effect of the library" not in text and "nothing in the library" not in text
        assert ("ended" in lines[0]) == bool(result["ended"])
    if result["verdict"] == "none" and not result["complete"]:
        assert "noise" not in lines[0]
        assert ("tolerance" in lines[0]) == (result["remainder"]["share"] <= result["criteria"]["tolerance"])
    if result["verdict"] == "none":  # what is within the tolerance is shown with its share, and not named
        assert len(nearest(result)) == len(result["alternatives"])
        assert all(line.startswith("not named") and "closes" in line for line in nearest(result))
    assert (f"{result['remainder']['rms']:.3g} rad (rms) is left" in lines[0])


def test_an_effect_at_one_of_several_elements_is_named_with_the_element():
    result = next(r for r in (drawn(np.random.default_rng(seed)) for seed in range(50)) if r["verdict"] == "named")
    [effect] = result["effects"]
    assert headline(result).startswith("named: coulomb_friction;")
    result["effects"] = [effect | {"form": "coulomb_elbow", "element": "elbow"}]
    assert headline(result).startswith("named: coulomb_friction (elbow);")
    assert laws(result)[0].startswith("coulomb_friction (elbow): ")
    result["effects"] = [effect | {"form": "coulomb_shoulder_and_elbow", "element": "shoulder and elbow"}]
    assert headline(result).startswith("named: coulomb_friction (shoulder and elbow);")


def test_the_share_of_a_pair_is_not_said_of_the_effect_that_several_pairs_have_in_common():
    drawings = (drawn(np.random.default_rng(seed)) for seed in range(300))
    result = next(r for r in drawings if r["verdict"] == "named" and (r["explained"] or {"share": 0})["share"] > 0)
    assert "with " not in headline(result)
    pairs = [{"effects": [*result["effects"], {"name": name}], "closed": 0.9} for name in ("asymmetry", "backlash")]
    text = headline(result | {"alternatives": pairs})
    assert "; with asymmetry, one of several possible second effects, it closes" in text


@pytest.mark.parametrize("seed", range(50))
def test_the_longer_bar_is_the_larger_misfit(seed):
    result = drawn(np.random.default_rng(seed))
    lengths = [line.count("#") for line in bars(result)]
    rms = result["gap"]["rms"]
    pair = ("before", "after") if rms["holdout_before"] is None else ("holdout_before", "holdout_after")
    before, after = (rms[key] for key in pair)
    assert lengths[0] >= lengths[1] if before >= after else lengths[1] >= lengths[0]


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [(250000.47, 8.7, "250000.5"), (-0.0123456, 2e-7, "-0.0123456"), (20.61, 0.42, "20.61"), (1234.5, 800.0, "1234"),
     (9.99996, 0.01, "10"), (0.0, 0.1, "0"), (0.5, None, "0.5"), (1 / 3, 1e-15, "0.3333333333"), (2.0, 0.0, "2")],
)  # fmt: skip
def test_a_value_has_the_digits_that_its_error_determines(value, error, text):
    assert value_text({"value": value, "standard_error": error}) == text


def test_an_equation_has_values_errors_and_units():
    result = drawn(np.random.default_rng(0)) | {"effects": [
        {"name": "coulomb_friction", "form": "coulomb", "element": "spring", "sentence": "Dry friction.",
         "equations": ["force += friction_torque tanh(rate/sliding_rate)"],
         "parameters": {"friction_torque": {"value": 20.61, "standard_error": 0.42, "unit": "N"}}}]}  # fmt: skip
    assert laws(result) == [
        "coulomb_friction: force += friction_torque tanh(rate/sliding_rate), friction_torque = 20.61 +- 0.42 N"
    ]


@pytest.mark.parametrize("fitted", [0.22, 1.0, 3.0])
@pytest.mark.parametrize("validation", [None, 0.9, 5.0])
def test_no_form_is_called_inadequate_beside_a_reduced_chi_square_of_noise(fitted, validation):
    effect = SimpleNamespace(family="hysteresis")
    criteria = Criteria()
    best = SimpleNamespace(freedom=1000, reduced=fitted, runs=[], model=None, count=1000)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(verdict, "reduced_by_noise", lambda found, criteria: 1.12)
        said = verdict._unspecified_form(
            SimpleNamespace(effects=[effect], best=best, criteria=criteria), {"after": fitted, "holdout_after": validation}
        )
    if fitted < 1.12:
        assert not any("is adequate (reduced" in s and s.startswith("No form") for s in said)
    if fitted < 1.12 and (validation or 0.0) < criteria.predicted_reduced_chi2:
        assert said == []
    elif fitted < 1.12:
        assert f"but not for the validation run ({validation:.2g})" in said[0]
    else:
        assert said[0].startswith("No form of hysteresis in the library is adequate (reduced chi-square 3")


@pytest.mark.parametrize("name", ["mass_spring_damper", "driven_joint", "pendulum", "two_mass"])
def test_defaults_of_shipped_mechanisms_are_no_expectation_of_units(name):
    assert ships(component(name))


@pytest.mark.parametrize("own_values", [True, False])
def test_a_wrong_unit_is_suspected_only_where_the_values_are_the_users(own_values):
    driven_joint = component("driven_joint")
    experiment = input_output_experiment(driven_joint, ["torque", "angle"])
    recording = joint_run({}, duration=2.0)
    run = prepare_sampled_run(recording, experiment)
    found = fit(FreeInitialStateModel(experiment), [run], FreeInitialStateModel(experiment).start(), iterations=0)
    far = driven_joint.with_values(**{n: 1e4 * v for n, v in driven_joint.values.items() if v})
    result = {"noise_source": "given", "verdict": "none", "gap": {"holdout_before": None, "holdout_after": None}}
    searched = Investigation(Verdict("none", found, found), replace(experiment, own_values=own_values))
    said = " ".join(limitations_of(searched, result, far, False))
    assert ("unit" in said) == own_values


@pytest.mark.parametrize("by_tolerance", [True, False])
def test_a_base_within_the_tolerance_is_not_said_to_have_no_better_effect(by_tolerance):
    driven_joint = component("driven_joint")
    experiment = input_output_experiment(driven_joint, ["torque", "angle"])
    run = prepare_sampled_run(joint_run({}, duration=2.0), experiment)
    found = fit(FreeInitialStateModel(experiment), [run], FreeInitialStateModel(experiment).start(), iterations=0)
    compared = SimpleNamespace(outcome=SimpleNamespace(verdict="none")) if by_tolerance else None
    searched = Investigation(Verdict("none", found, found, comparison=compared), experiment)
    result = {"noise_source": "flexible_model", "verdict": "none", "gap": {"holdout_before": None, "holdout_after": None}}
    said = " ".join(limitations_of(searched, result, driven_joint, False))
    assert ("no effect of the library improves the model" in said) is not by_tolerance


@pytest.mark.parametrize(
    ("kind", "label"),
    [("named", "with the effects found"), ("unknown", "with the nearest effects"), ("tied", "with one of the tied models")],
)
def test_the_best_model_is_labelled_by_what_the_verdict_says_of_it(kind, label):
    best = SimpleNamespace(model=SimpleNamespace(effects=(CoulombFriction,)))
    assert label_of_best(SimpleNamespace(verdict=kind, best=best)) == label


def test_a_best_model_without_effects_is_the_base():
    best = SimpleNamespace(model=SimpleNamespace(effects=()))
    assert label_of_best(SimpleNamespace(verdict="none", best=best)) == "base"


def test_two_effects_are_in_the_plural():
    effect = {"name": "coulomb_friction", "form": "coulomb", "element": None, "parameters": {}}
    both = drawn(np.random.default_rng(0)) | {"verdict": "named", "effects": [effect, {**effect, "name": "backlash"}], "alternatives": [],
                                              "explained": {"share": 0.9, "low": 0.8, "high": 1.0}}  # fmt: skip
    assert answer(both).startswith("Effects are missing: coulomb_friction and backlash; they close 90.0% [80.0%, 100.0%]")
    assert answer({**both, "effects": [effect]}).startswith("An effect is missing: coulomb_friction; closes 90.0%")
    assert "they close nothing" in headline({**both, "explained": {"share": -0.1, "low": -0.2, "high": 0.0}})


def test_a_tie_shows_each_model_with_its_values_and_share():
    effect = {"name": "coulomb_friction", "form": "coulomb", "element": "spring", "sentence": "Dry friction.", "equations": ["force += F"],
              "parameters": {"friction_torque": {"value": 0.5, "standard_error": 0.01, "unit": "N.m"}}}  # fmt: skip
    tie = drawn(np.random.default_rng(0)) | {"verdict": "tied", "effects": [], "alternatives": [
        {"effects": [effect, {**effect, "name": "drift", "parameters": {}}], "closed": 0.53},
        *[{"effects": [effect], "closed": None}] * 6,
    ]}  # fmt: skip
    first, *others, rest = nearest(tie)
    assert first == (
        "possible: coulomb_friction (coulomb): friction_torque = 0.5 +- 0.01 N.m; and drift (coulomb); "
        "closes 53.0% of the closable misfit"
    )
    assert len(others) == 4 and "closes" not in others[0]
    assert rest == "possible: 2 more, in `alternatives` of verdict.json"


def test_the_error_of_a_parameter_without_influence_is_infinite():
    assert standard_errors(np.diag([4.0, 0.0])).tolist() == [2.0, np.inf]
    found = drawn(np.random.default_rng(0))
    effect = {"name": "backlash", "form": "sharp", "element": None, "sentence": "Play.", "equations": [],
              "parameters": with_errors({"gap": (1e9, np.inf, "rad"), "stiffness": (3.0, 0.5, "N.m/rad")})}  # fmt: skip
    assert effect["parameters"]["gap"]["standard_error"] is None  # JSON knows no infinity
    (line,) = laws(found | {"verdict": "named", "effects": [effect]})
    assert line.endswith("gap = 1e+09 +- inf rad, stiffness = 3 +- 0.5 N.m/rad")


def test_an_unknown_verdict_has_its_reason_before_the_nearest_model():
    unknown = drawn(np.random.default_rng(0)) | {
        "verdict": "unknown", "closest": {"name": "drift", "delta_bic": 5.0}, "reason": "Its simulation diverges.", "alternatives": [],
    }  # fmt: skip
    lines = nearest(unknown)
    assert lines[0] == "Its simulation diverges." and lines[1].startswith("Nearest in the library: drift")


def proposed(apart):
    rivals = [{"truth": a, "rival": b, "delta_chi2": x} for (a, b), x in apart.items()]
    rivals += [{"truth": b, "rival": a, "delta_chi2": 2 * x} for (a, b), x in apart.items()]
    return {
        "next_experiment": {"sentence": "Sweep down.", "rivals": rivals, "expected_delta_chi2": min(apart.values())},
        "criteria": {"further_run_delta_chi2": 10.0},
    }


def test_a_next_experiment_says_what_it_does_not_distinguish():
    every = {("a", "b"): 50.0, ("a", "c"): 0.1, ("c", "d"): 0.2, ("a", "d"): 20.0, ("b", "c"): 60.0, ("b", "d"): 70.0}
    assert next_run(proposed(every)) == (
        "Sweep down. Expected delta chi-square: 20, except between a, c, d: these it does not distinguish."
    )
    assert next_run(proposed({("a", "b"): 50.0})) == "Sweep down. Expected delta chi-square: 50."
    assert next_run({"next_experiment": None}) == ""
