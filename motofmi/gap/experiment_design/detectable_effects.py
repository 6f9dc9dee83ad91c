"""Which effects a planned experiment could name: the magnitude from which each is detectable, and what is tied with it.

    dchi2 = e^2 |P s|^2,   P = 1 - J J^+        against a rival with slopes r:   e^2 |(1 - R R^+) P s|^2

s are the derivatives of the planned runs' reduced output by the effect's magnitude e, over the noise; J the derivatives
by everything that is refitted, with its priors; R those of a rival, which must keep its physical sign. The estimates
hold for small magnitudes, in which the output is linear; the nonlinearity of a large effect makes it easier to
identify.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from fmus.effects import Effect
from fmus.support.errors import InputError
from fmus.support.progress import track
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.screening import shapes_of

BASE = "the base"  # as a rival: its own parameters compensate for the effect
SMALL = 1e-9  # of the squared length: rounding of a signature that the base compensates for


@dataclass(frozen=True)
class DetectableEffect:
    """A form of an effect, with the magnitudes (in `unit`) from which it is detected, and named
    against its nearest rival."""

    effect: type[Effect]
    parameter: str
    unit: str
    detected: float | None  # None where the base compensates for it
    named: float | None  # None where its nearest rivals are tied with it at any magnitude
    rival: str
    tied: tuple[str, ...]


@dataclass(frozen=True)
class _Signature:
    effect: type[Effect]
    slopes: np.ndarray  # (m, magnitudes), the base's derivatives projected out
    whole: float  # squared length of the first one before the projection
    signs: tuple[np.ndarray, np.ndarray]  # lowest and highest multiple of each


def detectable_effects(
    found: Fit, library: Sequence[type[Effect]], criteria: Criteria = Criteria()
) -> list[DetectableEffect]:
    """Every form of the library that is not flexible; those that can be named come first.

    `found` is the base fitted to planned runs.
    """
    basis, _ = np.linalg.qr(found.jacobian / (np.linalg.norm(found.jacobian, axis=0) + 1e-12))
    signatures = [
        s for effect in track(list(library), "effects that could be named") for s in _signatures(found, effect, basis)
    ]
    plain = {s.effect for s in signatures if not s.effect.flexible}
    made = [_detectable(effect, found, signatures, criteria) for effect in plain]
    return sorted(made, key=lambda n: (n.named is None, n.effect.family, n.effect.form))


def _signatures(found: Fit, effect: type[Effect], basis: np.ndarray) -> list[_Signature]:
    """The effect's signatures, one for each set of starting values; none where it cannot be simulated."""
    own = effect.free_parameters()
    sizes = [i for i, n in enumerate(own) if n not in effect.nonlinear_parameters()]
    made = []
    try:
        model = found.model.with_added_effects(effect, slopes_of_base=False)
        for shape in shapes_of(found, effect):
            rows = [model.component.table[model.experiment.parameter(effect, n)] for n in own]
            start = np.array(
                [
                    shape.get(n, r.start if i not in sizes or r.min > 0 else 0.0)
                    for i, (n, r) in enumerate(zip(own, rows, strict=True))
                ]
            )
            columns = [
                model.slopes(run, np.concatenate([found.of_run(i), start]))[:, len(found.model.names) :]
                for i, run in enumerate(found.runs)
            ]
            slopes = np.zeros((len(found.residuals), len(sizes)))
            slopes[: found.count] = np.concatenate(columns)[:, sizes]
            low, high = ([np.sign(bound) * np.inf if bound else 0.0 for bound in bounds] for bounds in
                         ([rows[i].min - start[i] for i in sizes],
                          [rows[i].max - start[i] for i in sizes]))  # fmt: skip
            made.append(
                _Signature(
                    effect,
                    slopes - basis @ (basis.T @ slopes),
                    float(slopes[:, 0] @ slopes[:, 0]),
                    (np.array(low), np.array(high)),
                )
            )
    except InputError:
        return []
    return made


def _detectable(
    effect: type[Effect], found: Fit, signatures: Sequence[_Signature], criteria: Criteria
) -> DetectableEffect:
    """The detectable magnitude of an effect at its first set of starting values, with every set of
    every rival considered."""
    mine = next(s for s in signatures if s.effect is effect)
    signature = mine.slopes[:, 0]
    alone = float(signature @ signature)
    parameter = effect.free_parameters()[0]
    unit = (
        found.model.with_added_effects(effect, slopes_of_base=False)
        .component.table[found.model.experiment.parameter(effect, parameter)]
        .unit
    )
    if alone < SMALL * mine.whole:
        return DetectableEffect(effect, parameter, unit, None, None, BASE, (BASE,))
    left: dict[str, float] = {}
    for rival in signatures:
        if rival.effect.family != effect.family:
            left[rival.effect.family] = min(left.get(rival.effect.family, 1.0), _left(signature, rival))
    name = min(left, key=lambda n: left[n])
    tied = tuple(sorted(n for n, share in left.items() if share < criteria.same_response_share))
    penalty = len(effect.free_parameters()) * float(np.log(found.count))
    detected = np.sqrt((criteria.first_effect_delta_bic + penalty) / alone)
    clear = (
        None
        if tied
        else max(np.sqrt(criteria.reliable_delta_chi2 / alone), np.sqrt(criteria.tie_delta_bic / (alone * left[name])))
    )
    return DetectableEffect(
        effect, parameter, unit, float(detected), clear if clear is None else float(clear), name, tied
    )


def _left(signature: np.ndarray, rival: _Signature) -> float:
    """The share of a signature that a rival with its physical sign leaves."""
    scale = np.linalg.norm(rival.slopes, axis=0) + 1e-12
    low, high = np.minimum(rival.signs[0], -1e-12), np.maximum(rival.signs[1], 1e-12)
    return float(2 * lsq_linear(rival.slopes / scale, signature, (low, high)).cost / (signature @ signature))
