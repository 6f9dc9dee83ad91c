"""Validation runs: effects that they confirm, reject or select, and how these runs are simulated."""

import pytest

from fmus.support.errors import InputError
from motofmi.gap.estimation.fit_result import parameters_of
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.models.harmonic_model import HarmonicModel
from motofmi.gap.selection.candidate_search import search_candidates
from motofmi.gap.selection.model_selection import select_model
from motofmi.gap.validation.before_after import on_validation_runs, reduced_chi2_after_refit
from motofmi.gap.validation.validation_run import ValidationRuns
from motofmi.gap.verdict import as_result
from motofmi.workflows.gap.rig import rig_experiment

pytest.importorskip("numba", reason="the simulator of the hidden effects is compiled by numba")
import numpy as np

from tests.simulators.hidden_rig import RIDER, sweep
from tests.simulators.rig_runs import RIG, library, runs_of


@pytest.mark.study
def test_a_form_rejected_at_larger_amplitude_leaves_its_family_or_another_form():
    """Arms that stiffen exponentially: at two thirds of the validation run's angle a cubic fits as well."""
    runs = runs_of({"kx": 60.0}, sweep(0.5, 12, 2.0, 100.0), sweep(12, 0.5, 3.0, 100.0))
    plain = [e for e in library("hardening_stiffness") if e.form != "exponential"]
    verdict = select_model(HarmonicModel(rig_experiment(RIG)), runs[:1], plain, runs[1:])
    assert (verdict.verdict, [c.family for c in verdict.effects], verdict.unspecified_form) == (
        "named",
        ["hardening_stiffness"],
        True,
    )
    assert any(
        "parameters are those of the nearest form" in sentence for sentence in as_result(verdict, "N.m")["limitations"]
    )
    assert select_model(HarmonicModel(rig_experiment(RIG)), runs[:1], plain).unspecified_form is False
    verdict = select_model(HarmonicModel(rig_experiment(RIG)), runs[:1], library("hardening_stiffness"), runs[1:])
    assert (verdict.verdict, [c.effect.form for c in verdict.effects], verdict.unspecified_form) == (
        "named",
        ["exponential"],
        False,
    )
    width, error, _ = parameters_of(verdict.best)["device.hardening_stiffness.width"]
    assert width == pytest.approx(0.03, abs=2 * error) and error < 0.02


@pytest.mark.study
def test_validation_runs_with_evidence_for_an_effect_outweigh_errors_of_its_values():
    """A grip with drift: the rate is hardly identifiable from a sweep up, the sweep down is predicted badly, and both
    together fit."""
    runs = runs_of({"rl": 0.5}, sweep(0.5, 12, 3, 100.0, logarithmic=True), sweep(12, 0.5, 3.9, 80.0, logarithmic=True))
    verdict = select_model(
        HarmonicModel(rig_experiment(RIG)), runs[:1], library("drift", "channel_delay", "shaft_compliance"), runs[1:]
    )
    assert (verdict.verdict, [c.family for c in verdict.effects]) == ("named", ["drift"])
    held = ValidationRuns(runs[1:])
    assert held.excess(verdict.best) > 0.15 * held.excess(verdict.base) > 1, "frozen, it closes too little"
    assert (
        held.excess_after_refit(verdict.best) < 0.3 < held.excess_after_refit(verdict.base)
    )  # 350 numbers: 4 standard deviations
    rivals = [c for c in verdict.candidates if c.family == "channel_delay"]
    assert rivals and all(held.reject(verdict.base, c.fit) for c in rivals)


@pytest.mark.slow
def test_misfit_that_errors_of_the_values_explain_rejects_no_effect():
    """A drift that one sweep determines to a tenth: with its fitted values the sweep down is predicted badly, within
    their errors it is not."""
    runs = runs_of({"rk": 0.5}, sweep(0.5, 12, 1.5, 100.0), sweep(12, 0.5, 2.0, 80.0), seed=1)
    verdict = select_model(HarmonicModel(rig_experiment({})), runs[:1], library("drift", "channel_delay"), runs[1:])
    assert (verdict.verdict, [c.family for c in verdict.effects]) == ("named", ["drift"])
    held = on_validation_runs(verdict.best, runs[1:])
    assert held.chi2 > 2  # all frozen
    assert reduced_chi2_after_refit(verdict.best, held) == pytest.approx(
        1.0, abs=0.2
    )  # 448 numbers: 3 standard deviations
    said = as_result(verdict, "N.m")["limitations"]
    assert any("too uncertain to predict" in sentence for sentence in said)


@pytest.mark.slow
def test_the_verdict_none_needs_a_validation_run_that_is_predicted():
    """Arms that stiffen while a slow sweep is below the frequencies at which they act; at the start of the validation
    run they are soft."""
    runs = runs_of(
        {"re": 0.5}, sweep(0.2, 8, 2.3, 120.0, logarithmic=True), sweep(8, 0.2, 3.0, 100.0, logarithmic=True)
    )
    model, families = HarmonicModel(rig_experiment(RIG)), library("asymmetry", "added_inertia")
    assert select_model(model, runs[:1], families).verdict == "none"
    verdict = select_model(model, runs[:1], families, runs[1:])
    assert verdict.verdict == "unknown"
    assert any("Fit the validation run too" in sentence for sentence in as_result(verdict, "N.m")["limitations"])


