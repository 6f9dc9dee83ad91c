"""Nothing is named in place of an effect that cannot be simulated on the validation runs."""

import numpy as np
import pytest

import motofmi as mf
from motofmi.gap.comparison.compared_model import CommonBlocks
from motofmi.recordings.recording import Recording
from tests.few_laws import only_families
from tests.simulators.three_sines import three_sines

FRICTION = 2.0  # N


def rubbing(name: str, seed: int) -> Recording:
    """20 s at 100 Hz of a mass of 1 kg that is moved along three sines: its force with dry friction and noise."""
    generator, time = np.random.default_rng(seed), np.arange(2000) / 100
    x, v, a = three_sines(generator, time)
    force = a + 2 * v + 40 * x + FRICTION * np.sign(v) + 0.05 * generator.standard_normal(len(time))
    return Recording(name, time, {"force": force, "displacement": x}, {"force": "N", "displacement": "m"})


def gap_of_friction():
    return mf.find_gap(
        [rubbing("fitted", 1)], validation=[rubbing("held", 2)], component="mass_spring_damper", impose="displacement"
    ).to_dict()


@pytest.fixture(autouse=True)
def compared_on_blocks(monkeypatch):
    monkeypatch.setattr("motofmi.gap.selection.staged_selection.leaves_noise", lambda *_: False)
    only_families(monkeypatch)


def test_an_effect_is_named_although_a_pair_that_contains_it_cannot_be_simulated(monkeypatch):
    refined = CommonBlocks.refined_and_evaluated

    def without_pairs(blocks, fits, description):
        pairs = [found for found in fits if len(found.model.effects) > 1]
        blocks.not_simulated += pairs
        return refined(blocks, [found for found in fits if found not in pairs], description)

    losses = CommonBlocks.fitted_losses
    monkeypatch.setattr(CommonBlocks, "refined_and_evaluated", without_pairs)
    monkeypatch.setattr(
        CommonBlocks, "fitted_losses", lambda self, found: losses(self, found) - 5.0 * (len(found.model.effects) > 1)
    )  # every pair has less loss on the fitted runs than friction alone
    found = gap_of_friction()
    assert [e["name"] for e in found["effects"]] == ["coulomb_friction"]


@pytest.mark.parametrize("simulated", [True, False])
def test_nothing_is_named_in_place_of_an_effect_that_cannot_be_simulated(monkeypatch, simulated):
    evaluated = CommonBlocks.evaluated

    def unless_friction(blocks, found):
        rubs = "coulomb_friction" in {effect.family for effect in found.model.effects}
        return evaluated(blocks, found) if simulated or not rubs else None

    monkeypatch.setattr(CommonBlocks, "evaluated", unless_friction)
    if not simulated:  # no law takes the place of an effect that could not be compared
        monkeypatch.setattr("motofmi.gap.comparison.compare.sufficient_law", lambda *_: pytest.fail("a law is compared"))
    found = gap_of_friction()
    begin = "No effect is named: with coulomb_friction the loss on the fitted runs is clearly less"
    said = [s for s in found["limitations"] if s.startswith(begin)]
    assert bool(said) is not simulated
    assert [e["name"] for e in found["effects"]] == (["coulomb_friction"] if simulated else [])


@pytest.mark.parametrize(("lead", "withheld"), [(0.01, False), (5.0, True)])
def test_an_effect_that_cannot_be_simulated_and_leads_by_chance_is_no_reason(monkeypatch, lead, withheld):
    evaluated, losses, of_base = CommonBlocks.evaluated, CommonBlocks.fitted_losses, []

    def unless_effects(blocks, found):
        of_base.append(losses(blocks, found))  # the base is evaluated first
        return None if found.model.effects else evaluated(blocks, found)

    def scattered(blocks, found):
        return of_base[0] - lead + 0.5 * (-1.0) ** np.arange(len(of_base[0]))

    monkeypatch.setattr(CommonBlocks, "evaluated", unless_effects)
    monkeypatch.setattr(CommonBlocks, "fitted_losses", scattered)
    said = [s for s in gap_of_friction()["limitations"] if "the loss on the fitted runs is clearly less" in s]
    assert bool(said) is withheld
