"""What a verdict makes of families that come near, of forms that fail further out, and of effects that only a fit can reach."""

from types import SimpleNamespace

import pytest

from fmus.effects.memory import NARROWEST
from fmus.errors import InputError
from identification.gap.models.model import Model
from identification.gap.naming import competing, joining, pairs
from identification.gap.naming.candidate import Candidate, adequate, one_each
from identification.gap.naming.competing import compete
from identification.gap.naming.decide import decide
from identification.gap.naming.fitted import parameters_of
from identification.gap.naming.fitting import fit, lost
from identification.gap.naming.held_out import HeldOut
from identification.gap.naming.pairs import SECOND, Pair
from identification.gap.naming.showing import on_holdout, surprise
from identification.gap.naming.starting import fit_base
from identification.gap.reporting.verdict import as_result
from scenarios.rig_test import rig_test

pytest.importorskip("numba", reason="the simulator of the hidden effects is compiled by numba")
import numpy as np
from simulators.hidden_rig import RIDER, stepped, sweep
from simulators.rig_runs import RIG, library, runs_of


def test_a_family_that_only_comes_near_is_no_open_form():
    """Arms that soften: a sensor whose gain falls with the load closes three quarters of the gap, and is not it."""
    runs = runs_of({"k3": -2300.0}, sweep(0.5, 12, 2.5, 100.0), sweep(12, 0.5, 3.2, 100.0))
    verdict = decide(Model(rig_test(RIG)), runs[:1], library("sensor_nonlinearity"), runs[1:])
    assert verdict.candidates[0].fit.reduced - 1 < 0.5 * (verdict.base.reduced - 1), "it does come near"
    assert (verdict.verdict, verdict.effects) == ("unknown", [])


def test_a_form_that_fails_further_out_leaves_its_family_or_another_form():
    """Arms that stiffen exponentially: at two thirds of the held-out run's angle a cubic is as good."""
    runs = runs_of({"kx": 60.0}, sweep(0.5, 12, 2.0, 100.0), sweep(12, 0.5, 3.0, 100.0))
    plain = [e for e in library("hardening_stiffness") if e.form != "exponential"]
    verdict = decide(Model(rig_test(RIG)), runs[:1], plain, runs[1:])
    assert (verdict.verdict, [c.family for c in verdict.effects], verdict.open_form) == ("named", ["hardening_stiffness"], True)
    assert any("parameters are those of the nearest form" in sentence for sentence in as_result(verdict, verdict.held_out, "N.m")["limitations"])
    assert decide(Model(rig_test(RIG)), runs[:1], plain).open_form is False
    verdict = decide(Model(rig_test(RIG)), runs[:1], library("hardening_stiffness"), runs[1:])
    assert (verdict.verdict, [c.effect.form for c in verdict.effects], verdict.open_form) == ("named", ["exponential"], False)
    width, error, _ = parameters_of(verdict.best)["device.hardening_stiffness.width"]
    assert width == pytest.approx(0.03, abs=2 * error) and error < 0.02


def test_held_out_runs_that_speak_for_an_effect_make_up_for_errors_of_its_values():
    """A grip that creeps: a sweep up hardly tells how fast, the sweep down is missed by far, and both together fit."""
    runs = runs_of({"rl": 0.5}, sweep(0.5, 12, 3, 100.0, logarithmic=True), sweep(12, 0.5, 3.9, 80.0, logarithmic=True))
    verdict = decide(Model(rig_test(RIG)), runs[:1], library("drift", "channel_delay", "shaft_compliance"), runs[1:])
    assert (verdict.verdict, [c.family for c in verdict.effects]) == ("named", ["drift"])
    held = HeldOut(runs[1:])
    assert held.missed(verdict.best) > 0.15 * held.missed(verdict.base) > 1, "frozen, it closes too little"
    assert held.together(verdict.best) < 0.3 < held.together(verdict.base)  # 350 numbers: 4 standard deviations
    rivals = [c for c in verdict.candidates if c.family == "channel_delay"]
    assert rivals and all(held.refute(verdict.base, c.fit) for c in rivals)


