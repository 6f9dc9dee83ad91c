"""What a verdict makes of families that come near, and of effects that only a fit can reach."""

import pytest

from fmus.effects.hysteresis import NARROWEST
from fmus.support.errors import InputError
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation import effect_fit, screening
from motofmi.gap.estimation.candidate import adequate
from motofmi.gap.estimation.fit_result import parameters_of
from motofmi.gap.estimation.fitting import fit, has_vanished_parameter
from motofmi.gap.estimation.multi_start import fit_base
from motofmi.gap.models.harmonic_model import HarmonicModel
from motofmi.gap.selection import candidate_search
from motofmi.gap.selection.candidate_search import search_candidates
from motofmi.gap.selection.model_selection import select_model
from motofmi.workflows.gap.rig import rig_experiment

pytest.importorskip("numba", reason="the simulator of the hidden effects is compiled by numba")
import numpy as np

from tests.simulators.hidden_rig import RIDER, stepped, sweep
from tests.simulators.rig_runs import RIG, library, runs_of


@pytest.mark.slow
def test_a_family_that_only_comes_near_has_no_unspecified_form():
    """Arms that soften: a sensor whose gain falls with the load closes three quarters of the gap, and is not it."""
    runs = runs_of({"k3": -2300.0}, sweep(0.5, 12, 2.5, 100.0), sweep(12, 0.5, 3.2, 100.0))
    verdict = select_model(HarmonicModel(rig_experiment(RIG)), runs[:1], library("sensor_nonlinearity"), runs[1:])
    assert verdict.candidates[0].fit.reduced - 1 < 0.5 * (verdict.base.reduced - 1), "it does come near"
    assert (verdict.verdict, verdict.effects) == ("unknown", [])


@pytest.mark.slow
def test_a_sensor_offset_of_the_angle_is_not_play():
    """A sensor offset of four times the gap; whoever holds the bar is at rest about where it swings."""
    runs = runs_of({"g": 3e-4}, sweep(1, 10, 2, 100.0), angle_offset=0.02)
    play = [e for e in library("backlash") if e.form == "gap"]
    model = HarmonicModel(rig_experiment(RIG), play)
    start = np.append(fit_base(HarmonicModel(rig_experiment(RIG)), runs).shared, 1e-4)
    found = fit(model, runs, start)
    assert found.reduced < 1.15  # 580 numbers: 2.5 standard deviations
    half_gap, error, _ = parameters_of(found)["device.backlash.half_gap"]
    assert half_gap == pytest.approx(3e-4, abs=3 * error) and error < 1e-5


@pytest.mark.study
def test_arms_that_stiffen_have_no_play_that_is_wider_than_the_motion(monkeypatch):
    """Of three times the motion's width, a play with a soft transition is nothing but a spring that stiffens: d/w -
    tanh(d/w) = d^3/(3 w^3)."""
    runs = runs_of({"kd": 1200.0}, sweep(0.5, 12, 2, 100.0), sweep(12, 0.5, 2.6, 80.0))
    some = library("hardening_stiffness", "backlash")
    verdict = select_model(HarmonicModel(rig_experiment(RIG)), runs[:1], some, runs[1:])
    assert (verdict.verdict, [c.family for c in verdict.effects]) == ("named", ["hardening_stiffness"])
    monkeypatch.setattr(next(e for e in some if e.form == "soft"), "at_most", {})
    assert select_model(HarmonicModel(rig_experiment(RIG)), runs[:1], some, runs[1:]).verdict == "tied"


@pytest.mark.slow
def test_a_loop_that_closes_at_once_is_no_hysteresis():
    """Arms that rub: a loop narrower than a hundredth of the motion is fitted as one of that width."""
    runs = runs_of({"Fd": 0.5, "wd": 7e-4}, sweep(0.5, 3.5, 6, 60.0))
    base = fit_base(HarmonicModel(rig_experiment(RIG)), runs)
    found = [c.fit for c in search_candidates(base, [e for e in library("hysteresis") if e.form == "dahl"]) if c.fitted]
    assert found[0].model.values(found[0].shared)["device.hysteresis.width"] == pytest.approx(
        NARROWEST * base.model.largest(runs), rel=1e-6
    )


