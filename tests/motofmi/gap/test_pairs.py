"""When two effects are named, and when one does alone what two do."""

from types import SimpleNamespace

import numpy as np
import pytest

from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import Candidate, adequate, one_each, undetermined_magnitude
from motofmi.gap.estimation.fit_result import parameters_of
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.models.harmonic_model import HarmonicModel
from motofmi.gap.selection import pairs
from motofmi.gap.selection.model_selection import select_model
from motofmi.gap.selection.pairs import Pair
from motofmi.workflows.gap.rig import rig_experiment

pytest.importorskip("numba", reason="the simulator of the hidden effects is compiled by numba")
from tests.simulators.hidden_rig import sweep
from tests.simulators.rig_runs import RIG, library, runs_of


@pytest.fixture(scope="module")
def coupled():
    """Torso and bar coupled by an inertia; one sweep up to fit, one down. A drift makes up for it in one sweep, not in
    the other."""
    return runs_of({"Icc": 0.07}, sweep(0.5, 12, 2.5, 100.0), sweep(12, 0.5, 3.2, 100.0))


def drift_and_friction(best, first, *_):
    """The only pair that there is; its second effect brings nothing."""
    one, friction = (next(c for c in one_each(first) if c.family == family) for family in ("drift", "coulomb_friction"))
    model = one.fit.model.with_added_effects(friction.effect)
    together = fit(model, one.fit.runs, model.start())
    return [Pair(one, Candidate(friction.effect, together, one.fit.chi2 - together.chi2, 0.0))]


@pytest.mark.slow
def test_a_single_effect_is_selected_where_it_fits_as_well_as_a_pair(coupled, monkeypatch):
    monkeypatch.setattr("motofmi.gap.selection.model_selection.pairs_of", drift_and_friction)
    verdict = select_model(
        HarmonicModel(rig_experiment(RIG)), coupled[:1], library("drift", "cross_inertia", "coulomb_friction")
    )
    assert len(verdict.effects) < 2 and "coulomb_friction" not in {c.family for c in (*verdict.effects, *verdict.tied)}


@pytest.mark.slow
def test_an_effect_that_vanishes_beside_another_has_an_undetermined_magnitude():
    """Friction is in the data, a reflex is not: fitted with it, its gain is within its error of zero."""
    runs = runs_of({"Tc": 0.5}, sweep(0.5, 12, 2.5, 60.0))
    model = HarmonicModel(rig_experiment(RIG))
    friction, reflex = (library(family)[0] for family in ("coulomb_friction", "reflex"))
    for effects, name in (((friction,), None), ((friction, reflex), "reflex")):
        both = model.with_added_effects(*effects)
        found = fit(both, runs, both.start())
        undetermined = undetermined_magnitude(found, np.sqrt(np.diag(found.covariance())), Criteria())
        assert (undetermined is None) if name is None else name in undetermined[0]


@pytest.mark.study
def test_a_family_with_a_curve_of_its_own_is_rather_one_effect_than_two():
    """Damping in proportion to the root of the rate: the library's square of the rate leaves a small residual.

    A hysteresis loop as a second effect would fit it; one effect with an unspecified form is correct.
    """
    runs = runs_of(
        {"cp": 0.3},
        sweep(1, 10.5, 3, 150.0),
        sweep(10.5, 1, 3.8, 120.0),
        rate=64,
        seed=5,
        torque_noise=0.08,
        angle_noise=4e-4,
    )
    verdict = select_model(
        HarmonicModel(rig_experiment(RIG)), runs[:1], library("progressive_damping", "hysteresis"), runs[1:]
    )
    assert (verdict.verdict, [c.family for c in verdict.effects], verdict.unspecified_form) == (
        "named",
        ["progressive_damping"],
        True,
    )


