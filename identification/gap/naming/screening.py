"""Which effects could close the gap: the change of the reduced data that each would cause, the base's tangent taken out.

    gain = |P s (s' P s)^-1 s' P r|^2,   P = 1 - J J^+

r are the base's residuals, J their slopes by everything that is refitted, s the slopes by the effect's sizes at zero,
for each of its starting shapes. No effect is fitted yet: this costs one simulation per shape.
"""

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.optimize import lsq_linear

from fmus.effects import Effect
from fmus.errors import InputError
from fmus.parallel import spread
from identification.gap.models.model import AnyModel
from identification.gap.naming.fitted import Fit, memories, remembering

TOGETHER = 6  # shapes of an effect that one process tries, which makes the model once


@dataclass(frozen=True)
class Signature:
    """An effect with a shape: the chi-square that it could gain, and the effect's parameters (ne,) from which to fit."""

    effect: type[Effect]
    gain: float
    start: np.ndarray


def screen(found: Fit, effects: Iterable[type[Effect]], keep: int = 2) -> list[Signature]:
    """For every effect its best shapes, at most `keep`, on top of what is in the fit already."""
    basis, _ = np.linalg.qr(found.jacobian / (np.linalg.norm(found.jacobian, axis=0) + 1e-12))
    left = found.residuals - basis @ (basis.T @ found.residuals)

    def tried(part: tuple[type[Effect], list[dict[str, float]]]) -> list[tuple[float, np.ndarray]]:
        effect, shapes = part
        try:
            model = found.model.joined_by(effect, slopes_of_base=False)
        except InputError:  # it cannot join what is there already
            return []
        answers = []
        for shape in shapes:
            with suppress(InputError):  # this shape diverges; another may not
                answers.append(_signature(found, model, effect, shape, basis, left))
        return answers

    effects = list(effects)
    parts = [(effect, shapes[i : i + TOGETHER]) for effect in effects for shapes in [shapes_of(found, effect)] for i in range(0, len(shapes), TOGETHER)]
    answers: dict[type[Effect], list[tuple[float, np.ndarray]]] = {effect: [] for effect in effects}
    for (effect, _), answer in zip(parts, spread(tried, parts, "screening effects"), strict=True):
        answers[effect] += answer
    return [Signature(effect, *answer) for effect, shapes in answers.items() for answer in sorted(shapes, key=lambda answer: -answer[0])[:keep]]


def shapes_of(found: Fit, effect: type[Effect]) -> list[dict[str, float]]:
    """The shapes from which an effect is searched: every combination of its starts."""
    largest = found.model.largest(found.runs) if effect.relative else 1.0
    first = effect.sought()[0]
    grids = {n: [s * (largest if n in effect.relative else 1.0) for s in starts] for n, starts in effect.starts.items() if n != first}
    return [dict(zip(grids, point, strict=True)) for point in product(*grids.values())]


def _signature(found: Fit, model: AnyModel, effect: type[Effect], shape: dict[str, float], basis: np.ndarray,
               left: np.ndarray) -> tuple[float, np.ndarray]:  # fmt: skip
    """Gain and start of an effect with a shape."""
    own = effect.sought()
    rows = [model.component.table[model.stand.parameter(effect, n)] for n in own]
    start = np.array([shape.get(n, r.start if n in effect.shapes() else max(r.min, 0.0)) for n, r in zip(own, rows, strict=True)], float)
    # A size that cannot be zero is singular there (a shaft without compliance): its slope is taken where it is usual.
    seen = np.array([r.start if n not in effect.shapes() and r.min > 0 else x for n, r, x in zip(own, rows, start, strict=True)], float)
    shared = len(found.model.names)
    columns = []
    for index, run in enumerate(remembering(found.runs, memories(found.runs))):
        q = np.concatenate([found.of_run(index)[:shared], seen])
        columns.append(model.reduced(run, q)[1][:, shared:])
    sizes = [i for i, n in enumerate(own) if n not in effect.shapes()]
    slopes = np.zeros((len(left), len(sizes)))
    slopes[: found.count] = np.concatenate(columns)[:, sizes]
    slopes -= basis @ (basis.T @ slopes)
    scale = np.linalg.norm(slopes, axis=0) + 1e-12
    low = np.array([rows[i].min - start[i] for i in sizes]) * scale
    high = np.array([rows[i].max - start[i] for i in sizes]) * scale
    solved = lsq_linear(slopes / scale, -left, (np.minimum(low, -1e-12), np.maximum(high, 1e-12)))
    start[sizes] += solved.x / scale
    return float(left @ left - 2 * solved.cost), start
