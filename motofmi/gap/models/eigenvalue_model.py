r"""Base and effects as eigenvalues over an input, matched to the measured ones, and their derivatives.

    A v = lambda v,   w' A = lambda w',   d lambda / dp = w' (dA / dp) v / (w' v)

A measured eigenvalue whose mode has a name is matched by mode shape: to the computed one with the largest modal overlap
with the mode of that name in the base, |(w_0' v) (w' v_0)| with w_0' v_0 = w' v = 1 on the common states, which does
not depend on the units of the states. One without a name is matched by distance. All eigenvalues measured at one input
are assigned together; those of one name at one input are repeated measurements of one eigenvalue.

Source: Lancaster, Numer. Math. 6 (1964) 377-387.
"""

from dataclasses import replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from fmus.linear_analysis.linearisation import linearise
from fmus.support.errors import InputError
from motofmi.gap.experiments.vehicle_over_speed import VehicleOverSpeedExperiment
from motofmi.gap.models.linear_model import LinearModel
from motofmi.gap.preprocessing.eigenvalues import MeasuredEigenvalues

NAME_WEIGHT = 0.3  # of a mode's shape against relative distance; below 1, since measured modes may be mislabelled
EXCLUDED = 10.0  # cost of the conjugate of an eigenvalue; other costs are at most 2


class EigenvalueModel(LinearModel):
    """The eigenvalues of a linearised component with effects, for a fit."""

    def reduced(self, run: MeasuredEigenvalues, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The eigenvalues' parts (m,) and their slopes (m, np), over their errors. Raises InputError where
        they are not finite."""
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

    def _match(
        self, run: MeasuredEigenvalues, place: np.ndarray, values: np.ndarray, right: np.ndarray, left: np.ndarray
    ) -> np.ndarray:
        """The computed eigenvalue (n,) of each measured one."""
        candidates = values[place]
        distance = np.abs(candidates - run.value[:, None])
        cost = distance / (distance + np.abs(run.value[:, None]))
        if run.shapes is not None:
            v0, w0 = run.shapes
            kept = [self.component.states.index(n) for n in self.experiment.component.states]
            left_overlap = np.einsum("ni,nik->nk", w0, right[place][:, kept, :])
            right_overlap = np.einsum("nki,ni->nk", left[place][:, :, kept], v0)
            cost = cost + NAME_WEIGHT * np.nan_to_num(1.0 - np.minimum(np.abs(left_overlap * right_overlap), 1.0))
        cost = np.where(candidates.imag < 0, EXCLUDED, cost)
        chosen = np.empty(len(place), int)
        for k in range(place.max() + 1):
            repeats: dict[str | int, list[int]] = {}  # rows of one name are repeated measurements of one mode
            for row in np.flatnonzero(place == k).tolist():
                repeats.setdefault(run.mode[row] or row, []).append(row)
            rows = list(repeats.values())
            if len(rows) > values.shape[1]:
                raise InputError(
                    f"{run.name}: {len(rows)} eigenvalues at {run.over[rows[0][0]]:g}, the model has "
                    f"{values.shape[1]}; repeated measurements of one eigenvalue need the same name in the column mode"
                )
            measured, computed = linear_sum_assignment([cost[each].mean(axis=0) for each in rows])
            for group, column in zip(measured, computed, strict=True):
                chosen[rows[group]] = column
        return chosen


def with_mode_shapes(
    run: MeasuredEigenvalues, experiment: VehicleOverSpeedExperiment, nominal: np.ndarray
) -> MeasuredEigenvalues:
    """The run with the mode shapes of the base: those of the eigenvalues nearest to `nominal` (n,), the eigenvalues of
    the modes of these names in the base, NaN where it has none."""
    at, place = np.unique(run.over, return_inverse=True)
    values, right = np.linalg.eig(linearise(experiment.component, **{experiment.over: at}).A)
    left = np.linalg.inv(right)
    nearest = np.abs(values[place] - np.nan_to_num(nominal)[:, None]).argmin(axis=1)
    shapes = right[place, :, nearest], left[place, nearest, :]
    for each in shapes:
        each[np.isnan(nominal)] = np.nan
    return replace(run, shapes=shapes)
