"""Every rule that decides or withholds a name, each on losses constructed for it."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from fmus.effects.damping import CoulombFriction, CubicDamping, SoftFriction, StribeckFriction
from fmus.effects.drift import Drift
from fmus.effects.resonance import HungBody
from fmus.effects.stiffness import Asymmetry, CubicHardening
from motofmi.gap.comparison.compare import Comparison
from motofmi.gap.comparison.objections import objection
from motofmi.gap.comparison.outcome import outcome
from motofmi.gap.comparison.simplest_form import simplest_sufficient
from motofmi.gap.comparison.unresolved_modes import Unresolved
from motofmi.gap.criteria import Criteria
from tests.motofmi.gap.comparison.constructed_models import BLOCKS, DRIVEN, FLEXIBLE, MOTION, decided, model_with


def test_an_effect_that_leads_is_named():
    found = decided([model_with(CoulombFriction, level=1.0, seed=1), model_with(CubicHardening, level=5.0, seed=2)])
    assert found.verdict == "named" and found.best.effects == (CoulombFriction,)
    # (10 - 1) / (10 - 0.01), but for the scatter of 0.1 over 20 blocks
    assert found.share.share == pytest.approx(0.9, abs=0.02) and found.share.low < found.share.share < found.share.high
    assert found.sentences == []


@pytest.mark.parametrize("rare", [False, True])
def test_an_interval_of_the_share_that_contains_zero_is_explained(rare):
    """A single block of the validation runs has nearly all of the mean square."""
    friction, base = model_with(CoulombFriction, level=1.0, seed=1), model_with(level=10.0)
    if rare:
        base.validation[0], friction.validation[0] = 3000.0, 2000.0
        base.validation[1], friction.validation[1] = 200.0, 500.0
    errors = {id(friction): np.full(1, 0.1)}
    found = outcome(base, [friction], FLEXIBLE, MOTION, (BLOCKS, BLOCKS), errors, Criteria())
    assert found.verdict == "named" and (found.share.low <= 0) == rare
    assert any("of the closed share contains zero" in s for s in found.sentences) == rare


def test_effects_that_lead_in_turn_are_tied():
    found = decided([model_with(CoulombFriction, level=1.0, seed=1), model_with(CubicHardening, level=1.0, seed=2)])
    assert found.verdict == "tied" and {c.effects[0] for c in found.members} == {CoulombFriction, CubicHardening}


def test_an_effect_that_closes_the_same_share_is_tied_although_the_confidence_set_excludes_it():
    # The same order of losses on every block: a difference of 2 % is certain, and 0.2 % of the closable misfit.
    first = model_with(CoulombFriction, level=1.0, seed=1)
    found = decided([first, model_with(CubicHardening, level=1.02, seed=1)])
    assert found.verdict == "tied"
    assert any("hardening_stiffness is tied: as much of the closable misfit is closed" in s for s in found.sentences)
    assert decided([first, model_with(CubicHardening, level=1.2, seed=1)]).verdict == "named"


def test_a_single_effect_that_closes_more_on_validation_runs_is_tied_with_a_pair():
    """The pair has much less loss on the fitted runs alone, as with a few runs of similar inputs."""
    pair = model_with(CubicHardening, Asymmetry, level=2.0, seed=1)
    pair.fitted[:] = 0.01 * pair.fitted
    single = model_with(CoulombFriction, level=0.5, seed=2)
    single.fitted[:] = 2.0 * single.fitted
    found = decided([pair, single])
    assert found.verdict == "tied" and found.members == [pair, single]
    contained = model_with(CubicHardening, level=2.0, seed=3)  # what the pair adds is judged by its gain beside it
    assert single in decided([pair, single, contained]).members and contained not in found.members


def test_a_mode_that_no_run_resolves_leaves_and_the_others_are_compared(monkeypatch):
    def found_in(fit):
        return Unresolved("modes", 0.62, 0.64, 0.05, "Hz") if HungBody in fit.model.effects else None

    monkeypatch.setattr("motofmi.gap.comparison.objections.unresolved_modes", found_in)
    body, friction = model_with(HungBody, level=0.5, seed=1), model_with(CoulombFriction, level=1.0, seed=2)
    found = decided([body, friction])
    assert found.verdict == "named" and found.best is friction
    (said,) = found.sentences
    assert said.startswith("extra_mode is not named") and "resolve modes of 0.62 and 0.64 Hz (resolution 0.05 Hz)" in said
    assert decided([body]).verdict == "unknown"


def test_two_effects_are_named_where_neither_does_alone():
    pair = model_with(CoulombFriction, CubicDamping, level=0.5, seed=3)
    alone = [model_with(CoulombFriction, level=8.0, seed=1), model_with(CubicDamping, level=8.5, seed=2)]
    found = decided([*alone, pair])
    assert found.verdict == "named" and found.best is pair


@pytest.mark.parametrize("strong", [True, False])
def test_what_all_pairs_have_in_common_is_named_unless_each_of_the_others_explains_more(strong):
    """Friction beside either of two dampers; alone, friction has more loss than both or less than both."""
    pairs = [model_with(CoulombFriction, other, level=0.5, seed=i) for i, other in enumerate((CubicDamping, Asymmetry))]
    alone = [model_with(CoulombFriction, level=2.0 if strong else 8.0, seed=3)]
    alone += [model_with(other, level=3.0, seed=4 + i) for i, other in enumerate((CubicDamping, Asymmetry))]
    found = decided([*pairs, *alone])
    assert found.verdict == ("named" if strong else "tied") and {id(m) for m in found.members} == set(map(id, pairs))
    said = "coulomb_friction is in all tied models and is not named: alone it explains less"
    assert any(s.startswith(said) for s in found.sentences) is not strong


def test_a_second_effect_that_closes_little_of_the_rest_is_not_named():
    pair = model_with(CoulombFriction, CubicDamping, level=0.95, seed=1, scatter=0.01)
    found = decided([model_with(CoulombFriction, level=1.0, seed=1, scatter=0.01), pair])
    assert found.verdict == "named" and found.best.effects == (CoulombFriction,)
    said = "coulomb_friction and progressive_damping are not named: 5% of what coulomb_friction leaves is closed"
    assert any(s.startswith(said) for s in found.sentences)


def test_a_second_effect_that_leaves_more_than_the_first_alone_is_said_to_do_so():
    rare = model_with(CoulombFriction, CubicDamping, level=0.1, seed=1, scatter=0.01)
    rare.validation[0] = 50.0  # the mean logarithm falls, the mean square does not
    found = decided([model_with(CoulombFriction, level=1.0, seed=1, scatter=0.01), rare])
    assert any("is larger than that of coulomb_friction" in s for s in found.sentences)


def test_no_gain_is_unknown_with_the_probability_of_the_base():
    found = decided([model_with(CoulombFriction, level=9.0, seed=4, scatter=1.0)], scatter=1.0)
    assert found.verdict == "unknown"
    assert "the gain on data that were not used is not clear" in found.sentences[0]


def test_a_base_that_is_not_distinguishable_from_the_best_effect_is_not_replaced():
    # Gains on the validation runs alone are clear; on all blocks together the losses scatter by more than the gain.
    base, made = model_with(level=10.0, scatter=3.0), model_with(CoulombFriction, level=9.9, seed=5, scatter=3.0)
    made = replace(made, validation=base.validation * 0.7)
    found = outcome(base, [made], FLEXIBLE, MOTION, (BLOCKS, BLOCKS), {id(made): np.full(1, 0.1)}, Criteria())
    assert found.verdict == "unknown"
    assert "the base is in the model confidence set (p = " in found.sentences[-1]


@pytest.mark.parametrize(("runs", "validated", "verdict"), [(1, False, "unknown"), (2, False, "named"), (1, True, "named")])
def test_a_change_over_time_is_not_named_from_a_single_run(runs, validated, verdict):
    base, drifting = model_with(level=10.0), model_with(Drift, level=1.0, seed=1)
    drifting.fit.runs = [DRIVEN] * runs
    base, drifting = (m if validated else replace(m, validation=np.zeros(0)) for m in (base, drifting))
    found = outcome(base, [drifting], FLEXIBLE, MOTION, (BLOCKS, BLOCKS * validated),
                    {id(drifting): np.full(1, 0.1)}, Criteria())  # fmt: skip
    assert found.verdict == verdict
    assert any("in a single run a change over time" in s for s in found.sentences) is (verdict == "unknown")


def test_a_change_over_time_is_not_named_where_the_time_is_the_order_of_joined_runs():
    drifting, friction = model_with(Drift, level=1.0, seed=1), model_with(CoulombFriction, level=2.0, seed=2)
    run = SimpleNamespace(recording=replace(DRIVEN.recording, joined=("a", "b")), experiment=DRIVEN.experiment)
    drifting.fit.runs = friction.fit.runs = [run] * 3
    found = decided([drifting, friction])
    assert found.verdict == "named" and found.best is friction
    assert any(s.startswith("drift is not named: a, b are short and joined") for s in found.sentences)


def test_effects_that_only_increase_the_loss_are_said_to_reduce_nothing():
    found = decided([model_with(CoulombFriction, level=20.0, seed=1)])
    assert found.verdict == "unknown" and found.nearest is None
    assert found.sentences == ["No effect of the library reduces the loss on blocks."]


def test_a_clear_gain_of_a_small_share_is_not_named():
    found = decided([model_with(CoulombFriction, level=9.5, scatter=0.1)])
    assert found.verdict == "unknown"
    assert "5% of the closable misfit is closed, less than 10%" in found.sentences[0]


@pytest.mark.parametrize(
    ("criterion", "effects"), [("first_effect_delta_bic", ()), ("second_effect_delta_bic", (CoulombFriction,))]
)
def test_a_gain_below_the_least_delta_bic_is_not_named(criterion, effects):
    """The mean square is halved, with a scatter of 0.1 % on each of 20 blocks: dBIC = 1000 ln 2 - ln 1000 = 686.2 with
    one more parameter, within 1000 * 0.001 * sqrt(2 / 20) = 0.3."""
    before = model_with(*effects, level=2.0, seed=1, scatter=1e-3)
    model = model_with(*effects, CubicDamping, level=1.0, seed=2, scatter=1e-3)
    base = model_with(level=10.0, seed=3, scatter=1e-3) if effects else before
    models = [before, model] if effects else [model]
    errors = {id(m): np.full(len(m.fit.model.names), 0.1) for m in models}
    for least in (684, 688):
        criteria = Criteria(**{criterion: float(least)})
        found = outcome(base, models, FLEXIBLE, MOTION, (BLOCKS, BLOCKS), errors, criteria)
        assert (found.best is model) is (least == 684)
    assert any(re.search(r"the delta BIC on the fitted blocks is 68[5-7], less than 688", s) for s in found.sentences)


def test_a_misfit_within_the_tolerance_is_none():
    # A base that misses 0.5 % of the motion: sqrt(0.0025 / 100).
    small = [model_with(CoulombFriction, level=0.0001, seed=1)]
    found = outcome(
        model_with(level=0.0025), small, 1e-6, MOTION, (BLOCKS, BLOCKS), {id(small[0]): np.full(1, 0.1)}, Criteria()
    )
    assert found.verdict == "none" and "within the tolerance of 1.00%" in found.sentences[-1]
    assert found.nearest is small[0] and found.best is not small[0]  # not named, and shown
    strict = Criteria(tolerance=0.001)
    found = outcome(
        model_with(level=0.0025), small, 1e-6, MOTION, (BLOCKS, BLOCKS), {id(small[0]): np.full(1, 0.1)}, strict
    )
    assert found.verdict == "named"


@pytest.mark.parametrize(("blocks", "verdict"), [(7, "unknown"), (10, "named"), (12, "named")])
def test_few_blocks_are_a_limitation_and_very_few_give_no_verdict(blocks, verdict):
    made = [model_with(CoulombFriction, level=1.0, seed=1, blocks=blocks)]
    found = decided(made, counts=(blocks, blocks), blocks=blocks)
    assert found.verdict == verdict
    assert any("independent blocks" in s for s in found.sentences) == (blocks < 12)
    assert any("a name needs 8 independent blocks of fitted runs" in s for s in found.sentences) == (blocks < 8)


@pytest.mark.parametrize(("level", "verdict"), [(1.0, "named"), (12.0, "unknown")])
def test_a_short_validation_run_is_judged_with_left_out_blocks_and_can_reject(level, verdict):
    # Without a validation run the effect is named; three blocks of one do not take that away, unless the effect is
    # worse there.
    made, base = (
        replace(model_with(*effects, level=fitted, seed=1), validation=np.full(3, validated), judged_alone=False)
        for effects, fitted, validated in (((CoulombFriction,), 1.0, level), ((), 10.0, 10.0))
    )
    found = outcome(base, [made], FLEXIBLE, MOTION, (BLOCKS, 3), {id(made): np.full(1, 0.1)}, Criteria())
    assert found.verdict == verdict
    if verdict == "named":  # the share is that of the validation run: (10 - 1) / (10 - 0.01) on each of its blocks
        assert found.share.share == pytest.approx(0.9009, abs=1e-4) and found.share.low == pytest.approx(found.share.high)
    assert "judged together with the left-out blocks" in found.sentences[0]
    assert any("the loss on the validation runs is not reduced" in s for s in found.sentences) == (verdict == "unknown")


def test_the_simplest_form_within_one_standard_error_is_taken():
    plain, soft = model_with(CoulombFriction, level=1.0, seed=1), model_with(SoftFriction, level=1.0, seed=4)
    assert simplest_sufficient([plain, soft]) is plain
    better = model_with(SoftFriction, level=0.5, seed=5)
    assert simplest_sufficient([plain, better]) is better


@pytest.mark.parametrize(("breakaway", "form"), [(0.0, "coulomb"), (0.19, "coulomb"), (0.21, "stribeck")])
def test_a_form_that_adds_an_undetermined_magnitude_is_the_form_without_it(breakaway, form):
    """Two standard errors are 0.2, and the mean loss of the Stribeck form is less by many standard errors."""
    plain, more = model_with(CoulombFriction, level=1.0, seed=1), model_with(StribeckFriction, level=0.7, seed=1)
    more.fit.x[more.fit.model.names.index("coulomb_friction.breakaway")] = breakaway
    found = decided([plain, more])
    assert found.verdict == "named" and found.best.effects[0].form == form
    assert decided([more]).best is more  # the Coulomb form was not compared


@pytest.mark.parametrize("runs", ["fitted", "validation"])
def test_an_effect_that_gains_on_one_kind_of_runs_only_is_not_named(runs):
    # On the other runs its mean square scatters about that of the base, by a factor exp(0.1) on each block.
    made, as_base = model_with(CoulombFriction, level=1.0, seed=1), model_with(level=10.0, seed=7)
    found = decided([replace(made, **{runs: getattr(as_base, runs)})])
    assert found.verdict == "unknown" and found.members == []


def test_the_best_of_many_equal_effects_is_chance():
    # Gains of one standard error on validation runs are usual for the best of some effects; on fitted runs all gain.
    made = [
        model_with(effect, level=1.0, seed=i, scatter=1.0) for i, effect in enumerate((CoulombFriction, CubicHardening))
    ]
    equal = [
        replace(m, validation=model_with(level=10.0, seed=20 + i, scatter=1.0).validation) for i, m in enumerate(made)
    ]
    found = decided(equal, scatter=1.0)
    assert found.verdict == "unknown" and found.sentences


def test_a_second_effect_must_close_a_tenth_on_few_validation_blocks_too():
    """Left-out blocks of the fitted runs judge together with them, and do not replace them."""
    first = model_with(CoulombFriction, level=1.0, seed=1, scatter=0.01)
    pair = model_with(CoulombFriction, CubicDamping, level=0.3, seed=1, scatter=0.01)
    base = model_with(level=10.0)
    few = [replace(m, validation=m.validation[:3], judged_alone=False) for m in (base, first, pair)]
    few[2].validation[:] = 0.97 * few[1].validation
    errors = {id(m): np.full(len(m.fit.model.names), 0.1) for m in few}
    found = outcome(few[0], few[1:], FLEXIBLE, MOTION, (BLOCKS, 3), errors, Criteria())
    assert found.verdict == "named" and found.best.effects == (CoulombFriction,)
    assert any("3% of what coulomb_friction leaves is closed" in s for s in found.sentences)


@pytest.mark.parametrize(("alone", "kept"), [(True, 1), (False, 2)])
def test_a_pair_without_a_clear_gain_on_enough_validation_blocks_is_not_searched_again(alone, kept):
    """The gain of the second pair is on the fitted blocks only."""
    good = model_with(CoulombFriction, CubicDamping, level=0.5, seed=3)
    fitted_only = model_with(CoulombFriction, CubicHardening, level=0.5, seed=4)
    fitted_only = replace(fitted_only, validation=fitted_only.validation * 40, judged_alone=alone)
    base, models = model_with(level=10.0), [good, fitted_only]
    found = outcome(base, models, FLEXIBLE, MOTION, (BLOCKS, BLOCKS), {id(m): np.full(2, 0.1) for m in models}, Criteria())
    assert found.standing[id(fitted_only)] == "gain not clear"
    assert len(Comparison(found, base, models, FLEXIBLE, MOTION, (BLOCKS, BLOCKS)).clear_pairs()) == kept


@pytest.mark.parametrize(("large", "said"), [(1000.0, True), (1.0, False)])
def test_a_gain_in_few_blocks_alone_is_said_to_be_one(large, said):
    """Every fifth block has 100 times less misfit, and the others four times as much."""
    squares = np.where(np.arange(BLOCKS) % 5 == 0, large, 1.0)
    after = np.where(squares > 1, squares / 100, 4.0)
    base, model = model_with(level=1.0), model_with(CoulombFriction, level=1.0)
    base, model = (replace(m, fitted=y, validation=y) for m, y in ((base, squares), (model, after)))
    kind, sentence = objection(base, model, [model], FLEXIBLE, Criteria())
    assert kind == "gain not clear" and ("falls in the blocks where it is largest" in sentence) == said


def test_the_form_of_an_effect_may_have_more_loss_than_the_base_although_the_effect_is_named():
    """The simplest sufficient form has one block with a large misfit, by its mean square worse than the base."""
    base, form = model_with(level=10.0), model_with(CoulombFriction, level=8.8)
    flexible = model_with(StribeckFriction, level=9.0)
    form.fitted[3] = 8.8 * np.exp(6)
    errors = {id(m): np.full(len(m.fit.model.names), 0.1) for m in (form, flexible)}
    found = outcome(base, [flexible, form], 8.0, MOTION, (BLOCKS, BLOCKS), errors, Criteria())
    assert found.verdict in ("named", "unknown") and found.nearest.families == {"coulomb_friction"}