@pytest.fixture(scope="module")
def coupled():
    """Torso and bar coupled by an inertia; one sweep up to fit, one down. A drift makes up for it in one sweep, not in
    the other."""
    return runs_of({"Icc": 0.07}, sweep(0.5, 12, 2.5, 100.0), sweep(12, 0.5, 3.2, 100.0))


@pytest.mark.study
def test_a_family_that_validation_runs_reject_is_replaced_by_another(coupled, monkeypatch):
    """Where the wrong family is selected first (here it is the only candidate), it is excluded, and another may be
    selected."""
    drift_only = lambda library: [e for e in library if e.family == "drift"] or library  # noqa: E731
    monkeypatch.setattr(
        "motofmi.gap.selection.model_selection.search_candidates",
        lambda base, effects, **more: search_candidates(base, drift_only(effects), **more),
    )
    verdict = select_model(
        HarmonicModel(rig_experiment(RIG)), coupled[:1], library("drift", "cross_inertia"), coupled[1:]
    )
    assert (verdict.verdict, [c.family for c in verdict.effects]) == ("named", ["cross_inertia"])
    assert verdict.rejected == ["drift"]
    assert (
        select_model(HarmonicModel(rig_experiment(RIG)), coupled[:1], library("drift", "cross_inertia"))
        .effects[0]
        .family
        == "drift"
    ), "without a validation run it is not rejected"


@pytest.mark.slow
def test_an_effect_that_cannot_be_simulated_on_the_validation_run_is_not_named(coupled, monkeypatch):
    def diverges(found, runs, *more):
        if found.model.effects:
            raise InputError("the simulation diverges")
        return on_validation_runs(found, runs, *more)

    monkeypatch.setattr(ValidationRuns, "reject", lambda *_: False)
    for place in ("validation_run", "before_after"):
        monkeypatch.setattr(f"motofmi.gap.validation.{place}.on_validation_runs", diverges)
    verdict = select_model(HarmonicModel(rig_experiment(RIG)), coupled[:1], library("cross_inertia"), coupled[1:])
    assert (verdict.verdict, verdict.effects) == ("unknown", [])
    assert "cross_inertia is not named: the best fit cannot be simulated again" in verdict.withheld
    assert not verdict.best.model.effects
    without, with_it = verdict.validation_gap
    assert without.chi2 == pytest.approx(with_it.chi2), (
        "nothing was found: what the base leaves there is shown all the same"
    )


@pytest.mark.slow
def test_a_simulation_starts_from_the_last_states_of_the_recording(coupled):
    model, run = HarmonicModel(rig_experiment(RIG)), coupled[0]
    y = model.outputs(run, model.start(), slopes=False)[0]
    assert model.equations.states and id(run.with_remaining_noise(y).recording) in model.found


@pytest.mark.slow
def test_what_was_simulated_of_one_run_is_not_taken_for_another(coupled):
    model, (one, other) = HarmonicModel(rig_experiment(RIG)), coupled
    expected = HarmonicModel(rig_experiment(RIG)).outputs(other, model.start())[0]
    model.outputs(one, model.start(), slopes=False)
    model.fresh[id(other)] = model.fresh.pop(id(one))  # as where one is gone, and the other lies where it was
    np.testing.assert_allclose(
        model.outputs(other, model.start())[0], expected, atol=1e-6 * np.abs(expected).max()
    )  # twice the same


@pytest.mark.slow
def test_a_validation_run_that_cannot_be_simulated_at_once_is_reached_by_continuation():
    """Arms that stiffen twentyfold: on a new run the motion is far from any guess. Without continuation the right
    effect was rejected."""
    rider = dict(zip(RIDER, (0.337, 0.531, 667.0, 82.0, 5.3, 2.47), strict=True))
    fitted, held = (
        runs_of({"kx": 42.0}, sweep(*ends, 40.0), rider=rider, rate=64) for ends in ((1, 8, 2.6), (8, 1, 3.4))
    )
    verdict = select_model(
        HarmonicModel(rig_experiment({})),
        fitted,
        [e for e in library("hardening_stiffness") if e.form in ("cubic", "exponential")],
        held,
    )
    assert (verdict.verdict, [c.effect.form for c in verdict.effects], verdict.rejected) == (
        "named",
        ["exponential"],
        [],
    )
    assert ValidationRuns(held).excess(verdict.best) < 1e-3 * ValidationRuns(held).excess(verdict.base)
    later, stiffer = verdict.base.model.with_added_effects(verdict.effects[0].effect), verdict.best.shared.copy()
    stiffer[later.names.index("device.hardening_stiffness.cubic_stiffness")] *= (
        2  # it knows that run from the base alone, whose motion leads nowhere here
    )
    assert np.all(np.isfinite(later.predicted(held[0], stiffer)))
    soft = np.where(
        np.arange(len(stiffer)) == later.names.index("device.hardening_stiffness.cubic_stiffness"), 0.0, stiffer
    )
    later.predicted(held[0], soft)
    with pytest.raises(InputError, match="diverges"):
        later.predicted(held[0], stiffer)
    assert np.all(np.isfinite(later.with_remaining_noise(held[0], stiffer).deviation))
    found = fit(later, fitted, stiffer, frozen=range(len(later.names)))
    later.predicted(held[0], soft)
    assert np.isfinite(on_validation_runs(found, held).chi2)
