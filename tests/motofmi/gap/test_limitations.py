"""Every rule by chi-square that changes a verdict says so in a limitation, each on a fit constructed for it.

The rules of the comparison on blocks are in `comparison/test_outcome.py`, those of validation runs in
`test_validation_run.py`, and the time budget in `test_time_budget.py`.
"""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from fmus.effects.damping import CoulombFriction, ProgressiveDamping, SoftFriction
from fmus.effects.resonance import HungBody
from motofmi.gap import verdict as contents
from motofmi.gap.alternatives import reason
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import Candidate
from motofmi.gap.experiments.sensor_offset import sensor_offset_parameter
from motofmi.gap.selection import chi_square_conditions, eigenvalues, model_selection
from motofmi.gap.selection.any_component import Investigation
from motofmi.gap.selection.by_chi_square import of_one, of_pairs
from motofmi.gap.selection.confirmation import with_validation
from motofmi.gap.selection.pairs import Pair
from motofmi.gap.selection.result import Verdict
from motofmi.gap.validation.validation_run import ValidationRuns
from motofmi.workflows.gap.limitations import limitations_of

FREEDOM = 10_000


def fit_with(*effects, reduced):
    """A fit of this reduced chi-square, whose parameters are 0.1 +- 0.1 each."""
    names = [f"{e.family}.{n}" for e in effects for n in e.free_parameters()]
    model = SimpleNamespace(
        effects=effects, names=names, own=names, base=[], sizes=[], values=lambda q: dict.fromkeys(names, 0.1),
        component=SimpleNamespace(
            name="joint", elements={}, table={n: SimpleNamespace(unit="N.m", min=0.0, max=np.inf) for n in names}
        ),
        experiment=SimpleNamespace(
            parameter=lambda effect, n: f"{effect.family}.{n}", own_values=False, sensor_offsets={}, common_offsets=False, free=[],
            from_rest=False, sliding_rate=0.02, outputs=["angle"], component=SimpleNamespace(elements={"spring": None}, states=[]),
        ),
    )  # fmt: skip
    run = SimpleNamespace(name="run", noise_source="given", direction=0.0, longest_of_integrator=0.0)
    return SimpleNamespace(
        model=model, runs=[run], reduced=reduced, chi2=reduced * FREEDOM, freedom=FREEDOM, count=FREEDOM, penalty=0.0, shared=None,
        x=np.full(len(names), 0.1), covariance=lambda: 0.01 * np.eye(len(names)), residuals=np.zeros(0),
        jacobian=np.eye(9)[:, : len(names)],
    )  # fmt: skip


def candidate(effect, *, reduced, delta_bic):
    return Candidate(effect, fit_with(effect, reduced=reduced), delta_bic, delta_bic)


def said_of(found):
    return contents._limitations(found)


BASE = fit_with(reduced=5.0)


def test_a_family_that_closes_too_little_of_the_excess_is_not_named():
    found = of_one(BASE, [candidate(CoulombFriction, reduced=3.0, delta_bic=2000.0)], Criteria())
    assert found.verdict == "unknown"
    assert any("coulomb_friction is not named without one: it closes 50% of the excess, less than 95%" in s for s in said_of(found))


def test_the_reason_is_the_rule_by_which_nothing_is_named():
    unknown = of_one(BASE, [candidate(CoulombFriction, reduced=3.0, delta_bic=2000.0)], Criteria())
    assert "less than 95%" in reason(unknown, said_of(unknown))
    beyond = replace(unknown, withheld="", outside_library=candidate(ProgressiveDamping, reduced=1.0, delta_bic=3000.0))
    assert reason(beyond, said_of(beyond)).startswith("An effect outside the library explains the data better")
    assert reason(replace(unknown, ended="The time budget ended."), said_of(unknown)) is None
    assert reason(replace(unknown, verdict="named"), said_of(unknown)) is None


