"""What a test could name, before it is made: the strength from which each effect stands out, and what is tied with it.

    dchi2 = e^2 |P s|^2,   P = 1 - J J^+        against a rival with slopes r:   e^2 |(1 - R R^+) P s|^2

s are the slopes of the planned runs' reduced output by the effect's size e, over the noise; J the slopes by everything
that is refitted, with its priors. A rival may take only sizes of its physical sign. All is at small sizes, where the
output is linear in them: what a large effect adds to that makes it easier to tell.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from fmus.effects import Effect
from fmus.errors import InputError
from fmus.progress import track
from identification.gap.naming.candidate import SIGNIFICANT, TIE
from identification.gap.naming.fitted import Fit
from identification.gap.naming.screening import shapes_of

RELIABLE = 40.0  # delta chi-square from which names have proved right
BASE = "the base"  # a rival that makes up for an effect by its own parameters
SMALL = 1e-9  # of its squared length: what rounding leaves of a signature that the base makes up for
SAME = 1e-3  # of the squared length: a rival that leaves less of a signature makes the same of it


@dataclass(frozen=True)
class Nameable:
    """An effect in a form, with its size (in `unit`) from which it is noticed, reliable, and told from its nearest rival."""

    effect: type[Effect]
    parameter: str
    unit: str
    noticed: float | None  # None where the base itself makes up for all of it
    named: float | None  # None where its nearest rivals are tied with it at any strength
    rival: str
    tied: tuple[str, ...]


@dataclass(frozen=True)
class _Signature:
    effect: type[Effect]
    slopes: np.ndarray  # (m, sizes), the base's tangent taken out
    whole: float  # squared length of the first before that
    signs: tuple[np.ndarray, np.ndarray]  # lowest and highest multiple of each


def nameable(found: Fit, library: Sequence[type[Effect]]) -> list[Nameable]:
    """Every form of the library that is no curve of its own, the most easily named first.

    `found` is the base fitted to planned runs.
    """
    basis, _ = np.linalg.qr(found.jacobian / (np.linalg.norm(found.jacobian, axis=0) + 1e-12))
    signatures = [s for effect in track(list(library), "effects that could be named") for s in _signatures(found, effect, basis)]
    plain = {s.effect for s in signatures if not s.effect.flexible}
    made = [_weighed(effect, found, signatures) for effect in plain]
    return sorted(made, key=lambda n: (n.named is None, n.effect.family, n.effect.form))


def _signatures(found: Fit, effect: type[Effect], basis: np.ndarray) -> list[_Signature]:
    """The effect's signatures, one for each of its starting shapes; none where it cannot be simulated."""
    own = effect.sought()
    sizes = [i for i, n in enumerate(own) if n not in effect.shapes()]
    made = []
    try:
        model = found.model.joined_by(effect, slopes_of_base=False)
        for shape in shapes_of(found, effect):
            rows = [model.component.table[model.stand.parameter(effect, n)] for n in own]
            start = np.array([shape.get(n, r.start if i not in sizes or r.min > 0 else 0.0) for i, (n, r) in enumerate(zip(own, rows, strict=True))])
            columns = [model.reduced(run, np.concatenate([found.of_run(i), start]))[1][:, len(found.model.names) :] for i, run in enumerate(found.runs)]
            slopes = np.zeros((len(found.residuals), len(sizes)))
            slopes[: found.count] = np.concatenate(columns)[:, sizes]
            low, high = ([np.sign(bound) * np.inf if bound else 0.0 for bound in bounds] for bounds in
                         ([rows[i].min - start[i] for i in sizes], [rows[i].max - start[i] for i in sizes]))  # fmt: skip
            made.append(_Signature(effect, slopes - basis @ (basis.T @ slopes), float(slopes[:, 0] @ slopes[:, 0]), (np.array(low), np.array(high))))
    except InputError:
        return []
    return made


def _weighed(effect: type[Effect], found: Fit, signatures: Sequence[_Signature]) -> Nameable:
    """The effect in the shape of its first start, against every rival in all its shapes."""
    mine = next(s for s in signatures if s.effect is effect)
    signature = mine.slopes[:, 0]
    alone = float(signature @ signature)
    parameter = effect.sought()[0]
    unit = found.model.joined_by(effect, slopes_of_base=False).component.table[found.model.stand.parameter(effect, parameter)].unit
    if alone < SMALL * mine.whole:
        return Nameable(effect, parameter, unit, None, None, BASE, (BASE,))
    left: dict[str, float] = {}
    for rival in signatures:
        if rival.effect.family != effect.family:
            left[rival.effect.family] = min(left.get(rival.effect.family, 1.0), _left(signature, rival))
    name = min(left, key=lambda n: left[n])
    tied = tuple(sorted(n for n, share in left.items() if share < SAME))
    penalty = len(effect.sought()) * float(np.log(found.count))
    noticed = np.sqrt((SIGNIFICANT + penalty) / alone)
    clear = None if tied else max(np.sqrt(RELIABLE / alone), np.sqrt(TIE / (alone * left[name])))
    return Nameable(effect, parameter, unit, float(noticed), clear if clear is None else float(clear), name, tied)


def _left(signature: np.ndarray, rival: _Signature) -> float:
    """The share of a signature that a rival of its physical sign leaves."""
    scale = np.linalg.norm(rival.slopes, axis=0) + 1e-12
    low, high = np.minimum(rival.signs[0], -1e-12), np.maximum(rival.signs[1], 1e-12)
    return float(2 * lsq_linear(rival.slopes / scale, signature, (low, high)).cost / (signature @ signature))
