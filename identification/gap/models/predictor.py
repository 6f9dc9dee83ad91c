"""Base and effects as one-step predictions of what was measured, for runs in which not all states were.

The vehicle is linearised over its speed; the gains of the prediction are those of the vehicle as it is tried, with the disturbances
and noises of each run, factors of which are fitted with it (see `disturbances`). What is not linear in the states acts on them as
an input does, in the motion that is predicted with it. An input that lags is the recorded one, earlier.
"""

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from fmus.effects import Effect
from fmus.errors import InputError
from fmus.linear import linearise
from identification.gap.data.best_prediction import with_best_prediction
from identification.gap.data.flexible import features_of
from identification.gap.data.predicted import PredictedRun
from identification.gap.models.disturbances import FAMILY, FORCES, Driven, centred, estimated, predicted
from identification.gap.models.kalman import Bend, Discrete, errors, errors_and_slopes
from identification.gap.models.linear_model import LinearModel
from identification.gap.models.not_linear import NotLinear, is_linear, vehicle_of
from identification.gap.stands.linear_stand import LinearStand

BEFORE = 0.03  # s from whose ends a rate is taken that knows nothing of later samples
BENDS, SETTLED = 8, 1e-4  # steps, and the change at which they end, of the largest
NUDGE = 1e-6  # of the matrices, for slopes of what they are per step and of the gains
COARSE = 1e-3  # the same of the states' deviations
FAR = 1e3  # of the largest that was measured: a prediction that errs by so much diverges

Filter = tuple[Discrete, np.ndarray, np.ndarray]  # matrices per step, gains, deviations of the states