def test_a_family_without_an_adequate_form_must_lead_the_others():
    first = [candidate(CoulombFriction, reduced=1.15, delta_bic=3850.0), candidate(ProgressiveDamping, reduced=1.16, delta_bic=3840.0)]
    found = of_one(BASE, first, Criteria())
    assert found.verdict == "unknown"
    assert any("leads progressive_damping by a delta BIC of 10, less than 40" in s for s in said_of(found))
    assert of_one(BASE, first[:1], Criteria()).verdict == "named"


def test_a_pair_whose_second_effect_is_one_of_several_names_the_first_and_lists_the_others():
    friction = candidate(CoulombFriction, reduced=3.0, delta_bic=2000.0)
    pairs = [Pair(friction, candidate(effect, reduced=1.0, delta_bic=1000.0)) for effect in (ProgressiveDamping, HungBody)]
    found = of_pairs(BASE, pairs[0], pairs, [friction], Criteria())
    assert [c.family for c in found.effects] == ["coulomb_friction"]
    found = replace(found, candidates=[])
    assert any("A second effect is missing besides coulomb_friction: one of progressive_damping, extra_mode" in s for s in said_of(found))


def test_of_both_effects_of_a_pair_that_which_gains_more_alone_comes_first():
    alone = [candidate(CoulombFriction, reduced=3.0, delta_bic=2000.0), candidate(HungBody, reduced=4.0, delta_bic=900.0)]
    pair = Pair(alone[1], candidate(CoulombFriction, reduced=1.0, delta_bic=1500.0))
    found = of_pairs(BASE, pair, [pair], alone, Criteria())
    assert [c.family for c in found.effects] == ["coulomb_friction", "extra_mode"]


def test_an_effect_that_all_pairs_contain_is_not_named_where_the_others_explain_more():
    """Drag and a body explain most, each alone; friction explains what either of them leaves."""
    weak = candidate(CoulombFriction, reduced=4.9, delta_bic=20.0)
    strong = [candidate(effect, reduced=1.2, delta_bic=2000.0) for effect in (ProgressiveDamping, HungBody)]
    pairs = [Pair(one, candidate(CoulombFriction, reduced=1.0, delta_bic=50.0)) for one in strong]
    found = of_pairs(BASE, pairs[0], pairs, [*strong, weak], Criteria())
    assert found.verdict == "tied" and not found.effects
    assert [c.family for c in found.tied] == ["progressive_damping", "extra_mode"]
    both = [fit_with(CoulombFriction, c.effect, reduced=1.0) for c in found.tied]
    found = replace(found, tied=[replace(c, fit=fit) for c, fit in zip(found.tied, both, strict=True)])
    assert any(s.startswith("coulomb_friction is in all tied models and is not named") for s in said_of(found))
    stronger = candidate(CoulombFriction, reduced=1.1, delta_bic=3000.0)
    strongest = of_pairs(BASE, pairs[0], pairs, [*strong, stronger], Criteria())
    assert strongest.verdict == "named" and [c.family for c in strongest.effects] == ["coulomb_friction"]


def test_of_tied_pairs_the_one_that_validation_confirms_is_named_with_both_effects():
    weak = candidate(CoulombFriction, reduced=4.9, delta_bic=20.0)
    tied = [Candidate(e, fit_with(CoulombFriction, e, reduced=1.0), 2000.0, 2000.0) for e in (ProgressiveDamping, HungBody)]
    found = Verdict("tied", BASE, tied[0].fit, [], tied, [*tied, weak])

    class RejectsBodies:
        criteria = Criteria()

        def reject(self, base, fit, unspecified_form=False):
            return HungBody in fit.model.effects

    named = with_validation(found, RejectsBodies())
    assert named.verdict == "named" and named.rejected == ["extra_mode"]
    assert [(c.family, c.fit) for c in named.effects] == [
        ("progressive_damping", tied[0].fit), ("coulomb_friction", tied[0].fit),
    ]  # fmt: skip


def test_a_value_within_its_error_is_not_reported():
    found = of_one(BASE, [candidate(CoulombFriction, reduced=1.0, delta_bic=4000.0)], Criteria())
    assert found.verdict == "named"
    # every parameter of the fit is 0.1 +- 0.1
    assert contents.unidentified(found, CoulombFriction) == list(CoulombFriction.free_parameters())
    assert any("coulomb_friction: friction_torque is not identifiable" in s for s in said_of(found))


