"""Base and effects as one-step predictions of the measured outputs, for runs in which not all states are measured.

The vehicle is linearised over its speed. The gains of the predictor follow from the current parameters and from the
disturbances and sensor noise of each run, factors on which are fitted too (see `disturbances`). Nonlinear forces act as
inputs, evaluated in the predicted motion. A delayed input is the recorded one, interpolated at earlier times.
"""

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from fmus.effects import Effect
from fmus.linear_analysis.linearisation import linearise
from fmus.support.errors import InputError
from motofmi.gap.experiments.vehicle_over_speed import VehicleOverSpeedExperiment
from motofmi.gap.models.disturbances import FAMILY, FORCES, DisturbedVehicle, centred, estimated, predicted
from motofmi.gap.models.kalman import Discrete, LinearisedForce, errors, errors_and_slopes
from motofmi.gap.models.linear_model import LinearModel
from motofmi.gap.models.nonlinear_effects import NonlinearForce, is_linear, vehicle_of
from motofmi.gap.preprocessing.best_prediction import with_best_prediction
from motofmi.gap.preprocessing.flexible_noise_model import features_of
from motofmi.gap.preprocessing.predicted_run import PredictedRun

BEFORE = 0.03  # s, span of the backward difference for rates
NEWTON_STEPS, SETTLED = 8, 1e-4  # Newton steps of the predicted motion, and the relative change at which they end
MATRIX_STEP = 1e-6  # relative step of the matrices for derivatives of the sampled matrices and gains
DEVIATION_STEP = 1e-3  # the same of the states' standard deviations
FAR = 1e3  # prediction error over the largest measured value above which a prediction diverges

Filter = tuple[Discrete, np.ndarray, np.ndarray]  # matrices per step, gains, standard deviations of the states


