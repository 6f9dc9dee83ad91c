"""Models with a magnitude or a shape that the runs do not determine leave, and the others are compared without them."""

from types import SimpleNamespace

import numpy as np
import pytest

from fmus.declaration.elements import Element
from fmus.effects.damping import CoulombFriction, CubicDamping
from fmus.effects.hysteresis import DahlHysteresis
from fmus.effects.resonance import HungBody
from fmus.effects.stiffness import Asymmetry
from motofmi.gap.comparison import objections
from motofmi.gap.comparison.outcome import outcome
from motofmi.gap.criteria import Criteria
from tests.motofmi.gap.comparison.constructed_models import BLOCKS, FLEXIBLE, MOTION, decided, model_with


@pytest.mark.parametrize(("error", "said"), [
    (0.6, "friction_torque = 1 is within 2 standard errors (of 0.6 each) of zero."),
    (np.inf, "friction_torque has no influence on these runs."),
])  # fmt: skip
def test_a_magnitude_within_its_error_is_not_named(error, said):
    found = decided([model_with(CoulombFriction, level=1.0, seed=1)], error=error)
    assert found.verdict == "unknown" and found.sentences[0].endswith(said)


@pytest.mark.parametrize(("low", "high", "verdict"), [
    (0.0, 1.0, "named"), (0.0, np.inf, "named"), (-1.0, 1.0, "unknown"), (1.0, 2.0, "named"),
])  # fmt: skip
def test_a_magnitude_at_its_bound_is_not_named_unless_it_is_a_whole_share(low, high, verdict):
    """The magnitude is 1 +- 0.1."""
    model = model_with(CoulombFriction, level=1.0, seed=1)
    for row in model.fit.model.component.table.values():
        row.min, row.max = low, high
    found = decided([model])
    assert found.verdict == verdict
    said = [s for s in found.sentences if "= 1 is at its bound, so that the effect does not fit well." in s]
    assert len(said) == (verdict != "named")


def test_the_last_sentence_is_on_the_nearest_of_undetermined_effects():
    models = [model_with(CoulombFriction, level=1.0, seed=1), model_with(CubicDamping, level=3.0, seed=2)]
    found = decided(models, error=0.6)
    assert found.nearest is models[0] and found.sentences[-1].startswith("coulomb_friction is not named")
    assert found.sentences[-2].startswith("progressive_damping is not named")


def test_an_effect_that_changes_a_stiffness_within_its_error_is_not_named():
    """The stiffness is exp(0) = 1 with a relative error of 0.6; the ratio of the two sides is determined."""
    model = model_with(Asymmetry, level=1.0, seed=1)
    of_base = model.fit.model
    of_base.names, of_base.base = ["k", *of_base.names], ["k"]
    of_base.component.elements["spring"] = Element("force", "deflection", "rate", stiffness="k")
    of_base.component.table["k"] = SimpleNamespace(unit="N.m/rad")
    of_base.values = lambda x: {"k": np.exp(x[0]), of_base.own[0]: x[1]}
    model.fit.x = model.fit.shared = np.array([0.0, 1.0])
    found = outcome(model_with(level=10.0), [model], FLEXIBLE, MOTION, (BLOCKS, BLOCKS),
                    {id(model): np.array([0.6, 0.1])}, Criteria())  # fmt: skip
    assert found.verdict == "unknown" and found.standing[id(model)] == "value not determined"
    assert "beside it k = 1 is within 2 standard errors (of 0.6 each) of zero" in found.sentences[0]


def test_a_leading_effect_without_a_determined_magnitude_leaves_and_the_others_are_compared():
    """As a further body whose free initial states follow a decay, while friction and drag together are missing."""
    pair = model_with(CoulombFriction, CubicDamping, level=1.0, seed=3)
    body = model_with(HungBody, level=0.1, seed=1, value=1e-6)
    alone = model_with(CoulombFriction, level=9.9, seed=2, value=1e-3)
    errors = {id(pair): np.full(2, 0.1), id(body): np.full(3, 9e-7), id(alone): np.full(1, 1e-3)}
    base = model_with(level=10.0)
    found = outcome(base, [body, alone, pair], FLEXIBLE, MOTION, (BLOCKS, BLOCKS), errors, Criteria())
    assert found.verdict == "named" and found.best is pair and found.nearest is pair
    (said,) = found.sentences  # the pair leads the single effect, so that only the body's leaving changes the verdict
    assert said.startswith("extra_mode is not named, and the others are compared without it: extra_mode.inertia = 1e-06")
    assert found.standing[id(pair)] == "in the confidence set"
    assert found.standing[id(body)] == found.standing[id(alone)] == "value not determined"
    # With a determined magnitude it leads as before.
    assert outcome(base, [body, pair], FLEXIBLE, MOTION, (BLOCKS, BLOCKS), errors | {id(body): np.full(3, 1e-8)},
                   Criteria()).best is body  # fmt: skip


@pytest.mark.parametrize("end", ["least", "largest"])
def test_an_effect_with_a_shape_at_its_bound_leaves_and_the_others_are_compared(monkeypatch, end):
    """As a loop of hysteresis that closes at once, which is dry friction."""
    loop, friction = model_with(DahlHysteresis, level=0.9, seed=2), model_with(CoulombFriction, level=1.0, seed=1)
    at_bound = {}
    monkeypatch.setattr(objections, "shape_at_bound", lambda fit: at_bound.get(id(fit)))
    assert decided([loop, friction]).verdict == "tied"
    at_bound[id(loop.fit)] = "hysteresis.width", end
    found = decided([loop, friction])
    assert found.verdict == "named" and found.best is friction and found.standing[id(loop)] == "value not determined"
    assert found.sentences == [
        "hysteresis is not named, and the others are compared without it: hysteresis.width = 1 is at its "
        f"{end} value, beyond which the effect is not distinguishable from another one."
    ]