def test_the_zero_of_the_angle_is_felt_by_no_play():
    """A sensor that is off by four times the gap; whoever holds the bar is at rest about where it swings."""
    runs = runs_of({"g": 3e-4}, sweep(1, 10, 2, 100.0), angle_offset=0.02)
    play = [e for e in library("backlash") if e.form == "gap"]
    model = Model(rig_test(RIG), play)
    start = np.append(fit_base(Model(rig_test(RIG)), runs).shared, 1e-4)
    found = fit(model, runs, start)
    assert found.reduced < 1.15  # 580 numbers: 2.5 standard deviations
    half_gap, error, _ = parameters_of(found)["device.backlash.half_gap"]
    assert half_gap == pytest.approx(3e-4, abs=3 * error) and error < 1e-5


def test_arms_that_stiffen_have_no_play_that_is_wider_than_the_motion(monkeypatch):
    """Of three times the motion's width, a play with a soft transition is nothing but a spring that stiffens: d/w - tanh(d/w) = d^3/(3 w^3)."""
    runs = runs_of({"kd": 1200.0}, sweep(0.5, 12, 2, 100.0), sweep(12, 0.5, 2.6, 80.0))
    some = library("hardening_stiffness", "backlash")
    verdict = decide(Model(rig_test(RIG)), runs[:1], some, runs[1:])
    assert (verdict.verdict, [c.family for c in verdict.effects]) == ("named", ["hardening_stiffness"])
    monkeypatch.setattr(next(e for e in some if e.form == "soft"), "at_most", {})
    assert decide(Model(rig_test(RIG)), runs[:1], some, runs[1:]).verdict == "tied"


def test_a_loop_that_closes_at_once_is_no_hysteresis():
    """Arms that rub: a loop narrower than a hundredth of the motion is fitted as one of that width."""
    runs = runs_of({"Fd": 0.5, "wd": 7e-4}, sweep(0.5, 3.5, 6, 60.0))
    base = fit_base(Model(rig_test(RIG)), runs)
    found = [c.fit for c in compete(base, [e for e in library("hysteresis") if e.form == "dahl"]) if c.fitted]
    assert found[0].model.values(found[0].shared)["device.hysteresis.width"] == pytest.approx(NARROWEST * base.model.largest(runs), rel=1e-6)


def test_a_name_that_leaves_most_of_a_clear_misfit_is_taken_back():
    """A bar that cogs, with a little friction: friction closes two fifths of the gap, and what it leaves is still as noise might leave it."""
    runs = runs_of({"Ar": 0.034, "Tc": 0.06}, sweep(0.5, 12, 2, 100.0))
    verdict = decide(Model(rig_test(RIG)), runs, library("coulomb_friction", "progressive_damping"))
    assert verdict.candidates[0].family == "coulomb_friction" and adequate(verdict.candidates[0].fit)
    assert (verdict.verdict, verdict.effects, verdict.unlisted) == ("unknown", [], None)


def test_what_errors_of_the_values_explain_refutes_no_name():
    """A drift that one sweep tells to a tenth: as fitted it misses the sweep down by far, within its errors it does not."""
    runs = runs_of({"rk": 0.5}, sweep(0.5, 12, 1.5, 100.0), sweep(12, 0.5, 2.0, 80.0), seed=1)
    verdict = decide(Model(rig_test({})), runs[:1], library("drift", "channel_delay"), runs[1:])
    assert (verdict.verdict, [c.family for c in verdict.effects]) == ("named", ["drift"])
    held = on_holdout(verdict.best, runs[1:])
    assert held.chi2 > 2  # all frozen
    assert surprise(verdict.best, held) == pytest.approx(1.0, abs=0.2)  # 448 numbers: 3 standard deviations
    said = as_result(verdict, verdict.held_out, "N.m")["limitations"]
    assert any("too uncertain to foretell" in sentence for sentence in said)


def test_a_held_out_run_that_was_not_foretold_leaves_no_none():
    """Arms that stiffen while a slow sweep is below what they are felt at; the run that is held out begins with them soft."""
    runs = runs_of({"re": 0.5}, sweep(0.2, 8, 2.3, 120.0, logarithmic=True), sweep(8, 0.2, 3.0, 100.0, logarithmic=True))
    model, families = Model(rig_test(RIG)), library("asymmetry", "added_inertia")
    assert decide(model, runs[:1], families).verdict == "none"
    verdict = decide(model, runs[:1], families, runs[1:])
    assert verdict.verdict == "unknown"
    assert any("Fit that run too" in sentence for sentence in as_result(verdict, verdict.held_out, "N.m")["limitations"])


