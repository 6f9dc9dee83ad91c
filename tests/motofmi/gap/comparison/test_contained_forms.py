"""A law that contains another one among its values: it has at most its misfit, and at these values it is the other."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fmus.effects.damping import CoulombFriction, SoftFriction, StribeckFriction
from fmus.effects.hysteresis import DahlHysteresis
from fmus.mechanisms.pendulum import Pendulum
from motofmi.gap.comparison.compared_model import CommonBlocks
from motofmi.gap.comparison.search import leading_models
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import Candidate
from motofmi.gap.estimation.fitting import fit, shape_at_bound
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.recordings.recording import Recording


class EqualLosses:
    """Blocks on which no fit is better than another one, and none is fitted again."""

    validation = ()  # without validation runs nothing else is compared

    def fitted_losses(self, found):
        return np.zeros(8)

    def is_disturbance(self, found):
        return False

    def refined(self, found):
        return found

    def refined_and_evaluated(self, fits, description):
        return fits


@pytest.fixture(scope="module")
def base():
    """A pendulum without friction, fitted to the decay of one with dry friction: q'' = -0.1 q' - 9.81 q - 0.2 sgn q'."""
    time = np.arange(0, 10, 0.02)
    angle = solve_ivp(lambda t, x: [x[1], -0.1 * x[1] - 9.81 * x[0] - 0.2 * np.tanh(x[1] / 0.02)], (0, 10), [0.8, 0.0],
                      t_eval=time, rtol=1e-9, atol=1e-9).y[0]  # fmt: skip
    noisy = angle + 1e-3 * np.random.default_rng(0).standard_normal(len(time))
    experiment = input_output_experiment(Pendulum(), ["angle"])
    run = prepare_sampled_run(Recording("swing", time, {"angle": noisy}, {"angle": "rad"}), experiment)
    model = FreeInitialStateModel(experiment)
    return fit(model, [run], model.start())


def test_a_form_that_contains_a_better_one_is_fitted_from_where_it_equals_that_one(base):
    coulomb, stribeck = (base.model.with_added_effects(effect) for effect in (CoulombFriction, StribeckFriction))
    plain = fit(coulomb, base.runs, np.append(base.x, 0.1))
    # The excess near standstill is so large that no motion can be simulated from these values.
    poor = replace(base, model=stribeck, x=np.concatenate([base.x, [0.0, 1.0, 0.1]]))
    candidates = [Candidate.gained(base, effect, found)
                  for effect, found in ((CoulombFriction, plain), (StribeckFriction, poor))]  # fmt: skip
    found = {len(one.model.own): one for one in leading_models(EqualLosses(), base, candidates)}
    assert found[3].chi2 <= found[1].chi2 == pytest.approx(plain.chi2)


@pytest.mark.parametrize("start", [0.03, 0.05, 0.1])
def test_a_loop_of_hysteresis_that_fits_dry_friction_ends_at_its_least_width(base, start):
    plain = fit(base.model.with_added_effects(CoulombFriction), base.runs, np.append(base.x, 0.1))
    model, x = base.model.with_added_effects(DahlHysteresis), np.append(plain.x, start)
    narrow, wide = fit(model, base.runs, x), fit(model, base.runs, x, frozen=[len(plain.x)])
    assert shape_at_bound(narrow) == ("hysteresis.width", "least")
    assert shape_at_bound(wide) is shape_at_bound(base) is None
    blocks = CommonBlocks(plain, [], Criteria())
    assert blocks.is_disturbance(narrow)  # it leads no family, and its blocks are not those of the comparison


@pytest.mark.parametrize(
    ("sliding_rate", "at_bound"), [(1.2, None), (1.25, ("coulomb_friction.sliding_rate", "largest"))]
)
def test_friction_that_no_rate_develops_is_a_damper(base, sliding_rate, at_bound):
    """The transition through zero rate is at most as wide as half of the largest rate, here 2.5 rad/s."""
    model = FreeInitialStateModel(base.model.experiment.scaled(0.8, 2.5)).with_added_effects(SoftFriction)
    x = np.append(base.x, [0.1, sliding_rate])
    kept = fit(model, base.runs, x, frozen=range(len(x)))
    assert shape_at_bound(kept) == at_bound
