"""The fits that a comparison considers: those that are not clearly behind the leading one."""

from types import SimpleNamespace

import numpy as np
import pytest

from motofmi.gap.comparison.search import FAR_BEHIND, leading, not_behind_on_all

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


@pytest.mark.parametrize(
    ("validation", "near"),
    [
        ({}, ["first"]),
        ({"first": 0.0, "second": -0.9, "far off": -9.0}, ["first", "second"]),
        ({"first": 0.0, "second": 0.5, "far off": 0.5}, ["first"]),
    ],
    ids=["no validation runs", "ahead on them", "behind on them"],
)
def test_a_fit_that_is_clearly_behind_on_fitted_blocks_is_judged_on_validation_blocks(validation, near):
    fitted = {"first": 0.0, "second": 0.8, "far off": 1.1 * np.log(FAR_BEHIND)}
    blocks, fits = Losses(fitted, validation), {name: name for name in fitted}
    order, found = leading(blocks, fits)
    assert order == list(fitted) and found == ["first"]
    assert [*found, *not_behind_on_all(blocks, fits, found, order[1:])] == near
