"""The eigenvalue of each mode from its branches, at most one mode at each eigenvalue.

A mode has the eigenvalue of its pair; of real roots the least stable one. Where a root of a mode forms a pair with a
root of another mode, its other root counts. Where all roots of two modes form pairs with each other, the pairs are
assigned to the modes so that the sum of their agreement is largest (linear sum assignment). The agreement is the cosine
between the participation factors of all states in the mode shape and those in the shape of the mode at the naming
speed; unlike the modal assurance criterion (Allemang, Sound and Vibration 37(8) (2003) 14-23) it does not depend on the
units of the states.
"""

from collections.abc import Callable
from itertools import combinations

import numpy as np

from vehicle_fmu.mode_shapes import ModeShapes

ABSENT = complex(np.nan, np.nan)
PARTNER = 1e-6  # relative distance from the conjugate up to which two eigenvalues are a pair

Shapes = Callable[[np.ndarray], ModeShapes]  # indices of spectra (m,) -> their mode shapes
Factors = Callable[[np.ndarray], np.ndarray]  # indices of spectra (m,) -> participation factors (m, modes, nx)


def mode_curves(spectra: np.ndarray, own: np.ndarray, shapes: Shapes, typical: Factors) -> np.ndarray:
    """The eigenvalues (modes, n), with Im >= 0, NaN where a mode is absent, from spectra (n, nx) by branch.

    own (modes, n, nx) is which branches each mode has, typical the participation of each state at the naming speed.
    """
    curves = np.array([_alone(spectra, each) for each in own])
    shared = np.zeros(len(spectra), bool)
    for a, b in combinations(curves, 2):
        shared |= a == b  # both of one pair: LAPACK returns exact conjugates
    if (places := np.flatnonzero(shared)).size:
        found, wanted = shapes(places), typical(places)
        for k, place in enumerate(places):
            curves[:, place] = _one_each(spectra[place], own[:, place], curves[:, place], found, k, wanted[k])
    return curves


def factors_of(shapes: ModeShapes, own: np.ndarray) -> np.ndarray:
    """The participation factors (n, modes, nx) of each state in modes with given branches (n, modes, nx)."""
    of_shape = np.take_along_axis(own, np.broadcast_to(shapes.column[:, None], own.shape), axis=2)
    return of_shape.astype(float) @ shapes.participations.swapaxes(1, 2)


def _alone(spectra: np.ndarray, own: np.ndarray) -> np.ndarray:
    """The eigenvalue (n,) of a mode by itself."""
    picked = np.argsort(~own, axis=1, kind="stable")[:, : max(int(own.sum(axis=1).max(initial=0)), 1)]
    mine, values = np.take_along_axis(own, picked, axis=1), np.take_along_axis(spectra, picked, axis=1)
    far = np.abs(values[..., :, None] - values[..., None, :].conj()) > PARTNER * np.abs(values)[..., :, None]
    apart = (far | ~mine[..., None, :]).all(axis=2)
    usable = mine & ~apart
    swing, growth = np.where(usable, np.abs(values.imag), -1.0), np.where(usable, values.real, -np.inf)
    best = np.where((swing > 0).any(axis=1), swing.argmax(axis=1), growth.argmax(axis=1))
    value = np.take_along_axis(values, best[:, None], axis=1)[:, 0]
    return np.where(mine.any(axis=1), _folded(value), ABSENT)


def _one_each(values: np.ndarray, own: np.ndarray, alone: np.ndarray, shapes: ModeShapes, k: int,
              wanted: np.ndarray) -> np.ndarray:  # fmt: skip
    """The eigenvalue (modes,) of each mode where modes share one, from values (nx,) by branch and `alone` (modes,).

    Modes that share none keep theirs, unless one that shares has no other.
    """
    from scipy.optimize import linear_sum_assignment  # noqa: PLC0415 - imported on use: it takes 0.5 s

    eigenvalue = np.unique(_folded(values))
    nearest = np.abs(_folded(shapes.eigenvalues[k]) - eigenvalue[:, None]).argmin(axis=1)
    possible = np.array([np.isin(eigenvalue, _folded(values[mine])) for mine in own])
    settled = np.array([(alone == each).sum() == 1 for each in alone])
    agreement = _unit(wanted) @ _unit(shapes.participations[k][:, nearest].T).T
    score = agreement + len(own) * (settled[:, None] & (alone[:, None] == eigenvalue))
    mode, chosen = linear_sum_assignment(np.where(possible, score, -len(own) * len(own) - 1), maximize=True)
    found = np.full(len(own), ABSENT)
    found[mode] = np.where(possible[mode, chosen], eigenvalue[chosen], ABSENT)
    return found


def _folded(values: np.ndarray) -> np.ndarray:
    return values.real + 1j * np.abs(values.imag)


def _unit(rows: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(rows, axis=-1, keepdims=True)
    return np.divide(rows, length, out=np.zeros_like(rows), where=length > 0)