def test_a_slow_recording_is_simulated_between_its_samples():
    """Six samples to a cycle at the end of the sweep, in which a loop opens and closes: on these alone its force comes out 12 % small."""
    runs = runs_of({"Fh": 1.2, "wh": 0.008}, sweep(0.5, 10.6, 1.5, 100.0), rate=64)
    verdict = decide(Model(rig_test(RIG)), runs, library("hysteresis"))
    force, error, _ = parameters_of(verdict.best)["device.hysteresis.force"]
    assert [c.family for c in verdict.effects] == ["hysteresis"]
    assert force == pytest.approx(1.2, abs=3 * error) and error < 0.02


def test_a_mode_is_found_from_starts_that_promise_little():
    """A small step towards a head at 1.5 Hz promises much, one at 5 Hz nothing; the one that is there is at 6 Hz."""
    rider = dict(zip(RIDER, (0.27, 0.878, 555.0, 66.6, 14.6, 4.53), strict=True))
    tests = sweep(1, 15, 4.0, 150.0, logarithmic=True), stepped(1, 10.5, 0.5, 6.7, 10.0)
    rig = {"rate": 100, "lag": 0.054, "angle_noise": 5e-4, "torque_noise": 0.08, "remnant": 0.95}
    runs = runs_of({"Ih": 0.0235, "fh": 6.145, "zh": 0.298}, *tests, rider=rider, **rig)
    best = compete(fit_base(Model(rig_test({})), runs), library("extra_mode"))[0]
    assert best.fit.reduced < 1.12
    assert parameters_of(best.fit)["device.extra_mode.frequency"][0] == pytest.approx(6.145, rel=0.02)


def test_an_effect_that_no_small_step_reaches_is_tried_from_elsewhere():
    """A soft shaft between servo and a light bar of unknown inertia: the base has none of it left, and the screening sees next to nothing."""
    runs = runs_of({"C": 3e-4}, sweep(1, 12.8, 0.9, 200.0), rider=dict(zip(RIDER, (0.0316, 0.685, 1301.0, 82.3, 26.2, 3.89), strict=True)), rate=64, bits=14, torque_noise=0.07, remnant=0.05)
    verdict = decide(Model(rig_test({})), runs, library("shaft_compliance", "viscoelastic_arm", "cross_inertia"))
    assert verdict.base.reduced > 30
    shaft = next(c for c in verdict.candidates if c.family == "shaft_compliance")
    assert shaft.fit.reduced < 1.12 and shaft.effect in [c.effect for c in (*verdict.effects, *verdict.tied)]


def test_an_effect_is_tried_where_the_base_has_lost_what_it_needs(monkeypatch):
    """The same with a bar that is less light and more noise: the base loses the bar's inertia, and a small step towards a soft shaft has the wrong sign."""
    rider = dict(zip(RIDER, (0.0461, 0.5787, 1200.5, 67.8, 15.04, 4.567), strict=True))
    runs = runs_of({"C": 3e-4}, sweep(1, 15, 3.0, 200.0), rider=rider, rate=100, lag=0.041, angle_noise=0.00104, torque_noise=0.4)
    base = fit_base(Model(rig_test({})), runs)
    assert lost(base) and base.reduced < joining.FAR
    some = library("shaft_compliance", "cross_inertia", "viscoelastic_arm")
    shaft = compete(base, some)[0]
    assert (shaft.family, adequate(shaft.fit)) == ("shaft_compliance", True)
    compliance, error, _ = parameters_of(shaft.fit)["shaft_compliance.compliance"]
    assert compliance == pytest.approx(3e-4, abs=3 * error) and error < 1e-5
    for where in (competing, joining):
        monkeypatch.setattr(where, "lost", lambda found: False)
    assert compete(base, some)[0].family != "shaft_compliance"


