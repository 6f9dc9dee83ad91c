"""What runs that were held out say: names that they bear, refute or speak for, and how they are simulated."""

import pytest

from fmus.errors import InputError
from identification.gap.models.model import Model
from identification.gap.naming.competing import compete
from identification.gap.naming.decide import decide
from identification.gap.naming.fitted import parameters_of
from identification.gap.naming.fitting import fit
from identification.gap.naming.held_out import HeldOut
from identification.gap.naming.showing import on_holdout, surprise
from identification.gap.reporting.verdict import as_result
from scenarios.rig_test import rig_test

pytest.importorskip("numba", reason="the simulator of the hidden effects is compiled by numba")
import numpy as np
from simulators.hidden_rig import RIDER, sweep
from simulators.rig_runs import RIG, library, runs_of


def test_a_form_that_fails_further_out_leaves_its_family_or_another_form():
    """Arms that stiffen exponentially: at two thirds of the held-out run's angle a cubic is as good."""
    runs = runs_of({"kx": 60.0}, sweep(0.5, 12, 2.0, 100.0), sweep(12, 0.5, 3.0, 100.0))
    plain = [e for e in library("hardening_stiffness") if e.form != "exponential"]
    verdict = decide(Model(rig_test(RIG)), runs[:1], plain, runs[1:])
    assert (verdict.verdict, [c.family for c in verdict.effects], verdict.open_form) == ("named", ["hardening_stiffness"], True)
    assert any("parameters are those of the nearest form" in sentence for sentence in as_result(verdict, "N.m")["limitations"])
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


def test_what_errors_of_the_values_explain_refutes_no_name():
    """A drift that one sweep tells to a tenth: as fitted it misses the sweep down by far, within its errors it does not."""
    runs = runs_of({"rk": 0.5}, sweep(0.5, 12, 1.5, 100.0), sweep(12, 0.5, 2.0, 80.0), seed=1)
    verdict = decide(Model(rig_test({})), runs[:1], library("drift", "channel_delay"), runs[1:])
    assert (verdict.verdict, [c.family for c in verdict.effects]) == ("named", ["drift"])
    held = on_holdout(verdict.best, runs[1:])
    assert held.chi2 > 2  # all frozen
    assert surprise(verdict.best, held) == pytest.approx(1.0, abs=0.2)  # 448 numbers: 3 standard deviations
    said = as_result(verdict, "N.m")["limitations"]
    assert any("too uncertain to foretell" in sentence for sentence in said)


def test_a_held_out_run_that_was_not_foretold_leaves_no_none():
    """Arms that stiffen while a slow sweep is below what they are felt at; the run that is held out begins with them soft."""
    runs = runs_of({"re": 0.5}, sweep(0.2, 8, 2.3, 120.0, logarithmic=True), sweep(8, 0.2, 3.0, 100.0, logarithmic=True))
    model, families = Model(rig_test(RIG)), library("asymmetry", "added_inertia")
    assert decide(model, runs[:1], families).verdict == "none"
    verdict = decide(model, runs[:1], families, runs[1:])
    assert verdict.verdict == "unknown"
    assert any("Fit that run too" in sentence for sentence in as_result(verdict, "N.m")["limitations"])


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
    without, with_it = verdict.held_out
    assert without.chi2 == pytest.approx(with_it.chi2), "nothing was found: what the base leaves there is shown all the same"


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
