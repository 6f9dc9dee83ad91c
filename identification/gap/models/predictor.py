"""Base and effects as one-step predictions of what was measured, for runs in which not all states were.

The vehicle is linearised over its speed; the gains of the prediction rest on the disturbances and noises of each run, which
are found beside a fit and stay as they are while others compete (see `disturbances`). What is not linear in the states is told:
it is taken in the motion as it was predicted beside that fit. An input that lags is the recorded one, earlier.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from fmus.component import Component
from fmus.effects import Effect
from fmus.errors import InputError
from fmus.linear import linearise
from fmus.mathematics import NUMERIC
from identification.gap.data.best_prediction import with_best_prediction
from identification.gap.data.flexible import features_of
from identification.gap.data.predicted import PredictedRun
from identification.gap.models.disturbances import Driven, centred, estimated, predicted
from identification.gap.models.kalman import Discrete, errors_and_slopes
from identification.gap.models.linear_model import LinearModel
from identification.gap.stands.linear_stand import LinearStand

FORCES = ("roll_torque", "lateral_force", "steer_torque")  # at which disturbances act
BEFORE = 0.03  # s from whose ends a rate is taken that knows nothing of later samples
FAR = 1e3  # of the largest that was measured: a prediction that errs by so much diverges
LARGE = 0.1  # deflection [rad] and rate [rad/s] at which an effect's slopes differ from those at rest if it is not linear


class PredictorModel(LinearModel):
    """One-step predictions, for a fit."""

    def __init__(self, stand: LinearStand, effects: Sequence[type[Effect]] = ()):
        super().__init__(stand, effects)
        self.prefix = f"{stand.part}." if stand.part else ""
        self.curved = not all(is_linear(stand, e) for e in effects)
        self.straight = stand.with_effects([e for e in effects if is_linear(stand, e)])

    @np.errstate(all="ignore")  # what runs away is an InputError
    def reduced(self, run: PredictedRun, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The prediction errors (m,), negative, and their slopes (m, np), over their deviation."""
        wanted = range(self.sloped_from, len(q))
        driven, slopes = self._driven(run, q, wanted)
        made, changes = self._discrete(run, driven, slopes)
        told, by_parameter = self._told(run, q, wanted)
        K = self._gains(run, driven, made)
        _, place, share = run.speeds
        left = np.zeros((len(run.measured), len(run.outputs)))
        moved = np.zeros((*left.shape, len(wanted)))
        for first, last in run.stretches:
            y, u = centred(run, told, first, last)
            du = np.array([centred(run, each, first, last)[1] for each in by_parameter]).reshape(-1, *u.shape)
            left[first:last], moved[first:last] = errors_and_slopes(made, changes, K, place[first:last], share[first:last], y, u, du)
        if not np.max(np.abs(left)) < FAR * np.max(np.abs(run.measured)):
            raise InputError(f"{self.component.name}: the prediction of {run.name} diverges")
        jacobian = np.zeros((len(run.data), len(q)))
        jacobian[:, self.sloped_from :] = -run.whitened(moved)
        return -run.whitened(left), jacobian

    def with_noise_beside(self, run: PredictedRun, q: np.ndarray) -> PredictedRun:
        """The run as it is: its floor rests on no model of the vehicle."""
        del q
        return run

    def with_disturbances_beside(self, run: PredictedRun, q: np.ndarray) -> PredictedRun:
        """The run with disturbances and noises as they come out beside this vehicle, and the best prediction there is."""
        driven, _ = self._driven(run, q)
        told, _ = self._told(run, q)
        noise = estimated(run, driven, told)
        made = driven.discrete(noise, run.step, run.exactly_held)
        K = driven.gains(noise, run.step, made)[0]
        _, states = predicted(run, made, K, told)
        run = run.with_noise(noise, dict(zip(self.straight.states, states.T, strict=False)))  # those of disturbances come last
        run.known[self.straight.states] = K
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
        outputs = [space.outputs.index(self.prefix + n) for n in run.outputs]
        inputs = [space.inputs.index(n) for n in self._inputs(run)]
        forces = [space.inputs.index(self.prefix + n) for n in FORCES if self.prefix + n in space.inputs]
        rows = np.zeros((*A.shape[:2], A.shape[-1], len(self._rows)))
        rows[..., [space.states.index(n) for n in self._rows], range(len(self._rows))] = 1.0
        B_all = np.concatenate([B[..., inputs], rows], axis=-1)
        D_all = np.concatenate([D[..., outputs, :][..., inputs], np.zeros((*A.shape[:2], len(outputs), len(self._rows)))], axis=-1)
        pushed = B[..., forces]
        for name, (source, _) in self.straight.delays.items():  # a disturbance is not late
            pushed = pushed + B[..., [space.inputs.index(name)]] * [float(space.inputs[f] == source) for f in forces]
        parts = (A, B_all, C[..., outputs, :], D_all, pushed)
        here = Driven(*(p[0] for p in parts))
        return here, Driven(*((p[1:] - p[0]) / step[list(wanted)].reshape(-1, 1, 1, 1) for p in parts))

    def _discrete(self, run: PredictedRun, driven: Driven, slopes: Driven) -> tuple[Discrete, Discrete]:
        """The matrices per step and their slopes (np, g, ...)."""
        assert run.noise is not None
        made = driven.discrete(run.noise, run.step, run.exactly_held)
        count, nudge = len(slopes.A), 1e-6
        scale = nudge / np.maximum(np.abs(slopes.A).max(axis=(1, 2, 3)), 1e-12).reshape(-1, 1, 1, 1) * np.abs(driven.A).max() if count else np.ones((0, 1, 1, 1))
        parts = [here + scale * change for here, change in zip((driven.A, driven.B, driven.C, driven.D, driven.W), (slopes.A, slopes.B, slopes.C, slopes.D, slopes.W), strict=True)]
        grid = len(driven.A)
        flat = Driven(*(p.reshape(count * grid, *p.shape[2:]) for p in parts))
        moved = flat.discrete(run.noise, run.step, run.exactly_held)
        each = [m.reshape(count, grid, *m.shape[1:]) for m in moved.parts]
        return made, Discrete(*((m - here) / scale for m, here in zip(each, made.parts, strict=True)))

    def _gains(self, run: PredictedRun, driven: Driven, made: Discrete) -> np.ndarray:
        key = self.straight.states  # with the same gains, an effect of size zero changes nothing
        K = run.known.get(key)
        if K is None or not np.max(np.abs(np.linalg.eigvals(made.F - K @ made.C))) < 1:  # those of another vehicle may not hold an unstable one
            try:
                run.known[key] = driven.gains(run.noise, run.step, made)[0]  # type: ignore[arg-type]
            except np.linalg.LinAlgError:
                raise InputError(f"{self.component.name}: no stationary prediction of {run.name}") from None
        return run.known[key]

    # What is told ---------------------------------------------------------------------------------------

    def _inputs(self, run: PredictedRun) -> list[str]:
        """The inputs of the vehicle that are told: recorded ones, then those that lag."""
        return [*(self.prefix + n for n in run.inputs), *(n for n, (_, delay) in self.straight.delays.items() if delay in dict(self._lagging(run)).values())]

    @cached_property
    def _rows(self) -> tuple[str, ...]:
        """The states whose rates the mass matrix couples, on which acts what is not linear."""
        entries = self.straight.mass_entries(self.straight.start_values(), NUMERIC)
        return tuple(n for n in self.straight.states if any(n in place for place in entries)) if self.curved else ()

    def _told(self, run: PredictedRun, q: np.ndarray, wanted: Sequence[int] = ()) -> tuple[np.ndarray, np.ndarray]:
        """What is told (n, nu), and its slopes (np, n, nu) by the parameters that are wanted."""
        here, step = self._signals(run, q), self.steps(q)
        lags = {delay for _, delay in self.component.delays.values()}
        by_parameter = np.zeros((len(wanted), *here.shape))
        for place, i in enumerate(wanted):
            if self.curved or self.names[i] in lags:
                by_parameter[place] = (self._signals(run, q + np.eye(len(q))[i] * step[i]) - here) / step[i]
        return here, by_parameter

    def _signals(self, run: PredictedRun, q: np.ndarray) -> np.ndarray:
        values, time, recorded = self.values(q), run.recording.time, run.recording.columns
        told = [recorded[n] for n in run.inputs]
        told += [CubicSpline(time, recorded[source])(np.maximum(time - values[delay], time[0])) for source, delay in self._lagging(run)]
        joined = [run.joined(x) for x in told] + (list(self._bent(run, values)) if self.curved else [])
        return np.column_stack([np.zeros((len(run.measured), 0)), *joined])

    def _lagging(self, run: PredictedRun) -> list[tuple[str, str]]:
        """The recorded inputs that lag, with the parameters by which they do."""
        every = ((source.removeprefix(self.prefix), delay) for source, delay in self.straight.delays.values())
        return [(source, delay) for source, delay in every if source in run.inputs]

    def _bent(self, run: PredictedRun, values: Mapping[str, float]) -> np.ndarray:
        """What is not linear in the states gives to the rates of `_rows` (rows, n), in the motion as it was predicted."""
        known = {**self.component.start_values(), **values, self.stand.over: run.averaged(run.recording[run.over]), **run.motion}
        rows = self._rows
        forces = [np.stack([np.broadcast_to(c.run(known, NUMERIC)[f"der({r})"], len(run.measured)) for r in rows]) for c in (self.component, self.straight)]
        entries = self.straight.mass_entries({**self.straight.start_values(), **values, self.stand.over: float(run.speeds[0].mean())}, NUMERIC)
        mass = np.array([[entries.get((a, b), float(a == b)) for b in rows] for a in rows], float)
        return np.linalg.solve(mass, forces[0] - forces[1])

    def _known_before(self, run: PredictedRun) -> tuple[list[np.ndarray], list[np.ndarray]]:
        """Measured deflections of elements and their rates (N,), which know nothing of later samples."""
        back = max(int(BEFORE * run.recording.rate), 1)
        columns = run.recording.columns
        deflections = [columns[e.deflection] for e in _vehicle(self.stand).elements.values() if e.deflection in columns]
        return deflections, [(d - np.concatenate([np.full(back, d[0]), d[:-back]])) * run.recording.rate / back for d in deflections]


def is_linear(stand: LinearStand, effect: type[Effect]) -> bool:
    """Whether a vehicle with an effect has the same slopes in motion as at rest."""
    component = stand.with_effects([effect])
    moved = {f"{stand.part}.{n}" if stand.part else n for e in _vehicle(stand).elements.values() for n in (e.deflection, e.rate)}
    values = {n: max(row.start, row.min) or 1.0 for n, row in component.table.items() if row.role == "parameter" and effect.family in n}
    at_rest, in_motion = (linearise(component, **values, **dict.fromkeys(moved, size)).A for size in (0.0, LARGE))
    return bool(np.allclose(at_rest, in_motion, rtol=1e-9))


def _vehicle(stand: LinearStand) -> Component:
    return stand.component.parts[stand.part] if stand.part else stand.component  # type: ignore[attr-defined]