@pytest.mark.slow
def test_an_effect_that_leaves_most_of_a_clear_misfit_is_not_named():
    """A bar that cogs, with a little friction: friction closes two fifths of the gap, and what it leaves is still as
    noise might leave it."""
    runs = runs_of({"Ar": 0.034, "Tc": 0.06}, sweep(0.5, 12, 2, 100.0))
    verdict = select_model(HarmonicModel(rig_experiment(RIG)), runs, library("coulomb_friction", "progressive_damping"))
    assert verdict.candidates[0].family == "coulomb_friction" and adequate(verdict.candidates[0].fit, Criteria())
    assert (verdict.verdict, verdict.effects, verdict.outside_library) == ("unknown", [], None)


@pytest.mark.slow
def test_a_slow_recording_is_simulated_between_its_samples():
    """Six samples to a cycle at the end of the sweep, in which a loop opens and closes: on these alone its force comes
    out 12 % small."""
    runs = runs_of({"Fh": 1.2, "wh": 0.008}, sweep(0.5, 10.6, 1.5, 100.0), rate=64)
    verdict = select_model(HarmonicModel(rig_experiment(RIG)), runs, library("hysteresis"))
    force, error, _ = parameters_of(verdict.best)["device.hysteresis.force"]
    assert [c.family for c in verdict.effects] == ["hysteresis"]
    assert force == pytest.approx(1.2, abs=3 * error) and error < 0.02


@pytest.mark.slow
@pytest.mark.study
def test_a_mode_is_found_from_starts_with_a_small_screened_gain():
    """A small step towards a head at 1.5 Hz promises much, one at 5 Hz nothing; the one that is there is at 6 Hz."""
    rider = dict(zip(RIDER, (0.27, 0.878, 555.0, 66.6, 14.6, 4.53), strict=True))
    tests = sweep(1, 15, 4.0, 150.0, logarithmic=True), stepped(1, 10.5, 0.5, 6.7, 10.0)
    rig = {"rate": 100, "lag": 0.054, "angle_noise": 5e-4, "torque_noise": 0.08, "remnant": 0.95}
    runs = runs_of({"Ih": 0.0235, "fh": 6.145, "zh": 0.298}, *tests, rider=rider, **rig)
    best = search_candidates(fit_base(HarmonicModel(rig_experiment({})), runs), library("extra_mode"))[0]
    assert best.fit.reduced < 1.12
    assert parameters_of(best.fit)["device.extra_mode.frequency"][0] == pytest.approx(6.145, rel=0.02)


@pytest.mark.study
def test_an_effect_that_no_small_step_reaches_is_tried_from_elsewhere():
    """A soft shaft between servo and a light bar of unknown inertia: the base has none of it left, and the screening
    sees next to nothing."""
    runs = runs_of(
        {"C": 3e-4},
        sweep(1, 12.8, 0.9, 200.0),
        rider=dict(zip(RIDER, (0.0316, 0.685, 1301.0, 82.3, 26.2, 3.89), strict=True)),
        rate=64,
        bits=14,
        torque_noise=0.07,
        remnant=0.05,
    )
    verdict = select_model(
        HarmonicModel(rig_experiment({})), runs, library("shaft_compliance", "viscoelastic_arm", "cross_inertia")
    )
    assert verdict.base.reduced > 30
    shaft = next(c for c in verdict.candidates if c.family == "shaft_compliance")
    assert shaft.fit.reduced < 1.12 and shaft.effect in [c.effect for c in (*verdict.effects, *verdict.tied)]


