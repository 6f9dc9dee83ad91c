"""The fits that a comparison considers: those that are not clearly behind the leading one."""

from types import SimpleNamespace

import numpy as np
import pytest

from fmus.effects.damping import CoulombFriction, CubicDamping
from fmus.effects.stiffness import CubicHardening
from motofmi.gap.comparison import search
from motofmi.gap.comparison.search import FAR_BEHIND, leading, leading_models, not_behind_on_all
from motofmi.gap.estimation.candidate import Candidate

BLOCKS = 12
SCATTER = 0.05 * np.random.default_rng(0).normal(size=2 * BLOCKS)  # of the logarithmic losses of each fit


class Losses:
    """Blocks of fitted and of validation runs, with constructed losses of each fit."""

    def __init__(self, fitted: dict[str, float], validation: dict[str, float]):
        self.fitted, self.of_validation, self.validation = fitted, validation, ["run"] if validation else []

    def fitted_losses(self, found):
        return self.fitted[found] + SCATTER[:BLOCKS] * (1 + len(found))

    def evaluated(self, found):
        validation = self.of_validation[found] + SCATTER[BLOCKS:] * (1 + len(found))
        return SimpleNamespace(losses=np.concatenate([self.fitted_losses(found), validation]))

    def is_disturbance(self, found):
        return False

    def refined(self, found):
        return found

    def refined_and_evaluated(self, fits, description):
        return fits


@pytest.mark.parametrize(
    ("validation", "near"),
    [
        ({"first": 0.0, "second": -0.9, "far off": -9.0}, ["first", "second"]),
        ({"first": 0.0, "second": 0.5, "far off": 0.5}, ["first"]),
    ],
    ids=["ahead on them", "behind on them"],
)
def test_a_fit_that_is_clearly_behind_on_fitted_blocks_is_judged_on_validation_blocks(validation, near):
    fitted = {"first": 0.0, "second": 0.8, "far off": 1.1 * np.log(FAR_BEHIND)}
    blocks, fits = Losses(fitted, validation), {name: name for name in fitted}
    order, found = leading(blocks, fits)
    assert order == list(fitted) and found == ["first"]
    assert [*found, *not_behind_on_all(blocks, fits, "first", order[1:])] == near


@pytest.mark.parametrize(("of_second", "compared"), [(-0.9, ["first", "second"]), (0.5, ["first"])])
def test_an_effect_that_leads_on_validation_runs_is_compared(monkeypatch, of_second, compared):
    monkeypatch.setattr(search, "_in_all_forms", lambda families, base: [c.fit for some in families for c in some])
    fitted = {"first": 0.0, "second": 0.8, "far off": 1.1 * np.log(FAR_BEHIND)}
    blocks = Losses(fitted, {"first": 0.0, "second": of_second, "far off": -9.0})
    effects = (CubicHardening, CoulombFriction, CubicDamping)
    singles = [Candidate(effect, name, 1.0, 1.0) for effect, name in zip(effects, fitted, strict=True)]
    assert leading_models(blocks, None, singles) == compared
