"""Two effects of which neither reduces the misfit alone: dry friction and drag in the decay of a pendulum.

A linear damper compensates for either: friction damps small swings more, drag large ones.
"""

from types import SimpleNamespace

import numpy as np
import pytest

import motofmi as mf
from fmus.effects.damping import CoulombFriction
from fmus.effects.stiffness import GeometricNonlinearity
from fmus.mechanisms import Pendulum
from fmus.support import parallel
from motofmi.gap.comparison import pair_search
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.base_fit import fitted_base
from motofmi.gap.estimation.joint_screening import screen_pairs
from motofmi.gap.estimation.screening import screen
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.workflows.gap.input_output import anchored
from tests.simulators.swings import swing

VALUES = {"J": 0.1, "k": 4.0, "c": 0.003, "T_c": 0.01, "c_2": 0.015}
MISSING = {"coulomb_friction", "progressive_damping"}


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2])
def test_two_effects_that_gain_together_lead_all_pairs(workers, monkeypatch):
    monkeypatch.setattr(parallel, "processes", lambda: workers)
    experiment, _ = anchored(input_output_experiment(Pendulum(), ["angle"]))
    runs = [prepare_sampled_run(swing(f"{a:g}", a, 10, 25, VALUES), experiment) for a in (0.6, 0.4)]
    based = fitted_base(experiment, runs, {}, (), Criteria())
    base, plain = based.fit, [effect for effect in based.candidates if not effect.flexible]
    best = screen_pairs(base, plain)[0]
    assert best.families == MISSING
    alone = {s.effect: s.gain for s in screen(base, plain, keep=1)}
    friction = [gain for effect, gain in alone.items() if effect.family == "coulomb_friction"]
    # The base's damper is too strong for large swings, and friction would only increase that: alone it gains nothing.
    assert max(friction) < 0.01 * best.gain
    assert best.gain > max(alone.values())


@pytest.mark.study
def test_friction_and_drag_are_named_together_and_neither_where_there_is_none():
    """The sensor's eccentricity leaves no model that is consistent with noise, so that models are compared on
    blocks."""
    undamped = VALUES | {"T_c": 0.0, "c_2": 0.0, "c": 0.01}
    for values, named in ((VALUES, MISSING), (undamped, set())):
        runs = [
            swing(f"swing_{i}", released, 18, 60, values, eccentricity=1e-3, seed=i)
            for i, released in enumerate((0.5, 0.45, 0.2, 0.15, 0.6))
        ]
        found = mf.find_gap(runs[:-1], validation=runs[-1], component="pendulum")
        assert {e["name"] for e in found.effects} == named
        for effect in found.effects:
            for name, true in (("friction_torque", VALUES["T_c"]), ("coefficient", VALUES["c_2"])):
                if name in effect["parameters"]:
                    value = effect["parameters"][name]
                    assert abs(value["value"] - true) < max(3 * value["standard_error"], 0.05 * true), (name, value)
                    assert np.isfinite(value["standard_error"])


@pytest.mark.parametrize(("jointly", "beside"), [(5.0, 3.0), (3.0, 5.0), (20.0, 3.0)])
def test_of_two_fits_of_a_pair_the_better_one_is_kept(monkeypatch, jointly, beside):
    """The linear estimate of a pair from the base can be a poor start: a chi-square of 20 is more than the base
    leaves."""

    def leaves(chi2):
        return SimpleNamespace(chi2=chi2, model=SimpleNamespace(effects=(GeometricNonlinearity, CoulombFriction)))

    base = SimpleNamespace(chi2=10.0, runs=[], model=SimpleNamespace(with_added_effects=lambda *effects: None))
    joint = SimpleNamespace(effects=(GeometricNonlinearity, CoulombFriction))
    portable = SimpleNamespace(chi2=jointly, on=lambda model, runs: leaves(jointly))
    monkeypatch.setattr(pair_search, "parallel_map", lambda *arguments: [portable, None])
    monkeypatch.setattr(pair_search, "candidate_of", lambda *arguments: SimpleNamespace(fitted=True, fit=leaves(beside)))
    (found,) = pair_search._fitted([joint], [base], base, np.inf, [(base, None)], Criteria()).values()
    assert found.chi2 == min(jointly, beside)


@pytest.mark.parametrize(("ratio", "fitted"), [(0.5, 1), (2.0, 0)])
def test_no_pair_is_fitted_from_a_base_that_is_far_from_the_data(monkeypatch, ratio, fitted):
    base = SimpleNamespace(chi2=ratio * pair_search.FAR_BASE, runs=[])
    single = SimpleNamespace(fit=SimpleNamespace(chi2=1.0))
    blocks = SimpleNamespace(is_undetermined=lambda *_: False, refined_and_evaluated=lambda *_: [])
    joint = SimpleNamespace(effects=(GeometricNonlinearity, CoulombFriction), families=frozenset(MISSING), gain=1.0)
    chosen = []
    monkeypatch.setattr(pair_search, "screen_pairs", lambda *_: [joint])
    monkeypatch.setattr(pair_search, "_beside", lambda *_: [])
    monkeypatch.setattr(pair_search, "leading", lambda *_: ([], []))
    monkeypatch.setattr(pair_search, "_fitted", lambda pairs, *_: chosen.extend(pairs) or {})
    assert pair_search.pairs(blocks, base, [single], [], Criteria()) == []
    assert len(chosen) == fitted
