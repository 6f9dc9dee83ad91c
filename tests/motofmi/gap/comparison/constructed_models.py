"""Compared models with losses that are constructed for a rule, and the outcome of their comparison."""

from types import SimpleNamespace

import numpy as np

from motofmi.gap.comparison.compared_model import ComparedModel
from motofmi.gap.comparison.outcome import outcome
from motofmi.gap.criteria import Criteria
from motofmi.recordings.recording import Recording

BLOCKS = 20
MOTION = 100.0  # mean square
FLEXIBLE = 0.01
COUNT = 1000  # data of the fitted runs
DRIVEN = SimpleNamespace(
    recording=Recording("run", np.arange(2.0), {"force": np.arange(2.0)}, {"force": "N"}),
    experiment=SimpleNamespace(inputs=["force"]),
)


def model_with(*effects, level, seed=0, scatter=0.1, blocks=BLOCKS, value=1.0):
    """A compared model whose mean square is `level` on all blocks but for a scatter, and whose parameters all have one
    value."""
    names = [f"{e.family}.{n}" for e in effects for n in e.free_parameters()]
    unbounded = {n: SimpleNamespace(unit="1", min=-np.inf, max=np.inf) for n in names}
    component = SimpleNamespace(elements={}, table=unbounded)
    experiment = SimpleNamespace(parameter=lambda effect, n: f"{effect.family}.{n}", component=component)
    model = SimpleNamespace(names=names, own=names, base=[], experiment=experiment, effects=effects,
                            component=component, values=lambda x: dict(zip(names, x, strict=True)))  # fmt: skip
    squares = level * np.exp(scatter * np.random.default_rng(seed).normal(size=2 * blocks))
    penalty = len(names) * np.log(COUNT)
    x = np.full(len(names), value)
    fit = SimpleNamespace(model=model, x=x, shared=x, runs=[DRIVEN], count=COUNT, penalty=penalty)
    return ComparedModel(effects, fit, squares[:blocks], squares[blocks:], 1e-9)


def decided(models, base_level=10.0, error=0.1, counts=(BLOCKS, BLOCKS), criteria=Criteria(), **options):
    base = model_with(level=base_level, **options)
    errors = {id(c): np.full(len(c.fit.model.names), error) for c in models}
    return outcome(base, models, FLEXIBLE, MOTION, counts, errors, criteria)
