"""The base with some effects on runs of known motion: their outputs on harmonics of it, and the derivatives of these."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from fmus.composition.imposed_motion import ImposedMotion, ImposedThroughSpring
from fmus.effects import Effect
from fmus.support.errors import InputError
from motofmi.gap.experiments.experiment import ImposedMotionExperiment
from motofmi.gap.experiments.input_output import InputOutputExperiment
from motofmi.gap.models.base_and_effects import BaseAndEffects
from motofmi.gap.models.collocation import Motion
from motofmi.gap.models.equations import Equations, rate_of
from motofmi.gap.models.simulation import Trajectory, simulate, simulate_by_continuation
from motofmi.gap.preprocessing.steer_test_run import SteerTestRun
from motofmi.recordings.recording import Recording


class HarmonicModel(BaseAndEffects):
    """Base and effects on runs of known motion, compared on harmonics."""

    def __init__(
        self,
        experiment: ImposedMotionExperiment | InputOutputExperiment,
        effects: Sequence[type[Effect]] = (),
        slopes_of_base: bool = True,
    ):
        super().__init__(experiment, effects, experiment.unrestricted)
        given = {experiment.parameter(e, n) for e in effects for n in e.given}
        self.durations = [n for n in given if n.endswith(".duration")]
        self.lags = {experiment.parameter(e, n) for e in effects for n in e.lags}
        late = next((e for e in effects if e.lags and not e.delayed), None)
        self.shift, self.shift_grows = (
            (experiment.parameter(late, late.lags[0]), late.lag_grows) if late else ("", False)
        )
        self.shift_over = experiment.parameter(late, "duration") if late and "duration" in late.given else ""
        exact = {delay for _, delay in self.component.delays.values()}
        wanted = self.names if slopes_of_base else [self.own[i] for i in self.sizes]
        self.sensitive = [n for n in wanted if n in exact or n not in self.lags]
        self.by_outputs: dict[tuple[str, ...], Equations] = {}  # not every model is simulated
        self.extended: HarmonicModel | None = None  # the model to which the latest effects were added
        self.found: dict[
            int, tuple[Recording, dict[str, np.ndarray]]
        ] = {}  # states of the last simulation, the guess of the next one
        self.begun: set[int] = set()  # recordings that this model has simulated; `found` may stem from another model
        self.fresh: dict[
            int, tuple[SteerTestRun, dict[str, float], Trajectory]
        ] = {}  # simulations without derivatives yet

    @property
    def equations(self) -> Equations:
        """The equations with the outputs of the experiment."""
        return self._equations_of(tuple(self.experiment.outputs))

    def _equations_of(self, outputs: tuple[str, ...]) -> Equations:
        if outputs not in self.by_outputs:
            self.by_outputs[outputs] = Equations(self.component, outputs, self.sensitive)
        return self.by_outputs[outputs]

    def with_added_effects(self, *effects: type[Effect], slopes_of_base: bool = True) -> "HarmonicModel":
        """The model with further effects."""
        joined = HarmonicModel(self.experiment, [*self.effects, *effects], slopes_of_base)
        joined.found, joined.extended = dict(self.found), self
        return joined

    def start_afresh(self, run: SteerTestRun) -> None:
        self.begun.discard(id(run.recording))

    def simulate_again(self, run: SteerTestRun, q: np.ndarray) -> None:
        self.outputs(run, q, slopes=False)

    def slopes(self, run: SteerTestRun, q: np.ndarray, from_last: bool = False) -> np.ndarray:
        held = self.states_without(self.values(q)) if from_last else 0
        return run.reduced(self.outputs(run, q, held=held)[1])

    def states_without(self, values: Mapping[str, float]) -> int:
        """The number of states of the model to which the latest effects were added, where these effects are absent for
        these values, so that they do not change its motion; otherwise 0."""
        without = self.extended
        if without is None or self.lags:
            return 0
        added = [i for i in self.sizes if i >= len(without.own)]
        states = without.component.states
        absent = (
            bool(added)
            and not any(values[self.own[i]] for i in added)
            and type(self.component) is type(without.component)
            and self.component.states[: len(states)] == states
        )
        return len(states) if absent else 0

    def outputs(
        self, run: SteerTestRun, q: np.ndarray, slopes: bool = True, held: int = 0
    ) -> tuple[np.ndarray, np.ndarray]:
        """Simulated outputs (n, ny) over the whole run, as it measures them, and their slopes (n, ny, np). The first
        `held` states are those of the last simulation."""
        values = self.values(q) | dict.fromkeys(self.durations, run.duration)
        whose, values_before, made = self.fresh.pop(id(run), (None, {}, None))
        if made is None or whose is not run or values_before != values:
            made = self._simulated(run, values, held)
            self.begun.add(id(run.recording))
            self.found[id(run.recording)] = (
                run.recording,
                dict(zip(self.component.states, made.states.T, strict=True)),
            )
        if not slopes:
            self.fresh[id(run)] = run, values, made
        time, y = run.recording.time, made.outputs[:: run.steps_per_sample]
        jacobian = np.zeros((len(self.names), *y.T.shape))
        if slopes:
            jacobian[[self.names.index(n) for n in self.sensitive]] = made.slopes[:: run.steps_per_sample].T
            jacobian[: len(self.base)] *= np.array([values[n] for n in self.base])[:, None, None]
        if self.shift:  # a delay of all inputs delays the effort; drift during a delay is neglected
            jacobian[self.names.index(self.shift), 0] = (
                -self._lag_per_size(values, time) * CubicSpline(time, y[:, 0])(time, 1) if slopes else 0.0
            )
            for i in range(1, y.shape[1]):  # further outputs are not delayed
                early = time + self.lag(values, time)
                y = np.column_stack([y[:, :i], CubicSpline(time, y[:, i])(early), y[:, i + 1 :]])
                jacobian[:, i] = CubicSpline(time, jacobian[:, i], axis=1)(early)
        return y, jacobian.T

    def reduced(self, run: SteerTestRun, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Reduced outputs (m,) and their slopes (m, np), both in units of the noise."""
        y, jacobian = self.outputs(run, q)
        both = run.reduced(np.concatenate([y[:, :, None], jacobian], axis=2))
        return both[:, 0], both[:, 1:]

    def predicted(self, run: SteerTestRun, q: np.ndarray) -> np.ndarray:
        """Reduced outputs (m,) in units of the noise."""
        return run.reduced(self.outputs(run, q, slopes=False)[0])

    def largest(self, runs: Sequence[SteerTestRun]) -> float:
        """The largest imposed motion in the runs."""
        return max(float(np.abs(run.motion_at(run.recording.time)[0]).max()) for run in runs)

    def with_remaining_noise(self, run: SteerTestRun, q: np.ndarray) -> SteerTestRun:
        """The run with the noise spectra of this model's residuals."""
        self.start_afresh(run)
        return run.with_remaining_noise(self.outputs(run, q, slopes=False)[0])

    def _simulated(self, run: SteerTestRun, values: Mapping[str, float], held: int) -> Trajectory:
        """The trajectory of a run; in the first simulation by continuation in the magnitudes of
        effects, if necessary."""
        equations, motion = self._measuring(run), self._motion(run, values)
        try:
            return simulate(equations, values, motion, self._guess(run), held=held)
        except InputError:
            sizes = [self.own[i] for i in self.sizes if values[self.own[i]]]
            if id(run.recording) in self.begun or not sizes:
                raise
            return simulate_by_continuation(equations, values, motion, sizes)

    def _measuring(self, run: SteerTestRun) -> Equations:
        """The equations with the outputs that a run measures."""
        names = (
            *self.experiment.outputs,
            *(self.experiment.further[output.column].output for output in run.outputs[1:]),
        )
        return self._equations_of(names)

    def _guess(self, run: SteerTestRun) -> np.ndarray | None:
        if id(run.recording) not in self.found or not self.component.states:
            return None
        known = self.found[id(run.recording)][1]
        return np.array([known.get(s, np.zeros(len(run.nodes))) for s in self.component.states]).T

    def lag(self, values: Mapping[str, float], time: np.ndarray) -> np.ndarray | float:
        """The delay of all inputs at times (n,) [s]."""
        return values[self.shift] * self._lag_per_size(values, time) if self.shift else 0.0

    def _lag_per_size(self, values: Mapping[str, float], time: np.ndarray) -> np.ndarray | float:
        """The factor of a delay's magnitude at times (n,) [s]."""
        return (time / values[self.shift_over] if self.shift_over else time) if self.shift_grows else 1.0

    def _motion(self, run: SteerTestRun, values: Mapping[str, float]) -> Motion:
        time = run.nodes
        middle = (time[1:] + time[:-1]) / 2
        at, between = (self._inputs(run, t - self.lag(values, t), values) for t in (time, middle))
        return Motion(time, at, between)

    def _inputs(self, run: SteerTestRun, time: np.ndarray, values: Mapping[str, float]) -> dict[str, np.ndarray]:
        angle, rate, acceleration = run.motion_at(time)
        component = self.component
        inputs: dict[str, Any] = dict.fromkeys(component.inputs, 0.0)
        if isinstance(component, ImposedMotion | ImposedThroughSpring):
            inputs |= {component.imposed: angle, component.rate: rate, component.acceleration: acceleration}
        for name, (_, delay) in component.delays.items():
            inputs[name], inputs[rate_of(name)], _ = run.motion_at(time - values[delay])
        return inputs