class PredictorModel(LinearModel):
    """One-step predictions for estimation."""

    def __init__(self, experiment: VehicleOverSpeedExperiment, effects: Sequence[type[Effect]] = ()):
        super().__init__(experiment, effects)
        self.prefix = f"{experiment.part}." if experiment.part else ""
        self.linear_part = experiment.with_effects([e for e in effects if is_linear(experiment, e)])
        nonlinear = not all(is_linear(experiment, e) for e in effects)
        self.nonlinear = (
            NonlinearForce(
                self.component,
                self.linear_part,
                experiment.over,
                {n: row for n, row in zip(self.own, self.rows, strict=True) if n not in experiment.unrestricted},
            )
            if nonlinear
            else None
        )

    @np.errstate(all="ignore")  # divergence raises an InputError
    def reduced(self, run: PredictedRun, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The negative prediction errors (m,) and their derivatives (m, np), over their standard deviation."""
        wanted = range(self.sloped_from, len(q))
        driven, slopes = self._driven(run, q, wanted)
        noise = self._noise(run, q)
        (made, K, deviations), (changes, dK, deviation_slopes) = self._filter(
            run, driven, slopes, noise, self._noise_slopes(run, wanted)
        )
        forces_near, motion = self._linearised_forces(run, q, made, K, deviations)
        inputs, by_parameter = self._input_derivatives(run, q, motion, (deviations, deviation_slopes), wanted)
        _, place, share = run.speeds
        left = np.zeros((len(run.measured), len(run.outputs)))
        slopes_of_errors = np.zeros((*left.shape, len(wanted)))
        for (first, last), force in zip(run.intervals, forces_near, strict=True):
            y, u = centred(run, inputs, first, last)
            du = np.array([_changes(run, each, first, last, u.shape[1]) for each in by_parameter]).reshape(
                len(by_parameter), len(u), -1
            )
            left[first:last], slopes_of_errors[first:last] = errors_and_slopes(
                made, changes, K, dK, place[first:last], share[first:last], y, u, du, force
            )
        if not np.max(np.abs(left)) < FAR * np.max(np.abs(run.measured)):
            raise InputError(f"{self.component.name}: the prediction of {run.name} diverges")
        jacobian = np.zeros((len(run.data), len(q)))
        jacobian[:, self.sloped_from :] = -run.whitened(slopes_of_errors)
        return -run.whitened(left), jacobian

    def with_remaining_noise(self, run: PredictedRun, q: np.ndarray) -> PredictedRun:
        """The run itself: its noise floor does not depend on the vehicle's parameters."""
        del q
        return run

    @np.errstate(all="ignore")
    def with_estimated_disturbances(self, run: PredictedRun, q: np.ndarray) -> PredictedRun:
        """The run with disturbances and noise estimated for this vehicle, and with the noise floor
        of its predictions."""
        driven, _ = self._driven(run, q)
        inputs = self._signals(run, q)
        noise = estimated(run, driven, inputs) if run.noise is None else self._noise(run, q)
        made, K, deviations = self._with_gains(run, driven, noise)
        motion = (
            self._linearised_forces(run, q, made, K, deviations)[1]
            if self.nonlinear
            else predicted(run, made, K, inputs)[1]
        )
        run = run.with_noise(
            noise, dict(zip(self.linear_part.states, motion.T, strict=False))
        )  # those of disturbances are last
        if run.mixing is not None:
            return run
        features = features_of(*self._known_before(run), [np.zeros(len(run.recording.time))])
        recorded = np.column_stack(
            [np.zeros((len(run.measured), 0)), *(run.averaged(run.recording[n]) for n in run.inputs)]
        )
        return with_best_prediction(run, recorded, [run.averaged(f) for f in features])

    def with_disturbances_as_estimated(self, x: np.ndarray) -> np.ndarray:
        """The vector x with factors of 1 on the disturbances and the sensor noise that were estimated for the runs."""
        found = x.copy()
        found[self._factors] = 0.0
        return found

    # Matrices -------------------------------------------------------------------------------------------

    def _driven(
        self, run: PredictedRun, q: np.ndarray, wanted: Sequence[int] = ()
    ) -> tuple[DisturbedVehicle, DisturbedVehicle]:
        """The vehicle at the run's speeds, and its derivatives (np, g, ...) by the parameters that are wanted."""
        step = self.steps(q)
        parameters = np.stack([q, *(q + np.eye(len(q))[i] * step[i] for i in wanted)])
        every = [self.values(x) for x in parameters]
        values: dict[str, Any] = {n: np.array([v[n] for v in every])[:, None] for n in self.linear_part.values}
        space = linearise(self.linear_part, **{**values, self.experiment.over: run.speeds[0]})
        grid = len(run.speeds[0])
        A, B, C, D = (
            np.broadcast_to(m, (len(every), grid, *m.shape[-2:])) for m in (space.A, space.B, space.C, space.D)
        )
        outputs = [space.outputs.index(self.linear_part.sensor_output(self.prefix + n)) for n in run.outputs]
        inputs = [space.inputs.index(n) for n in self._inputs(run)]
        forces = [space.inputs.index(self.prefix + n) for n in FORCES if self.prefix + n in space.inputs]
        rows = np.zeros((*A.shape[:2], A.shape[-1], len(self._forced_states)))
        rows[..., [space.states.index(n) for n in self._forced_states], range(len(self._forced_states))] = 1.0
        B_all = np.concatenate([B[..., inputs], rows], axis=-1)
        D_all = np.concatenate(
            [D[..., outputs, :][..., inputs], np.zeros((*A.shape[:2], len(outputs), len(self._forced_states)))], axis=-1
        )
        forcing = B[..., forces]
        for name, (source, _) in self.linear_part.delays.items():  # disturbances are not delayed
            forcing = forcing + B[..., [space.inputs.index(name)]] * [float(space.inputs[f] == source) for f in forces]
        parts = (A, B_all, C[..., outputs, :], D_all, forcing)
        here = DisturbedVehicle(*(p[0] for p in parts))
        return here, DisturbedVehicle(*((p[1:] - p[0]) / step[list(wanted)].reshape(-1, 1, 1, 1) for p in parts))

    def _filter(
        self,
        run: PredictedRun,
        driven: DisturbedVehicle,
        slopes: DisturbedVehicle,
        noise: np.ndarray,
        by_noise: np.ndarray,
    ) -> tuple[Filter, Filter]:
        """Matrices per step (g, ...), gains (g, nx, ny), standard deviations of the states (g, nx), and derivatives
        (np, g, ...) of all."""
        here = made, K, deviations = self._with_gains(run, driven, noise)
        count, grid = len(slopes.A), len(driven.A)
        if not count:
            return here, (
                Discrete(*(np.zeros((0, *m.shape)) for m in made.parts)),
                np.zeros((0, *K.shape)),
                np.zeros((0, *deviations.shape)),
            )
        parts = [(getattr(driven, n), getattr(slopes, n)) for n in ("A", "B", "C", "D", "W")]
        relative_change = np.max(
            [
                np.abs(change).max(axis=(1, 2, 3)) / max(np.abs(value).max(), 1e-300)
                for value, change in parts
                if value.size
            ],
            axis=0,
        )
        scale = MATRIX_STEP / np.maximum(np.maximum(relative_change, np.abs(by_noise).max(axis=1)), 1e-12)
        perturbed_noise = np.repeat(noise + scale[:, None] * by_noise, grid, axis=0)
        flat = DisturbedVehicle(
            *(
                (value + scale.reshape(-1, 1, 1, 1) * change).reshape(count * grid, *value.shape[1:])
                for value, change in parts
            )
        )
        perturbed, gains, perturbed_deviations = self._with_gains(run, flat, perturbed_noise)
        changes = [(other.reshape(count, *value.shape) - value) / scale.reshape(-1, *(1,) * value.ndim)
                   for other, value in zip((*perturbed.parts, gains, perturbed_deviations),
                                          (*made.parts, K, deviations), strict=True)]  # fmt: skip
        return here, (Discrete(*changes[:-2]), changes[-2], changes[-1])

    def _with_gains(self, run: PredictedRun, driven: DisturbedVehicle, noise: np.ndarray) -> Filter:
        """Matrices per step, gains, standard deviations of the states. Raises InputError without a
        stationary prediction."""
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
        """The derivatives (np, k) of psi by the parameters that are wanted."""
        assert run.noise is not None
        slopes = np.zeros((len(wanted), len(run.noise)))
        for k, place in enumerate(self._factors):
            slopes[[i == place for i in wanted], k] = 1.0
        return slopes

    @cached_property
    def _factors(self) -> list[int]:
        """The indices in a vector of the logarithms of psi's factors; none where they are not free."""
        return [i for i, n in enumerate(self.base) if n.startswith(f"{self.prefix}{FAMILY}.")]

    # Inputs ---------------------------------------------------------------------------------------------

    @property
    def _forced_states(self) -> tuple[str, ...]:
        """The states on whose rates nonlinear forces act."""
        return self.nonlinear.rows if self.nonlinear else ()

    def _inputs(self, run: PredictedRun) -> list[str]:
        """The inputs of the vehicle that are given: recorded ones, then delayed ones."""
        return [
            *(self.prefix + n for n in run.inputs),
            *(n for n, (_, delay) in self.linear_part.delays.items() if delay in dict(self._lagging(run)).values()),
        ]

    def _input_derivatives(
        self,
        run: PredictedRun,
        q: np.ndarray,
        motion: np.ndarray,
        deviations: tuple[np.ndarray, np.ndarray],
        wanted: Sequence[int],
    ) -> tuple[np.ndarray, np.ndarray]:
        """The inputs (n, nu) and their derivatives (np, n, nu + nb) by the parameters that are wanted,
        nonlinear forces last."""
        here, step = self._signals(run, q), self.steps(q)
        lags = {delay for _, delay in self.component.delays.values()}
        by_parameter = np.zeros((len(wanted), len(here), here.shape[1] + len(self._forced_states)))
        for place, i in enumerate(wanted):
            if self.names[i] in lags:
                by_parameter[place, :, : here.shape[1]] = (
                    self._signals(run, q + np.eye(len(q))[i] * step[i]) - here
                ) / step[i]
        if self.nonlinear:
            middle = len(deviations[0]) // 2  # of the speeds
            deviation, values = deviations[0][middle], self.values(q)
            forcing = self.nonlinear.expected(run, values, motion, deviation)
            wider = self.nonlinear.expected(run, values, motion, (1 + DEVIATION_STEP) * deviation)
            by_deviation = (wider - forcing) / DEVIATION_STEP
            for place, i in enumerate(wanted):
                by_parameter[place, :, here.shape[1] :] = by_deviation * self.nonlinear.share(
                    deviations[1][place, middle], deviation
                )
                if self.names[i] in self.nonlinear.depends_on:
                    perturbed = self.values(q + np.eye(len(q))[i] * step[i])
                    other = self.nonlinear.expected(run, perturbed, motion, deviation)
                    by_parameter[place, :, here.shape[1] :] += (other - forcing) / step[i]
        return here, by_parameter

    def _signals(self, run: PredictedRun, q: np.ndarray) -> np.ndarray:
        values, time, recorded = self.values(q), run.recording.time, run.recording.columns
        inputs = [recorded[n] for n in run.inputs]
        inputs += [
            CubicSpline(time, recorded[source])(np.maximum(time - values[delay], time[0]))
            for source, delay in self._lagging(run)
        ]
        return np.column_stack([np.zeros((len(run.measured), 0)), *(run.interpolable(x) for x in inputs)])

    def _lagging(self, run: PredictedRun) -> list[tuple[str, str]]:
        """The recorded inputs that are delayed, with the parameters of their delays."""
        every = ((source.removeprefix(self.prefix), delay) for source, delay in self.linear_part.delays.values())
        return [(source, delay) for source, delay in every if source in run.inputs]

    # Nonlinear forces ------------------------------------------------------------------------------------

    def _linearised_forces(
        self, run: PredictedRun, q: np.ndarray, made: Discrete, K: np.ndarray, deviations: np.ndarray
    ) -> tuple[list[LinearisedForce | None], np.ndarray]:
        """For every interval the nonlinear forces linearised about the predicted motion (n, nx), by Newton's method."""
        motion = np.zeros((len(run.measured), K.shape[1]))
        for i, state in enumerate(self.linear_part.states):
            motion[:, i] = run.motion.get(state, 0.0)
        if not self.nonlinear:
            return [None] * len(run.intervals), motion
        values, inputs, (_, place, share) = self.values(q), self._signals(run, q), run.speeds
        for _ in range(NEWTON_STEPS):
            force = self.nonlinear.near(run, values, motion, deviations[len(deviations) // 2])
            before, motion = motion, np.zeros_like(motion)
            for first, last in run.intervals:
                y, u = centred(run, inputs, first, last)
                motion[first:last] = errors(
                    made, K, place[first:last], share[first:last], y, u, force.between(first, last)
                )[1]
            if np.all(np.abs(motion - before).max(axis=0) <= SETTLED * np.abs(motion).max(axis=0)):
                break
        force = self.nonlinear.near(run, values, motion, deviations[len(deviations) // 2])
        return [force.between(first, last) for first, last in run.intervals], motion

    def _known_before(self, run: PredictedRun) -> tuple[list[np.ndarray], list[np.ndarray]]:
        """Measured deflections of elements and their rates (N,) by backward differences,
        independent of later samples."""
        back = max(int(BEFORE * run.recording.rate), 1)
        columns = run.recording.columns
        deflections = [
            columns[e.deflection] for e in vehicle_of(self.experiment).elements.values() if e.deflection in columns
        ]
        return deflections, [
            (d - np.concatenate([np.full(back, d[0]), d[:-back]])) * run.recording.rate / back for d in deflections
        ]


def _changes(run: PredictedRun, by_parameter: np.ndarray, first: int, last: int, count: int) -> np.ndarray:
    """Derivatives (n + 1, nu + nb) of inputs and nonlinear forces in an interval; only those of inputs are centred."""
    nonlinear = by_parameter[first:last, count:]
    return np.hstack(
        [centred(run, by_parameter[:, :count], first, last)[1], np.concatenate([nonlinear, nonlinear[-1:]])]
    )