def test_an_effect_that_gains_little_is_not_named(monkeypatch):
    monkeypatch.setattr(model_selection, "fit_base", lambda *_: BASE)
    monkeypatch.setattr(
        model_selection, "search_candidates", lambda *_, **__: [candidate(CoulombFriction, reduced=4.99, delta_bic=5.0)]
    )
    found = model_selection._select(None, [], [], ValidationRuns([]), lambda verdict: None, [])
    assert found.verdict == "unknown"
    assert "No effect of the library gains a delta BIC of 12; coulomb_friction gains 5." in said_of(found)


def test_what_leaves_most_of_the_misfit_is_not_named(monkeypatch):
    monkeypatch.setattr(model_selection, "better_outside_library", lambda *_, **__: None)
    friction = candidate(CoulombFriction, reduced=3.5, delta_bic=1500.0)
    named = Verdict("named", BASE, friction.fit, [friction])
    found = model_selection._unless_outside_library(named, [], ValidationRuns([]))
    assert found.verdict == "unknown"
    assert "coulomb_friction is not named: less than 50% of the excess" in said_of(found)[0]


@pytest.mark.parametrize(("unspecified", "reduced", "said"), [
    (False, 20.0, "far from the noise (reduced chi-square 20, limit 10), and no validation run confirms it"),
    (True, 2.0, "as an effect with a single form it reduces most kinds of misfit"),
])  # fmt: skip
def test_a_doubtful_name_is_withheld(unspecified, reduced, said):
    friction = candidate(CoulombFriction, reduced=reduced, delta_bic=1500.0)
    named = Verdict("named", BASE, friction.fit, [friction], unspecified_form=unspecified)
    found = chi_square_conditions.unless_doubtful(named, [CoulombFriction], [], Criteria())
    assert found.verdict == "unknown" and said in said_of(found)[0]


@pytest.mark.parametrize(("low", "verdict"), [(-0.01, "unknown"), (0.01, "tied")])
def test_what_validation_runs_do_not_show_is_not_named(monkeypatch, low, verdict):
    monkeypatch.setattr(
        chi_square_conditions, "explained", lambda found: {"share": 0.107, "low": low, "high": 1.0}
    )
    effects = [candidate(effect, reduced=1.2, delta_bic=15.0) for effect in (CoulombFriction, HungBody)]
    found = chi_square_conditions.unless_unclear(Verdict("tied", BASE, effects[0].fit, [], effects))
    assert found.verdict == verdict
    said = "the gain of coulomb_friction or extra_mode on the validation runs is not clear (10.7% of the closable misfit"
    assert any(said in each for each in said_of(found)) == (verdict == "unknown")


@pytest.mark.usefixtures("without_sensor_offsets")
@pytest.mark.parametrize(("held", "ended", "said"), [(True, None, True), (True, "The time is used up.", False), (False, None, False)])
def test_an_rms_on_validation_runs_that_is_missing_is_said(held, ended, said):
    found = fit_with(reduced=1.0)
    result = {
        "noise_source": "given", "verdict": "unknown", "ended": ended,
        "gap": {"holdout_before": None, "holdout_after": None},
    }  # fmt: skip
    searched = Investigation(Verdict("unknown", found, found), found.model.experiment)
    sentences = limitations_of(searched, result, SimpleNamespace(values={}), held)
    assert any(each.startswith("The rms on the validation runs is not stated") for each in sentences) == said


def doubts(found, factor=1.0, missed=0.0, **values):
    """The limitations of an investigation of a component with these values that ended with a fit."""
    searched = Investigation(Verdict("unknown", found, found), found.model.experiment, factor, missed)
    result = {"noise_source": "given", "verdict": "unknown", "gap": {"holdout_before": None, "holdout_after": None}}
    return limitations_of(searched, result, SimpleNamespace(values=values), False)


