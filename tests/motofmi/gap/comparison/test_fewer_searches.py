"""Searches that the comparison leaves out: their results are known, or they cannot change the verdict."""

from dataclasses import replace

import pytest

from fmus.support.errors import InputError
from motofmi.gap.comparison.compared_model import CommonBlocks
from motofmi.gap.estimation.fit_result import Fit, initial_guesses, with_initial_guesses
from motofmi.gap.models.initial_states import InitialStateModel
from motofmi.gap.selection import by_comparison, noise_rounds, staged_selection
from motofmi.gap.validation import before_after
from tests.few_laws import only_families
from tests.motofmi.gap.comparison.test_leader_diverges import gap_of_friction


@pytest.fixture(autouse=True)
def few_laws(monkeypatch):
    only_families(monkeypatch)


@pytest.fixture
def validated(monkeypatch):
    """The arguments of the misfit before and after, of a comparison on blocks that names friction."""
    kept, original = [], by_comparison.before_and_after
    monkeypatch.setattr(staged_selection, "leaves_noise", lambda *_: False)
    monkeypatch.setattr(by_comparison, "before_and_after", lambda *given: kept.append(given) or original(*given))
    assert [e["name"] for e in gap_of_friction()["effects"]] == ["coulomb_friction"]
    return kept[-1]


def test_fits_on_validation_runs_are_continued_with_the_same_misfit(monkeypatch, validated):
    base, best, runs, criteria, known = validated
    searched = before_after.before_and_after(base, best, runs, criteria)
    monkeypatch.setattr(before_after, "_begun", lambda *_: pytest.fail("initial states are searched again"))
    continued = before_after.before_and_after(base, best, runs, criteria, known)
    for one, other in zip(searched, continued, strict=True):
        # a search ends where a step gains less than 5e-2 of about 1e3 units of chi-square
        assert one.chi2 == pytest.approx(other.chi2, rel=1e-3)


def test_a_fit_that_cannot_be_simulated_again_is_searched(monkeypatch, validated):
    _, best, runs, criteria, known = validated
    searched, original, begun = before_after.on_validation_runs(best, runs, criteria), before_after._from, []

    def diverging_once(*given):
        begun.append(given)
        if len(begun) == 1:
            raise InputError("the simulation diverges")
        return original(*given)

    monkeypatch.setattr(before_after, "_from", diverging_once)
    assert before_after.on_validation_runs(best, runs, criteria, known[1]).chi2 == pytest.approx(searched.chi2)


def test_initial_states_on_validation_runs_are_first_those_of_the_leading_model(monkeypatch):
    made, original = [], CommonBlocks.__init__

    def noted(blocks, leading, *given):
        original(blocks, leading, *given)
        made.append((blocks, leading, with_initial_guesses(blocks.validation, initial_guesses(blocks.validation))))

    monkeypatch.setattr(staged_selection, "leaves_noise", lambda *_: False)
    monkeypatch.setattr(CommonBlocks, "__init__", noted)
    gap_of_friction()
    blocks, leading, blocks.validation = made[0]  # as they were before any model was compared
    found = before_after.on_validation_runs(leading, [without_guess(run) for run in blocks.validation]).fit
    searched, extended = [], InitialStateModel._extended
    monkeypatch.setattr(
        InitialStateModel,
        "_extended",
        lambda *given, **options: searched.extend(given[2]) or extended(*given, **options),
    )
    again = blocks.evaluated(leading).validated
    assert not searched
    assert again.chi2 == pytest.approx(found.chi2, rel=1e-3)  # see above
    before_after.on_validation_runs(leading, [without_guess(run) for run in blocks.validation])
    assert searched


def without_guess(run):
    return run.with_initial_guesses({})


def test_other_forms_of_a_pair_are_left_out_where_a_single_effect_is_sufficient(monkeypatch):
    compared, original = [], CommonBlocks.refined_and_evaluated

    def noted(blocks, fits, description):
        compared.append(description)
        return original(blocks, fits, description)

    monkeypatch.setattr(staged_selection, "leaves_noise", lambda *_: False)
    monkeypatch.setattr(CommonBlocks, "refined_and_evaluated", noted)
    gap_of_friction()
    assert "comparing pairs" in compared and "comparing forms of a pair" not in compared