@pytest.mark.slow
@pytest.mark.study
def test_an_effect_is_tried_where_the_base_has_lost_what_it_needs(monkeypatch):
    """The same with a bar that is less light and more noise: the base loses the bar's inertia, and a small step towards
    a soft shaft has the wrong sign."""
    rider = dict(zip(RIDER, (0.0461, 0.5787, 1200.5, 67.8, 15.04, 4.567), strict=True))
    runs = runs_of(
        {"C": 3e-4}, sweep(1, 15, 3.0, 200.0), rider=rider, rate=100, lag=0.041, angle_noise=0.00104, torque_noise=0.4
    )
    base = fit_base(HarmonicModel(rig_experiment({})), runs)
    assert has_vanished_parameter(base) and base.reduced < screening.FAR
    some = library("shaft_compliance", "cross_inertia", "viscoelastic_arm")
    shaft = search_candidates(base, some)[0]
    assert (shaft.family, adequate(shaft.fit, Criteria())) == ("shaft_compliance", True)
    compliance, error, _ = parameters_of(shaft.fit)["shaft_compliance.compliance"]
    assert compliance == pytest.approx(3e-4, abs=3 * error) and error < 1e-5
    for where in (candidate_search, effect_fit):
        monkeypatch.setattr(where, "has_vanished_parameter", lambda found: False)
    assert search_candidates(base, some)[0].family != "shaft_compliance"


@pytest.mark.study
def test_a_family_is_fitted_although_others_have_larger_screened_gains():
    run = runs_of({"C": 2.8e-4}, sweep(0.5, 12, 2.0, 100.0))
    base = fit_base(HarmonicModel(rig_experiment(RIG)), run)
    families = library("drift", "channel_delay", "shaft_compliance", "cross_inertia", "viscoelastic_arm")
    fitted = {
        others: {c.family for c in search_candidates(base, families, leaders=3, others=others) if c.fitted}
        for others in (False, True)
    }
    assert fitted[True] == {e.family for e in families}
    assert len(fitted[False]) < len(fitted[True])


@pytest.mark.slow
def test_a_rival_that_cannot_be_taken_further_stays_where_it_is(monkeypatch):
    run = runs_of({"k3": 2e4}, sweep(0.5, 12, 2.0, 60.0))
    base = fit_base(HarmonicModel(rig_experiment(RIG)), run)
    found = [c for c in search_candidates(base, library("hardening_stiffness")) if c.fitted]

    def diverges(*_):
        raise InputError("the simulation diverges")

    monkeypatch.setattr("motofmi.gap.estimation.fitting.fit", diverges)
    assert {id(c) for c in effect_fit.fitted_to_the_end(base, found, Criteria(clear_lead_delta_bic=-np.inf))} == {
        id(c) for c in found
    }


@pytest.mark.slow
def test_nothing_rests_on_what_can_be_simulated_only_on_the_way_to_a_fit(monkeypatch):
    run = runs_of({"k3": 2e4}, sweep(0.5, 12, 2.0, 60.0))
    plain = HarmonicModel.with_remaining_noise

    def diverges(self, run, q):
        if self.effects:
            raise InputError("the simulation diverges")
        return plain(self, run, q)

    monkeypatch.setattr(HarmonicModel, "with_remaining_noise", diverges)
    verdict = select_model(HarmonicModel(rig_experiment(RIG)), run, library("hardening_stiffness"))
    assert (verdict.verdict, verdict.effects) == ("unknown", [])
    assert verdict.best is verdict.base


@pytest.mark.slow
def test_friction_that_gives_way_like_bristles_needs_no_plain_friction_to_lead_to_it():
    """LuGre's friction [N.m] at small angles: to plain friction the data are so unlike that a sensor leads by far."""
    rider = {"Is": 0.33, "It": 0.74, "ka": 1112.0, "kt": 58.6, "ca": 24.5, "ct": 4.8}
    runs = runs_of({"Tl": 0.26}, sweep(0.5, 15, 1.2, 60.0), rider=rider, rate=256, torque_noise=0.09, remnant=0.2)
    verdict = select_model(HarmonicModel(rig_experiment({})), runs, library("coulomb_friction", "sensor_nonlinearity"))
    assert [(c.family, c.effect.form) for c in verdict.effects] == [("coulomb_friction", "bristles")]
    found, error, _ = parameters_of(verdict.best)["device.coulomb_friction.force"]
    assert found == pytest.approx(0.26, abs=3 * error) and error < 0.03