@pytest.mark.parametrize("values, absent", [((0.1, 1.0), True), ((1.0, 1.0), False), ((0.1, 0.1), False)])
def test_a_value_that_may_be_zero_is_said_unless_all_are(monkeypatch, values, absent):
    """Each has a standard error of 0.1; where none is determined, the verdict has a sentence of its own."""
    monkeypatch.setattr("motofmi.workflows.gap.limitations.sensor_offsets_of", lambda found: [{} for _ in found.runs])
    parameters = {"stiffness": (values[0], 0.1, "N.m/rad"), "damping": (values[1], 0.1, "N.m.s/rad")}
    monkeypatch.setattr("motofmi.workflows.gap.limitations.parameters_of", lambda found: parameters)
    found = fit_with(reduced=1.0)
    found.model.base = list(parameters)
    found.model.component.table |= {n: SimpleNamespace(unit=p[2], min=0.0, max=np.inf) for n, p in parameters.items()}
    said = " ".join(doubts(found))
    assert ("stiffness = 0.1 N.m/rad is not distinguishable from zero" in said) == absent and "damping" not in said


@pytest.mark.parametrize(
    ("error", "verdict", "final"), [(0.04, "named", True), (0.06, "named", False), (0.06, "unknown", True)]
)
def test_a_name_by_chi_square_is_final_where_its_magnitude_is_determined(error, verdict, final):
    """The magnitude is 0.1; a verdict that names nothing has none to be determined."""
    found = fit_with(CoulombFriction, reduced=1.0)
    found.covariance = lambda: error**2 * np.eye(len(found.model.names))
    made = Verdict(verdict, BASE, found)
    assert chi_square_conditions.decisive(made, found, True, Criteria()) == final


@pytest.mark.parametrize("from_rest", [True, False])
def test_runs_that_are_taken_to_begin_at_rest_are_said(from_rest):
    found = fit_with(reduced=1.0)
    found.model.experiment.from_rest = from_rest
    assert any("step responses" in s for s in doubts(found)) == from_rest


@pytest.fixture
def without_sensor_offsets(monkeypatch):
    monkeypatch.setattr("motofmi.workflows.gap.limitations.sensor_offsets_of", lambda found: [{} for _ in found.runs])


@pytest.mark.usefixtures("without_sensor_offsets")
def test_what_is_too_much_for_noise_is_said():
    said = doubts(fit_with(reduced=1.0), missed=0.3)
    assert any("30 % (rms) of the recorded angle" in sentence for sentence in said)


@pytest.mark.parametrize(("one_way", "said"), [
    (False, "a sensor offset, or another constant input."),
    (True, "a sensor offset, dry friction (the rate has one sign), or another constant input."),
])  # fmt: skip
def test_a_constant_torque_may_be_friction_where_the_rate_has_one_sign(monkeypatch, one_way, said):
    found = fit_with(reduced=1.0)
    found.model.experiment.sensor_offsets = {"torque": 0.1}
    found.runs[0].direction, found.runs[0].recording = float(one_way), SimpleNamespace(units={"torque": "N.m"})
    offsets = [{sensor_offset_parameter("torque"): (-0.03, 1e-5)}]
    monkeypatch.setattr("motofmi.workflows.gap.limitations.sensor_offsets_of", lambda _: offsets)
    assert any(sentence.endswith(said) for sentence in doubts(found))


@pytest.mark.usefixtures("without_sensor_offsets")
@pytest.mark.parametrize(("low", "high", "said"), [(-1.0, 0.1, True), (0.1, 1.0, False), (-0.5, 0.5, False)])
def test_a_magnitude_at_its_bound_is_said_unless_the_bound_is_that_of_no_effect(low, high, said):
    found = fit_with(CoulombFriction, reduced=1.0)
    for row in found.model.component.table.values():
        row.min, row.max = low, high
    assert any("was fitted to its bound 0.1 N.m" in sentence for sentence in doubts(found)) is said