@pytest.mark.parametrize("simulated", [True, False])
def test_chi_square_is_searched_first_only_where_the_best_effect_can_be_simulated(monkeypatch, simulated):
    order, continued = [], staged_selection.or_from_recorded_motion
    for name in ("select_in_rounds", "compare"):
        original = getattr(staged_selection, name)

        def noted(*given, name=name, original=original):
            order.append(name)
            return original(*given)

        monkeypatch.setattr(staged_selection, name, noted)
    monkeypatch.setattr(staged_selection, "leaves_noise", lambda *_: True)

    def diverging(*_):
        raise InputError("the simulation diverges")

    monkeypatch.setattr(staged_selection, "or_from_recorded_motion", continued if simulated else diverging)
    assert [e["name"] for e in gap_of_friction()["effects"]] == ["coulomb_friction"]
    assert order[0] == ("select_in_rounds" if simulated else "compare")


def test_the_noise_that_an_adequate_fit_leaves_needs_no_other_search(monkeypatch):
    monkeypatch.setattr(staged_selection, "leaves_noise", lambda *_: True)
    monkeypatch.setattr(noise_rounds, "with_noise_of_best_effect", lambda *_: pytest.fail("another search"))
    assert [e["name"] for e in gap_of_friction()["effects"]] == ["coulomb_friction"]


def test_a_pair_that_leaves_noise_gives_the_noise_of_the_search(monkeypatch):
    given, original = [], staged_selection.select_in_rounds

    def noted(*arguments):
        given.append(arguments[-1])
        return original(*arguments)

    monkeypatch.setattr(staged_selection, "leaves_noise", lambda found, *_: len(found.model.effects) == 2)
    monkeypatch.setattr(staged_selection, "select_in_rounds", noted)
    monkeypatch.setattr(noise_rounds, "with_noise_of_best_effect", lambda *_: pytest.fail("another search"))
    gap_of_friction()
    assert [len(found.model.effects) for found in given] == [2]


@pytest.mark.parametrize("explained", [True, False])
def test_no_further_round_follows_where_the_noise_only_decreases(monkeypatch, explained):
    """With less noise an inadequate model remains inadequate; of an adequate one a further round decides."""
    rounds, original = [], noise_rounds.select_model

    def noted(*given):
        found = original(*given)
        rounds.append(found)
        return replace(found.as_unknown(), best=found.best if explained else found.base)

    monkeypatch.setattr(staged_selection, "leaves_noise", lambda *_: True)
    monkeypatch.setattr(noise_rounds, "select_model", noted)
    monkeypatch.setattr(noise_rounds, "NOISE_CHANGE", 0.0)
    gap_of_friction()
    assert len(rounds) == (noise_rounds.MOST_ROUNDS if explained else 1)


def test_an_adequate_fit_that_cannot_be_simulated_again_is_followed_by_the_other_search(monkeypatch):
    tried, original = [], Fit.runs_with_remaining_noise

    def diverges_first(found):
        tried.append(found)
        if len(tried) == 1:
            raise InputError("the simulation diverges")
        return original(found)

    monkeypatch.setattr(staged_selection, "leaves_noise", lambda *_: True)
    monkeypatch.setattr(Fit, "runs_with_remaining_noise", diverges_first)
    assert [e["name"] for e in gap_of_friction()["effects"]] == ["coulomb_friction"]
    assert len(tried) > 1


def test_a_search_that_no_model_can_be_simulated_for_says_so(monkeypatch):
    """Nothing can be compared, and the search by chi-square diverges in its first round."""

    def diverges(*given, **options):
        raise InputError("the simulation of swing diverges from 2 to 3 s")

    monkeypatch.setattr(staged_selection, "leaves_noise", lambda *_: False)
    monkeypatch.setattr(staged_selection, "compare", lambda *_: None)
    monkeypatch.setattr(noise_rounds, "select_model", diverges)
    found = gap_of_friction()
    assert found["verdict"] == "unknown"
    assert found["reason"] == "No effect is named: the simulation of swing diverges from 2 to 3 s."