@pytest.mark.study
def test_a_loop_between_round_and_sharp_is_found_with_its_exponent():
    """Bouc-Wen's loop with n = 3.5: those with 2 and 8 leave a third more than noise, which a bent sensor made up
    for."""
    runs = runs_of(
        {"Fd": 1.2, "wd": 0.027, "nd": 3.5},
        sweep(1, 10.5, 3, 150.0),
        sweep(10.5, 1, 3.8, 120.0),
        rate=128,
        seed=5,
        torque_noise=0.08,
        angle_noise=4e-4,
    )
    verdict = select_model(
        HarmonicModel(rig_experiment(RIG)), runs[:1], library("hysteresis", "sensor_nonlinearity"), runs[1:]
    )
    assert [c.family for c in verdict.effects] == ["hysteresis"]
    known = parameters_of(verdict.best)
    for name, true in {"force": 1.2, "width": 0.027, "sharpness": 3.5}.items():
        found, error, _ = known[f"device.hysteresis.{name}"]
        assert found == pytest.approx(true, abs=3 * error) and error < 0.05 * true


@pytest.mark.study
def test_a_small_effect_beside_a_large_one_is_named_where_nothing_else_explains_it():
    """A lopsided arm brings a 400th of what the delay does, and without it nothing is consistent with the noise."""
    runs = runs_of(
        {"td": 8e-3, "ra": 1e-3},
        sweep(0.5, 12, 3, 100.0),
        sweep(12, 0.5, 3.8, 100.0),
        torque_noise=0.04,
        remnant=0.1,
        angle_noise=2e-4,
        bits=16,
    )
    verdict = select_model(
        HarmonicModel(rig_experiment(RIG)),
        runs[:1],
        library("channel_delay", "asymmetry", "coulomb_friction", "hysteresis"),
        runs[1:],
    )
    assert {c.family for c in verdict.effects} == {"channel_delay", "asymmetry"}
    delay, lopsided = (
        next(c.delta_bic for c in verdict.effects if c.family == family) for family in ("channel_delay", "asymmetry")
    )
    assert lopsided < Criteria().second_effect_share * delay, "else it would be named for its size"
    assert adequate(verdict.best, Criteria())


@pytest.mark.parametrize(
    ("source", "asked"),
    [("orders", Criteria().second_effect_delta_bic), ("flexible_model", Criteria().second_effect_share * 1e5)],
)
def test_a_small_second_effect_is_looked_for_where_the_noise_is_known_only(source, asked, monkeypatch):
    """What a flexible model leaves of a run no form of one law reaches: every second effect would be fitted to its
    end."""
    effect, least = library("channel_delay")[0], []
    run = SimpleNamespace(noise_source=source)
    one = SimpleNamespace(model=SimpleNamespace(effects=(effect,)), runs=[run], reduced=1.5, freedom=1000, chi2=1500.0)
    monkeypatch.setattr(pairs, "search_candidates", lambda *_, **settings: least.append(settings["least"]) or [])
    best = Candidate(effect, one, 1e5, 1e5)
    assert pairs.pairs_of(best, [best], library("channel_delay", "asymmetry")) == [] and least == [asked]


@pytest.mark.study
def test_one_effect_of_a_rejected_pair_may_be_selected_alone(coupled, monkeypatch):
    """A wrong pair is selected first (here it is the only one); after its rejection single effects are candidates
    again."""
    monkeypatch.setattr("motofmi.gap.selection.model_selection.pairs_of", drift_and_friction)
    monkeypatch.setattr(
        "motofmi.gap.selection.model_selection.single_effects_instead", lambda *_: []
    )  # as if the second effect brought something
    families = library("drift", "cross_inertia", "coulomb_friction")
    verdict = select_model(HarmonicModel(rig_experiment(RIG)), coupled[:1], families, coupled[1:])
    assert (verdict.verdict, [c.family for c in verdict.effects]) == ("named", ["cross_inertia"])
    assert verdict.rejected[0] == "drift and coulomb_friction"
