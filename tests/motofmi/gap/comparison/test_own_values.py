"""Fitted and validation runs of two pendulums: nothing is named, and the value that differs is stated."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import motofmi as mf
from fmus.effects.damping import CoulombFriction
from fmus.mechanisms import Pendulum
from motofmi.gap.comparison import own_values
from motofmi.gap.comparison.compared_model import CommonBlocks
from motofmi.gap.comparison.search import single_effects
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.base_fit import fitted_base
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.recordings.recording import Recording
from tests import as_study
from tests.few_laws import FAMILIES, only_families
from tests.motofmi.gap.comparison.constructed_models import FLEXIBLE, model_with
from tests.simulators.swings import swing
from tests.simulators.three_sines import three_sines

VALUES = {"J": 0.1, "k": 4.0, "c": 0.003, "T_c": 0.0, "c_2": 0.0}


@pytest.mark.parametrize(("friction", "stiffness"), [as_study(0.0, 2.8), (0.01, 2.8), (0.01, 20.0)])
def test_nothing_is_named_where_the_validation_run_is_of_another_pendulum(monkeypatch, friction, stiffness):
    """With 20 N.m/rad for 4 N.m/rad its frequency is more than twice as high, too far for a fit from the other values."""
    only_families(monkeypatch, (*FAMILIES, "geometric_nonlinearity"))
    values = VALUES | {"T_c": friction}
    runs = [swing(f"from {q} rad", q, 12.0, 40.0, values, noise=1e-3, seed=k) for k, q in enumerate((0.5, 0.3))]
    held = swing("held", 0.4, 12.0, 40.0, values | {"k": stiffness}, noise=1e-3, seed=7)
    result = mf.find_gap(runs, validation=held, component="pendulum").to_dict()
    assert result["verdict"] == "unknown" and not result["effects"]
    values = re.search(r"gravity_stiffness is ([\d.]+) .*? and ([\d.]+) ", result["disagreement"])
    assert [float(value) for value in values.groups()] == pytest.approx([4.0, stiffness], rel=2e-3)  # friction adds 1e-3
    assert result["disagreement"] in result["limitations"]
    amplitudes = re.search(r"is ([\d.]+) and ([\d.]+) rad \(angle\)", result["disagreement"])
    # Two decaying swings from 0.5 and 0.3 rad, and one from 0.4 rad: below their starts over sqrt(2)
    assert all(0.05 < float(rms) < 0.3 for rms in amplitudes.groups())


@pytest.mark.parametrize(("level", "disagree"), [(9.0, False), (1.0, True)])
def test_values_of_their_own_are_compared_with_the_base_where_effects_leave_more(monkeypatch, level, disagree):
    """An effect leaves ten times the misfit of the base in the validation runs: any values would be better."""
    base, best, own = model_with(level=10.0), model_with(CoulombFriction, level=1.0, seed=1), model_with(level=level, seed=2)
    best.validation[:] = 100.0
    monkeypatch.setattr(own_values, "with_own_values", lambda *_: own)
    monkeypatch.setattr(own_values, "_difference", lambda *_: "")
    monkeypatch.setattr(own_values, "_amplitudes", lambda *_: "")
    blocks = SimpleNamespace(criteria=Criteria(), validation_blocks=[(0, 0, 10)])
    assert bool(own_values.disagreement(base, best, FLEXIBLE, blocks)) == disagree


@pytest.mark.parametrize(("of_base", "disagree"), [(10.0, False), (1.0, True)])
def test_runs_agree_where_the_fitted_ones_need_the_effect_that_predicts_the_validation_run(monkeypatch, of_base, disagree):
    """In the validation run the effect closes nine tenths of what the base leaves there, and the base with values of its
    own nearly all. In the fitted run the base leaves ten times what the effect does, or as much."""
    base, best = model_with(level=of_base), model_with(CoulombFriction, level=1.0, seed=1)
    base.validation[:], own = 10.0, model_with(level=0.01, seed=2)
    monkeypatch.setattr(own_values, "with_own_values", lambda *_: own)
    monkeypatch.setattr(own_values, "_difference", lambda *_: "")
    monkeypatch.setattr(own_values, "_amplitudes", lambda *_: "")
    blocks = SimpleNamespace(criteria=Criteria(), validation_blocks=[(0, 0, 10)])
    assert bool(own_values.disagreement(base, best, 0.001, blocks)) == disagree


@pytest.mark.parametrize(("friction", "stiffnesses", "disagree"), [(0.01, (4.0, 4.0), False), (0.0, (4.0, 2.8), True)])
def test_an_effect_is_needed_where_the_base_has_values_of_its_own_in_each_fitted_run(
    monkeypatch, friction, stiffnesses, disagree
):
    """Two swings with dry friction, or of two pendulums without it."""
    experiment = input_output_experiment(Pendulum(), ["angle"])
    runs = [
        prepare_sampled_run(swing("run", q, 12.0, 40.0, VALUES | {"T_c": friction, "k": k}, noise=1e-3, seed=i), experiment)
        for i, (q, k) in enumerate(zip((0.5, 0.3), stiffnesses, strict=True))
    ]  # fmt: skip
    found = fitted_base(experiment, runs, {}, (CoulombFriction,), Criteria()).fit
    (with_friction,) = single_effects(found, [CoulombFriction], Criteria())
    blocks = CommonBlocks(with_friction.fit, runs[:1], Criteria())
    blocks.blocks = [(i, 80 * k, 80 * k + 80) for i in (0, 1) for k in range(6)]
    blocks.validation_blocks = blocks.blocks[:6]
    base, best = (blocks.evaluated(each) for each in (found, with_friction.fit))
    best = replace(best, validation=0.1 * base.validation)
    monkeypatch.setattr(own_values, "with_own_values", lambda *_: replace(base, validation=0.001 * base.validation))
    assert bool(own_values.disagreement(base, best, 0.0, blocks)) == disagree


def test_without_validation_runs_nothing_disagrees():
    base, best = (replace(model_with(level=level), validation=np.zeros(0)) for level in (10.0, 1.0))
    assert not own_values.disagreement(base, best, FLEXIBLE, SimpleNamespace(criteria=Criteria(), validation_blocks=[]))


def sliding(name: str, width: float, labelled: float, seed: int) -> Recording:
    """20 s at 100 Hz of a mass of 1 kg along three sines: force with a spring of 20 N/width that slides at 20 N, and
    noise; the recorded displacement [m] is multiplied by `labelled`."""
    generator, time = np.random.default_rng(seed), np.arange(2000) / 100
    x, v, a = three_sines(generator, time)
    held, stretched = [], 0.0
    for step in np.diff(x, prepend=x[0]):
        stretched = min(max(stretched + step / width, -1.0), 1.0)
        held.append(stretched)
    force = a + 2 * v + 10 * x + 20 * np.array(held) + 0.3 * generator.standard_normal(len(time))
    return Recording(name, time, {"force": force, "displacement": labelled * x}, {"force": "N", "displacement": "m"})


@pytest.mark.parametrize(("width", "labelled"), [(0.02, 1 / 25.4), (0.3, 1000.0)])
def test_a_wrong_unit_in_the_validation_run_gets_no_name(monkeypatch, width, labelled):
    """With a width of 0.02 m no linear base of its own closes 90 % of the misfit. With 0.3 m nothing slides: the base is
    complete, and a factor of 1000 leaves a misfit that is a thousand times the motion."""
    only_families(monkeypatch, ("hysteresis", "coulomb_friction", "drift"))
    result = mf.find_gap(
        [sliding("fitted", width, 1.0, 1)], validation=[sliding("held", width, labelled, 2)],
        component="mass_spring_damper", impose="displacement",
    ).to_dict()  # fmt: skip
    assert result["verdict"] == "unknown" and not result["effects"]
    values = re.search(r"(spring_\w+) is ([\d.e+]+) .*? and ([\d.e+]+) ", result["disagreement"])
    # A force in N over a displacement that is labelled wrongly; 10 % where the runs rub over different paths
    assert float(values[2]) / float(values[3]) == pytest.approx(labelled, rel=0.1)
    rms = re.search(r"([\d.]+) and ([\d.]+) m \(displacement\)", result["disagreement"])
    assert float(rms[2]) / float(rms[1]) == pytest.approx(labelled, rel=0.1)  # both are three sines