@pytest.fixture(scope="module")
def coupled():
    """Torso and bar coupled by an inertia; one sweep up to fit, one down. A drift makes up for it in one sweep, not in the other."""
    return runs_of({"Icc": 0.07}, sweep(0.5, 12, 2.5, 100.0), sweep(12, 0.5, 3.2, 100.0))


def test_what_held_out_runs_refute_leaves_room_for_the_rest(coupled, monkeypatch):
    """Where the wrong family wins at first (here it alone is heard), it does not come back, and another may."""
    heard = lambda library: [e for e in library if e.family == "drift"] or library  # noqa: E731
    monkeypatch.setattr("identification.gap.naming.decide.compete", lambda base, effects, **more: compete(base, heard(effects), **more))
    verdict = decide(Model(rig_test(RIG)), coupled[:1], library("drift", "cross_inertia"), coupled[1:])
    assert (verdict.verdict, [c.family for c in verdict.effects]) == ("named", ["cross_inertia"])
    assert verdict.refuted == ["drift"]
    assert decide(Model(rig_test(RIG)), coupled[:1], library("drift", "cross_inertia")).effects[0].family == "drift", "nothing tells it is wrong"


def drift_and_friction(best, first, *_):
    """The only pair that there is; its second effect brings nothing."""
    one, friction = (next(c for c in one_each(first) if c.family == family) for family in ("drift", "coulomb_friction"))
    model = one.fit.model.joined_by(friction.effect)
    together = fit(model, one.fit.runs, model.start())
    return [Pair(one, Candidate(friction.effect, together, one.fit.chi2 - together.chi2, 0.0))]


def test_an_effect_that_does_alone_what_a_pair_does_stands_alone(coupled, monkeypatch):
    monkeypatch.setattr("identification.gap.naming.decide.pairs_of", drift_and_friction)
    verdict = decide(Model(rig_test(RIG)), coupled[:1], library("drift", "cross_inertia", "coulomb_friction"))
    assert len(verdict.effects) < 2 and "coulomb_friction" not in {c.family for c in (*verdict.effects, *verdict.tied)}


def test_a_family_with_a_curve_of_its_own_is_rather_one_effect_than_two():
    """Damping by the root of the rate: its square misses by little, which a loop makes up for; as one effect with an open form none is wrong."""
    runs = runs_of({"cp": 0.3}, sweep(1, 10.5, 3, 150.0), sweep(10.5, 1, 3.8, 120.0), rate=64, seed=5, torque_noise=0.08, angle_noise=4e-4)
    verdict = decide(Model(rig_test(RIG)), runs[:1], library("progressive_damping", "hysteresis"), runs[1:])
    assert (verdict.verdict, [c.family for c in verdict.effects], verdict.open_form) == ("named", ["progressive_damping"], True)


def test_a_loop_between_round_and_sharp_is_found_with_its_exponent():
    """Bouc-Wen's loop with n = 3.5: those with 2 and 8 leave a third more than noise, which a bent sensor made up for."""
    runs = runs_of({"Fd": 1.2, "wd": 0.027, "nd": 3.5}, sweep(1, 10.5, 3, 150.0), sweep(10.5, 1, 3.8, 120.0), rate=128, seed=5, torque_noise=0.08, angle_noise=4e-4)
    verdict = decide(Model(rig_test(RIG)), runs[:1], library("hysteresis", "sensor_nonlinearity"), runs[1:])
    assert [c.family for c in verdict.effects] == ["hysteresis"]
    known = parameters_of(verdict.best)
    for name, true in {"force": 1.2, "width": 0.027, "sharpness": 3.5}.items():
        found, error, _ = known[f"device.hysteresis.{name}"]
        assert found == pytest.approx(true, abs=3 * error) and error < 0.05 * true