@pytest.mark.usefixtures("without_sensor_offsets")
@pytest.mark.parametrize(("start", "least", "said"), [
    (1e3, 0.0, "the data are fitted as well without it."),
    (1e3, 1e-9, "is a column's unit wrong?"),
    (1e-5, 0.0, "is a column's unit wrong?"),
])  # fmt: skip
def test_a_value_far_from_its_start_asks_for_the_unit_unless_it_vanished(start, least, said):
    found = fit_with(reduced=1.0)
    row = SimpleNamespace(unit="N.m", min=least, max=np.inf)
    found.model.component.table, found.model.base, found.model.names = {"damping": row}, ["damping"], ["damping"]
    found.model.values, found.model.experiment.own_values = lambda q: {"damping": 0.1}, True
    found.covariance, found.x = lambda: np.eye(1), np.ones(1)
    (sentence, *_) = doubts(found, damping=start)
    assert sentence == f"damping was fitted to 0.1 N.m, far from its start value {start:.3g}: {said}"


@pytest.mark.usefixtures("without_sensor_offsets")
@pytest.mark.parametrize(
    ("unit", "elements", "said"),
    [("1", {}, "A state has the unit 1"), ("V", {}, "No state of the component has the unit of a deflection"),
     ("1", {"spring": None}, "")],
)  # fmt: skip
def test_a_state_in_other_units_has_no_laws_of_mechanics_which_is_said(unit, elements, said):
    found = fit_with(reduced=1.0)
    found.model.experiment.component = SimpleNamespace(
        elements=elements, states=["level"], table={"level": SimpleNamespace(unit=unit)}
    )
    of_units = [sentence for sentence in doubts(found) if "the laws of mechanics" in sentence]
    assert len(of_units) == bool(said) and all(sentence.startswith(said) for sentence in of_units)


def test_values_within_their_errors_of_zero_are_not_reported():
    friction = candidate(CoulombFriction, reduced=1.0, delta_bic=1500.0)
    compared = SimpleNamespace(outcome=SimpleNamespace(sentences=["Few blocks."]))
    found = Verdict("named", BASE, friction.fit, [friction, friction], comparison=compared)
    assert said_of(found)[:2] == [
        "Few blocks.",
        "coulomb_friction: friction_torque is not identifiable from these data (within 2 standard errors of zero).",
    ]


def test_an_effect_outside_the_library_and_rejected_families_are_said():
    friction = candidate(CoulombFriction, reduced=1.0, delta_bic=1500.0)
    law = SimpleNamespace(delta_chi2=321.0, effect=SimpleNamespace(sentence=lambda: "The spring softens."))
    found = Verdict("unknown", BASE, friction.fit, outside_library=law, rejected=["drift"])
    assert said_of(found) == [
        "An effect outside the library explains the data better than coulomb_friction (delta chi-square 321): The spring softens.",
        "The validation run rejects what fits as well or better: drift.",
    ]


def test_a_form_that_validation_runs_reject_is_replaced_with_a_sentence(monkeypatch):
    monkeypatch.setattr(contents, "equivalent", lambda *_: [])
    soft, plain = (candidate(effect, reduced=1.0, delta_bic=4000.0) for effect in (SoftFriction, CoulombFriction))
    validation = ValidationRuns([SimpleNamespace(data=np.zeros(1))])
    validation.reject = lambda base, found, *_: found is soft.fit
    found = with_validation(Verdict("named", BASE, soft.fit, [soft], candidates=[soft, plain]), validation)
    assert [c.effect for c in found.effects] == [CoulombFriction]
    replaced = "a form that fits as well, which was replaced: coulomb_friction.soft by coulomb."
    assert f"The validation run rejects {replaced}" in said_of(found)


def test_a_form_that_is_not_in_the_library_is_no_name_for_eigenvalues(monkeypatch):
    found = of_one(BASE, [candidate(CoulombFriction, reduced=1.15, delta_bic=3850.0)], Criteria())
    assert found.verdict == "named" and found.unspecified_form
    monkeypatch.setattr(eigenvalues, "EigenvalueModel", lambda experiment: experiment)
    monkeypatch.setattr(eigenvalues, "select_model", lambda *_, **__: found)
    unknown = eigenvalues.select_model_for_eigenvalues(None, [], [])
    assert unknown.verdict == "unknown" and "coulomb_friction is not named" in reason(unknown, said_of(unknown))
    assert reason(unknown, []) in said_of(unknown)
