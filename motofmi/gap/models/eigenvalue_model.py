r"""Base and effects as eigenvalues over an input, matched with the measured ones, and their slopes.

    A v = lambda v,   w' A = lambda w',   d lambda / dp = w' (dA / dp) v / (w' v)

A measured eigenvalue whose mode has a name is matched by its shape: the computed one with the largest modal overlap with
the mode of that name in the base, |(w_0' v) (w' v_0)| with w_0' v_0 = w' v = 1 on the states that both have, which does
not depend on the units of the states; one without a name by its distance. All measured at one input together.

Source: Lancaster, Numer. Math. 6 (1964) 377-387.
"""

from dataclasses import replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from fmus.errors import InputError
from fmus.linear import linearise
from identification.gap.data.eigenvalues import Spectrum
from identification.gap.models.linear_model import LinearModel
from identification.gap.stands.linear_stand import LinearStand

TRUST = 0.3  # in a name, against a relative distance: whoever named a mode may have taken one for the other
FORBIDDEN = 10.0  # as costs go, which are at most 2: the conjugate of an eigenvalue


class EigenvalueModel(LinearModel):
    """The eigenvalues of a linearised component with effects, for a fit."""

    def reduced(self, run: Spectrum, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The eigenvalues' parts (m,) and their slopes (m, np), over their errors. Raises InputError where they are not finite."""
        at, place = np.unique(run.over, return_inverse=True)
        space, slopes = self.linearised(q, at)
        if not np.isfinite(space.A).all():
            raise InputError(f"{self.component.name}: no finite eigenvalues")
        values, right = np.linalg.eig(space.A)
        left = np.linalg.inv(right)  # rows w' with w' v = 1
        chosen = self._match(run, place, values, right, left)
        v, w = right[place, :, chosen], left[place, chosen, :]
        found = values[place, chosen]
        by_parameter = np.einsum("ni,pnij,nj->np", w, slopes.A[:, place], v)
        deviation = run.deviation
        return run.parts(found) / deviation, run.parts(by_parameter) / deviation[:, None]

    def _match(self, run: Spectrum, place: np.ndarray, values: np.ndarray, right: np.ndarray, left: np.ndarray) -> np.ndarray:
        """The computed eigenvalue (n,) of each measured one."""
        candidates = values[place]
        far = np.abs(candidates - run.value[:, None])
        cost = far / (far + np.abs(run.value[:, None]))
        if run.shapes is not None:
            v0, w0 = run.shapes
            kept = [self.component.states.index(n) for n in self.stand.component.states]
            forth = np.einsum("ni,nik->nk", w0, right[place][:, kept, :])
            back = np.einsum("nki,ni->nk", left[place][:, :, kept], v0)
            cost = cost + TRUST * np.nan_to_num(1.0 - np.minimum(np.abs(forth * back), 1.0))
        cost = np.where(candidates.imag < 0, FORBIDDEN, cost)
        chosen = np.empty(len(place), int)
        for k in range(place.max() + 1):
            rows = np.flatnonzero(place == k)
            if len(rows) > values.shape[1]:
                raise InputError(f"{run.name}: {len(rows)} eigenvalues at {run.over[rows[0]]:g}, the model has {values.shape[1]}")
            mine, theirs = linear_sum_assignment(cost[rows])
            chosen[rows[mine]] = theirs
        return chosen


def shaped(run: Spectrum, stand: LinearStand, nominal: np.ndarray) -> Spectrum:
    """The run with the shapes that its modes have in the base: those of the eigenvalues nearest to `nominal` (n,), which is
    where the base has the mode of each name, NaN where it has none."""
    at, place = np.unique(run.over, return_inverse=True)
    values, right = np.linalg.eig(linearise(stand.component, **{stand.over: at}).A)
    left = np.linalg.inv(right)
    nearest = np.abs(values[place] - np.nan_to_num(nominal)[:, None]).argmin(axis=1)
    shapes = right[place, :, nearest], left[place, nearest, :]
    for each in shapes:
        each[np.isnan(nominal)] = np.nan
    return replace(run, shapes=shapes)