def test_a_small_effect_beside_a_large_one_is_named_where_nothing_else_explains_it():
    """A lopsided arm brings a 400th of what the delay does, and without it nothing is as good as noise."""
    runs = runs_of({"td": 8e-3, "ra": 1e-3}, sweep(0.5, 12, 3, 100.0), sweep(12, 0.5, 3.8, 100.0), torque_noise=0.04, remnant=0.1, angle_noise=2e-4, bits=16)
    verdict = decide(Model(rig_test(RIG)), runs[:1], library("channel_delay", "asymmetry", "coulomb_friction", "hysteresis"), runs[1:])
    assert {c.family for c in verdict.effects} == {"channel_delay", "asymmetry"}
    delay, lopsided = (next(c.delta_bic for c in verdict.effects if c.family == family) for family in ("channel_delay", "asymmetry"))
    assert lopsided < SECOND[1] * delay, "else it would be named for its size"
    assert adequate(verdict.best)


@pytest.mark.parametrize(("source", "asked"), [("orders", SECOND[0]), ("flexible_model", SECOND[1] * 1e5)])
def test_a_small_second_effect_is_looked_for_where_the_noise_is_known_only(source, asked, monkeypatch):
    """What a flexible model leaves of a run no form of one law reaches: every second effect would be fitted to its end."""
    effect, least = library("channel_delay")[0], []
    run = SimpleNamespace(noise_source=source)
    one = SimpleNamespace(model=SimpleNamespace(effects=(effect,)), runs=[run], reduced=1.5, freedom=1000, chi2=1500.0)
    monkeypatch.setattr(pairs, "compete", lambda *_, **settings: least.append(settings["least"]) or [])
    best = Candidate(effect, one, 1e5, 1e5)
    assert pairs.pairs_of(best, [best], library("channel_delay", "asymmetry")) == [] and least == [asked]


def test_of_a_pair_that_is_refuted_one_effect_may_stand_alone(coupled, monkeypatch):
    """Where a wrong pair wins at first (here the only one), the single effects are heard again."""
    monkeypatch.setattr("identification.gap.naming.decide.pairs_of", drift_and_friction)
    monkeypatch.setattr("identification.gap.naming.decide.alone", lambda *_: [])  # as if the second effect brought something
    families = library("drift", "cross_inertia", "coulomb_friction")
    verdict = decide(Model(rig_test(RIG)), coupled[:1], families, coupled[1:])
    assert (verdict.verdict, [c.family for c in verdict.effects]) == ("named", ["cross_inertia"])
    assert verdict.refuted[0] == "drift and coulomb_friction"


def test_a_family_is_fitted_though_others_promise_more():
    run = runs_of({"C": 2.8e-4}, sweep(0.5, 12, 2.0, 100.0))
    base = fit_base(Model(rig_test(RIG)), run)
    families = library("drift", "channel_delay", "shaft_compliance", "cross_inertia", "viscoelastic_arm")
    fitted = {others: {c.family for c in compete(base, families, leaders=3, others=others) if c.fitted} for others in (False, True)}
    assert fitted[True] == {e.family for e in families}
    assert len(fitted[False]) < len(fitted[True])


def test_a_rival_that_cannot_be_taken_further_stays_where_it_is(monkeypatch):
    run = runs_of({"k3": 2e4}, sweep(0.5, 12, 2.0, 60.0))
    base = fit_base(Model(rig_test(RIG)), run)
    found = [c for c in compete(base, library("hardening_stiffness")) if c.fitted]

    def diverges(*_):
        raise InputError("the simulation diverges")

    monkeypatch.setattr(joining, "CLEAR", -np.inf)  # all of them are rivals that crept
    monkeypatch.setattr("identification.gap.naming.fitting.fit", diverges)
    assert {id(c) for c in joining.finished(base, found)} == {id(c) for c in found}


def test_nothing_rests_on_what_can_be_simulated_only_on_the_way_to_a_fit(monkeypatch):
    run = runs_of({"k3": 2e4}, sweep(0.5, 12, 2.0, 60.0))
    plain = Model.with_noise_beside

    def diverges(self, run, q):
        if self.effects:
            raise InputError("the simulation diverges")
        return plain(self, run, q)

    monkeypatch.setattr(Model, "with_noise_beside", diverges)
    verdict = decide(Model(rig_test(RIG)), run, library("hardening_stiffness"))
    assert (verdict.verdict, verdict.effects) == ("unknown", [])
    assert verdict.best is verdict.base