class PredictorModel(LinearModel):
    """One-step predictions, for a fit."""

    def __init__(self, stand: LinearStand, effects: Sequence[type[Effect]] = ()):
        super().__init__(stand, effects)
        self.prefix = f"{stand.part}." if stand.part else ""
        self.straight = stand.with_effects([e for e in effects if is_linear(stand, e)])
        bent = not all(is_linear(stand, e) for e in effects)
        self.bent = NotLinear(self.component, self.straight, stand.over, {n: row for n, row in zip(self.own, self.rows, strict=True) if n not in stand.open}) if bent else None

    @np.errstate(all="ignore")  # what runs away is an InputError
    def reduced(self, run: PredictedRun, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The prediction errors (m,), negative, and their slopes (m, np), over their deviation."""
        wanted = range(self.sloped_from, len(q))
        driven, slopes = self._driven(run, q, wanted)
        noise = self._noise(run, q)
        (made, K, unsure), (changes, dK, less_sure) = self._filter(run, driven, slopes, noise, self._noise_slopes(run, wanted))
        bends, motion = self._bends(run, q, made, K, unsure)
        told, by_parameter = self._told(run, q, motion, (unsure, less_sure), wanted)
        _, place, share = run.speeds
        left = np.zeros((len(run.measured), len(run.outputs)))
        moved = np.zeros((*left.shape, len(wanted)))
        for (first, last), bend in zip(run.stretches, bends, strict=True):
            y, u = centred(run, told, first, last)
            du = np.array([_changes(run, each, first, last, u.shape[1]) for each in by_parameter]).reshape(len(by_parameter), len(u), -1)
            left[first:last], moved[first:last] = errors_and_slopes(made, changes, K, dK, place[first:last], share[first:last], y, u, du, bend)
        if not np.max(np.abs(left)) < FAR * np.max(np.abs(run.measured)):
            raise InputError(f"{self.component.name}: the prediction of {run.name} diverges")
        jacobian = np.zeros((len(run.data), len(q)))
        jacobian[:, self.sloped_from :] = -run.whitened(moved)
        return -run.whitened(left), jacobian

    def with_noise_beside(self, run: PredictedRun, q: np.ndarray) -> PredictedRun:
        """The run as it is: its floor rests on no model of the vehicle."""
        del q
        return run

    @np.errstate(all="ignore")
    def with_disturbances_beside(self, run: PredictedRun, q: np.ndarray) -> PredictedRun:
        """The run with disturbances and noises as they are beside this vehicle, and the best prediction there is."""
        driven, _ = self._driven(run, q)
        told = self._signals(run, q)
        noise = estimated(run, driven, told) if run.noise is None else self._noise(run, q)
        made, K, unsure = self._with_gains(run, driven, noise)
        motion = self._bends(run, q, made, K, unsure)[1] if self.bent else predicted(run, made, K, told)[1]
        run = run.with_noise(noise, dict(zip(self.straight.states, motion.T, strict=False)))  # those of disturbances come last
        if run.mixing is not None:
            return run
        features = features_of(*self._known_before(run), [np.zeros(len(run.recording.time))])
        recorded = np.column_stack([np.zeros((len(run.measured), 0)), *(run.averaged(run.recording[n]) for n in run.inputs)])
        return with_best_prediction(run, recorded, [run.averaged(f) for f in features])

    # Matrices -------------------------------------------------------------------------------------------

    def _driven(self, run: PredictedRun, q: np.ndarray, wanted: Sequence[int] = ()) -> tuple[Driven, Driven]:
        """The vehicle at the run's speeds, and its slopes (np, g, ...) by the parameters that are wanted."""
        step = self.steps(q)
        moved = np.stack([q, *(q + np.eye(len(q))[i] * step[i] for i in wanted)])
        every = [self.values(x) for x in moved]
        values: dict[str, Any] = {n: np.array([v[n] for v in every])[:, None] for n in self.straight.values}
        space = linearise(self.straight, **{**values, self.stand.over: run.speeds[0]})
        grid = len(run.speeds[0])
        A, B, C, D = (np.broadcast_to(m, (len(every), grid, *m.shape[-2:])) for m in (space.A, space.B, space.C, space.D))
        outputs = [space.outputs.index(self.straight.shown(self.prefix + n)) for n in run.outputs]
        inputs = [space.inputs.index(n) for n in self._inputs(run)]
        forces = [space.inputs.index(self.prefix + n) for n in FORCES if self.prefix + n in space.inputs]
        rows = np.zeros((*A.shape[:2], A.shape[-1], len(self._pushed)))
        rows[..., [space.states.index(n) for n in self._pushed], range(len(self._pushed))] = 1.0
        B_all = np.concatenate([B[..., inputs], rows], axis=-1)
        D_all = np.concatenate([D[..., outputs, :][..., inputs], np.zeros((*A.shape[:2], len(outputs), len(self._pushed)))], axis=-1)
        pushed = B[..., forces]
        for name, (source, _) in self.straight.delays.items():  # a disturbance is not late
            pushed = pushed + B[..., [space.inputs.index(name)]] * [float(space.inputs[f] == source) for f in forces]
        parts = (A, B_all, C[..., outputs, :], D_all, pushed)
        here = Driven(*(p[0] for p in parts))
        return here, Driven(*((p[1:] - p[0]) / step[list(wanted)].reshape(-1, 1, 1, 1) for p in parts))

    def _filter(self, run: PredictedRun, driven: Driven, slopes: Driven, noise: np.ndarray, by_noise: np.ndarray) -> tuple[Filter, Filter]:
        """The matrices per step (g, ...), the gains (g, nx, ny) and the states' deviations (g, nx), and the slopes (np, g, ...) of all."""
        here = made, K, unsure = self._with_gains(run, driven, noise)
        count, grid = len(slopes.A), len(driven.A)
        if not count:
            return here, (Discrete(*(np.zeros((0, *m.shape)) for m in made.parts)), np.zeros((0, *K.shape)), np.zeros((0, *unsure.shape)))
        parts = [(getattr(driven, n), getattr(slopes, n)) for n in ("A", "B", "C", "D", "W")]
        felt = np.max([np.abs(change).max(axis=(1, 2, 3)) / max(np.abs(value).max(), 1e-300) for value, change in parts if value.size], axis=0)
        scale = NUDGE / np.maximum(np.maximum(felt, np.abs(by_noise).max(axis=1)), 1e-12)
        moved_noise = np.repeat(noise + scale[:, None] * by_noise, grid, axis=0)
        flat = Driven(*((value + scale.reshape(-1, 1, 1, 1) * change).reshape(count * grid, *value.shape[1:]) for value, change in parts))
        moved, gains, less_sure = self._with_gains(run, flat, moved_noise)
        changes = [(other.reshape(count, *value.shape) - value) / scale.reshape(-1, *(1,) * value.ndim)
                   for other, value in zip((*moved.parts, gains, less_sure), (*made.parts, K, unsure), strict=True)]  # fmt: skip
        return here, (Discrete(*changes[:-2]), changes[-2], changes[-1])

    def _with_gains(self, run: PredictedRun, driven: Driven, noise: np.ndarray) -> Filter:
        """The matrices per step, the gains, and the states' deviations. Raises InputError where nothing can be predicted."""
        made = driven.discrete(noise, run.step, run.exactly_held)
        try:
            K, _, P = driven.gains(noise, run.step, made)
        except np.linalg.LinAlgError:
            raise InputError(f"{self.component.name}: no stationary prediction of {run.name}") from None
        return made, K, np.sqrt(np.maximum(np.diagonal(P, axis1=-2, axis2=-1), 0.0))

    def _noise(self, run: PredictedRun, q: np.ndarray) -> np.ndarray:
        """psi (k,) of a run."""
        assert run.noise is not None
        places = self._factors
        return run.noise + q[places] if places else run.noise

    def _noise_slopes(self, run: PredictedRun, wanted: Sequence[int]) -> np.ndarray:
        """The slopes (np, k) of psi by the parameters that are wanted."""
        assert run.noise is not None
        slopes = np.zeros((len(wanted), len(run.noise)))
        for k, place in enumerate(self._factors):
            slopes[[i == place for i in wanted], k] = 1.0
        return slopes

    @cached_property
    def _factors(self) -> list[int]:
        """The places in a vector of the logarithms of psi's factors; none where they are not free."""
        return [i for i, n in enumerate(self.base) if n.startswith(f"{self.prefix}{FAMILY}.")]

    # What is told ---------------------------------------------------------------------------------------

    @property
    def _pushed(self) -> tuple[str, ...]:
        """The states whose rates something pushes that is not linear."""
        return self.bent.rows if self.bent else ()

    def _inputs(self, run: PredictedRun) -> list[str]:
        """The inputs of the vehicle that are told: recorded ones, then those that lag."""
        return [*(self.prefix + n for n in run.inputs), *(n for n, (_, delay) in self.straight.delays.items() if delay in dict(self._lagging(run)).values())]

    def _told(self, run: PredictedRun, q: np.ndarray, motion: np.ndarray, unsure: tuple[np.ndarray, np.ndarray],
              wanted: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """What is told (n, nu), and its slopes (np, n, nu + nb) by the parameters that are wanted, those of what is not linear last."""
        here, step = self._signals(run, q), self.steps(q)
        lags = {delay for _, delay in self.component.delays.values()}
        by_parameter = np.zeros((len(wanted), len(here), here.shape[1] + len(self._pushed)))
        for place, i in enumerate(wanted):
            if self.names[i] in lags:
                by_parameter[place, :, : here.shape[1]] = (self._signals(run, q + np.eye(len(q))[i] * step[i]) - here) / step[i]
        if self.bent:
            middle = len(unsure[0]) // 2  # of the speeds
            sure, values = unsure[0][middle], self.values(q)
            pushed = self.bent.expected(run, values, motion, sure)
            less_sure = (self.bent.expected(run, values, motion, (1 + COARSE) * sure) - pushed) / COARSE
            for place, i in enumerate(wanted):
                by_parameter[place, :, here.shape[1] :] = less_sure * self.bent.share(unsure[1][place, middle], sure)
                if self.names[i] in self.bent.depends_on:
                    other = self.bent.expected(run, self.values(q + np.eye(len(q))[i] * step[i]), motion, sure)
                    by_parameter[place, :, here.shape[1] :] += (other - pushed) / step[i]
        return here, by_parameter

    def _signals(self, run: PredictedRun, q: np.ndarray) -> np.ndarray:
        values, time, recorded = self.values(q), run.recording.time, run.recording.columns
        told = [recorded[n] for n in run.inputs]
        told += [CubicSpline(time, recorded[source])(np.maximum(time - values[delay], time[0])) for source, delay in self._lagging(run)]
        return np.column_stack([np.zeros((len(run.measured), 0)), *(run.joined(x) for x in told)])

    def _lagging(self, run: PredictedRun) -> list[tuple[str, str]]:
        """The recorded inputs that lag, with the parameters by which they do."""
        every = ((source.removeprefix(self.prefix), delay) for source, delay in self.straight.delays.values())
        return [(source, delay) for source, delay in every if source in run.inputs]

    # What is not linear ----------------------------------------------------------------------------------

    def _bends(self, run: PredictedRun, q: np.ndarray, made: Discrete, K: np.ndarray, unsure: np.ndarray) -> tuple[list[Bend | None], np.ndarray]:
        """For every stretch what is not linear in the states, near the motion (n, nx) that it predicts itself: by Newton's method."""
        motion = np.zeros((len(run.measured), K.shape[1]))
        for i, state in enumerate(self.straight.states):
            motion[:, i] = run.motion.get(state, 0.0)
        if not self.bent:
            return [None] * len(run.stretches), motion
        values, told, (_, place, share) = self.values(q), self._signals(run, q), run.speeds
        for _ in range(BENDS):
            bend = self.bent.near(run, values, motion, unsure[len(unsure) // 2])
            before, motion = motion, np.zeros_like(motion)
            for first, last in run.stretches:
                y, u = centred(run, told, first, last)
                motion[first:last] = errors(made, K, place[first:last], share[first:last], y, u, bend.between(first, last))[1]
            if np.all(np.abs(motion - before).max(axis=0) <= SETTLED * np.abs(motion).max(axis=0)):
                break
        bend = self.bent.near(run, values, motion, unsure[len(unsure) // 2])
        return [bend.between(first, last) for first, last in run.stretches], motion

    def _known_before(self, run: PredictedRun) -> tuple[list[np.ndarray], list[np.ndarray]]:
        """Measured deflections of elements and their rates (N,), which know nothing of later samples."""
        back = max(int(BEFORE * run.recording.rate), 1)
        columns = run.recording.columns
        deflections = [columns[e.deflection] for e in vehicle_of(self.stand).elements.values() if e.deflection in columns]
        return deflections, [(d - np.concatenate([np.full(back, d[0]), d[:-back]])) * run.recording.rate / back for d in deflections]


def _changes(run: PredictedRun, by_parameter: np.ndarray, first: int, last: int, told: int) -> np.ndarray:
    """Slopes (n + 1, nu + nb) of what is told and of what is not linear in a stretch; only the former is centred."""
    bent = by_parameter[first:last, told:]
    return np.hstack([centred(run, by_parameter[:, :told], first, last)[1], np.concatenate([bent, bent[-1:]])])