def test_nothing_rests_on_what_cannot_be_simulated_on_the_held_out_run(coupled, monkeypatch):
    def diverges(found, runs):
        if found.model.effects:
            raise InputError("the simulation diverges")
        return on_holdout(found, runs)

    monkeypatch.setattr(HeldOut, "refute", lambda *_: False)
    for place in ("held_out", "showing"):
        monkeypatch.setattr(f"identification.gap.naming.{place}.on_holdout", diverges)
    verdict = decide(Model(rig_test(RIG)), coupled[:1], library("cross_inertia"), coupled[1:])
    assert (verdict.verdict, verdict.effects) == ("unknown", [])
    assert not verdict.best.model.effects


def test_a_simulation_starts_from_the_last_states_of_the_recording(coupled):
    model, run = Model(rig_test(RIG)), coupled[0]
    y = model.outputs(run, model.start(), slopes=False)[0]
    assert model._guess(run.with_noise_beside(y)) is not None


def test_what_was_simulated_of_one_run_is_not_taken_for_another(coupled):
    model, (one, other) = Model(rig_test(RIG)), coupled
    expected = Model(rig_test(RIG)).outputs(other, model.start())[0]
    model.outputs(one, model.start(), slopes=False)
    model.fresh[id(other)] = model.fresh.pop(id(one))  # as where one is gone, and the other lies where it was
    np.testing.assert_allclose(model.outputs(other, model.start())[0], expected, atol=1e-6 * np.abs(expected).max())  # twice the same


def test_friction_that_gives_way_like_bristles_needs_no_plain_friction_to_lead_to_it():
    """LuGre's friction [N.m] at small angles: to plain friction the data are so unlike that a sensor leads by far."""
    rider = {"Is": 0.33, "It": 0.74, "ka": 1112.0, "kt": 58.6, "ca": 24.5, "ct": 4.8}
    runs = runs_of({"Tl": 0.26}, sweep(0.5, 15, 1.2, 60.0), rider=rider, rate=256, torque_noise=0.09, remnant=0.2)
    verdict = decide(Model(rig_test({})), runs, library("coulomb_friction", "sensor_nonlinearity"))
    assert [(c.family, c.effect.form) for c in verdict.effects] == [("coulomb_friction", "bristles")]
    found, error, _ = parameters_of(verdict.best)["device.coulomb_friction.force"]
    assert found == pytest.approx(0.26, abs=3 * error) and error < 0.03


def test_a_held_out_run_that_cannot_be_simulated_at_once_is_led_in():
    """Arms that stiffen twentyfold: on a run that is new the motion is nowhere near a guess, and a right name used to be taken back."""
    rider = dict(zip(RIDER, (0.337, 0.531, 667.0, 82.0, 5.3, 2.47), strict=True))
    fitted, held = (runs_of({"kx": 42.0}, sweep(*ends, 40.0), rider=rider, rate=64) for ends in ((1, 8, 2.6), (8, 1, 3.4)))
    verdict = decide(Model(rig_test({})), fitted, [e for e in library("hardening_stiffness") if e.form in ("cubic", "exponential")], held)
    assert (verdict.verdict, [c.effect.form for c in verdict.effects], verdict.refuted) == ("named", ["exponential"], [])
    assert HeldOut(held).missed(verdict.best) < 1e-3 * HeldOut(held).missed(verdict.base)
    later, stiffer = verdict.base.model.joined_by(verdict.effects[0].effect), verdict.best.shared.copy()
    stiffer[later.names.index("device.hardening_stiffness.cubic_stiffness")] *= 2  # it knows that run from the base alone, whose motion leads nowhere here
    assert np.all(np.isfinite(later.predicted(held[0], stiffer)))
    soft = np.where(np.arange(len(stiffer)) == later.names.index("device.hardening_stiffness.cubic_stiffness"), 0.0, stiffer)
    later.predicted(held[0], soft)
    with pytest.raises(InputError, match="diverges"):
        later.predicted(held[0], stiffer)  # no trial of a fit is led in
    assert np.all(np.isfinite(later.with_noise_beside(held[0], stiffer).deviation))
    found = fit(later, fitted, stiffer, frozen=range(len(later.names)))
    later.predicted(held[0], soft)
    assert np.isfinite(on_holdout(found, held).chi2)
