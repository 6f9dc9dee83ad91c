"""The base with some effects, as a function that a fit can call: reduced output and its slopes for one run.

Fit, screening and verdict ask nothing of a run and a model but what `AnyRun` and `AnyModel` say. `Model` is that of a
recorded motion which is simulated; eigenvalues over speed, or samples with unknown initial states, bring their own.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from scipy.interpolate import CubicSpline

from fmus.component import Component
from fmus.effects import Effect
from fmus.errors import InputError
from fmus.imposed import Imposed, ThroughSpring
from fmus.variables import Variable
from identification.gap.data.runs import Run
from identification.gap.models.base_and_effects import BaseAndEffects
from identification.gap.models.equations import Equations, rate_of
from identification.gap.models.simulate import Motion, Trajectory, led_in, simulate
from identification.gap.stands.component_test import ComponentTest
from identification.gap.stands.test_stand import Free, TestStand
from identification.recordings import Recording


class AnyRun(Protocol):
    """One run as a fit sees it: data (m,) with independent errors of known deviation (m,), in any units."""

    @property
    def name(self) -> str: ...
    @property
    def data(self) -> np.ndarray: ...
    @property
    def deviation(self) -> np.ndarray: ...


class AnyStand(Protocol):
    """What is free in the base and what other tests say of it."""

    @property
    def free(self) -> tuple[Free, ...]: ...
    @property
    def measured_effects(self) -> Mapping[str, tuple[float, float]]: ...
    def parameter(self, effect: type[Effect], name: str) -> str:
        """The name of an effect's parameter in the component under test."""


class AnyModel(Protocol):
    """Base and effects as a fit sees them.

    A parameter vector (np,) is [log of the free base parameters, the effects' parameters as they are]; `base`, `own`
    and `names` are the names of these parts and of the whole, `rows` the table's rows of `own`, `sizes` the places
    in `own` of those in which what an effect adds is linear. `component` has the table of everything.
    Where slopes cost much, there may be `predicted(run, q)`, which gives the first half of `reduced` alone.
    """

    stand: Any  # AnyStand
    effects: tuple[type[Effect], ...]
    component: Component
    base: list[str]
    own: list[str]
    names: list[str]
    rows: list[Variable]
    sizes: list[int]

    def joined_by(self, *effects: type[Effect], slopes_of_base: bool = True) -> "AnyModel":
        """The model with further effects; without slopes of the base, columns of `reduced` other than by sizes may be zero.

        Raises InputError where an effect cannot join.
        """

    def anew(self, run: Any) -> None:
        """What is simulated of a run next is no trial of a fit."""

    def start(self, shapes: Mapping[str, float] | None = None) -> np.ndarray:
        """The vector of the component's own values, some of the effects' replaced."""

    def values(self, q: np.ndarray) -> dict[str, float]:
        """All parameter values by name for a vector."""

    def reduced(self, run: Any, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What the model says of a run's data (m,), and its slopes (m, np), both over the run's deviation.

        Unknowns of the run alone (initial states) are taken out here. Raises InputError where it cannot be simulated.
        """

    def unknowns(self, run: Any) -> int:
        """How many numbers of a run alone are taken out of it."""

    def largest(self, runs: Sequence[Any]) -> float:
        """The largest motion in the runs, of which the `relative` starts of effects are shares."""

    def with_noise_beside(self, run: Any, q: np.ndarray) -> Any:
        """The run with the noise that is left beside this model; the run itself where its noise is known otherwise."""


class Model(BaseAndEffects):
    """Base and effects on runs whose motion is known."""

    def __init__(self, stand: TestStand | ComponentTest, effects: Sequence[type[Effect]] = (), slopes_of_base: bool = True):
        super().__init__(stand, effects, stand.open)
        given = {stand.parameter(e, n) for e in effects for n in e.given}
        self.durations = [n for n in given if n.endswith(".duration")]
        self.lags = {stand.parameter(e, n) for e in effects for n in e.lags}
        late = next((e for e in effects if e.lags and not e.delayed), None)
        self.shift, self.shift_grows = (stand.parameter(late, late.lags[0]), late.lag_grows) if late else ("", False)
        self.shift_over = stand.parameter(late, "duration") if late and "duration" in late.given else ""
        exact = {delay for _, delay in self.component.delays.values()}
        wanted = self.names if slopes_of_base else [self.own[i] for i in self.sizes]
        self.sensitive = [n for n in wanted if n in exact or n not in self.lags]
        self.equations = Equations(self.component, stand.outputs, self.sensitive)
        self.by_outputs: dict[tuple[str, ...], Equations] = {self.equations.outputs: self.equations}
        self.found: dict[int, tuple[Recording, dict[str, np.ndarray]]] = {}  # the last states by name, from which the next simulation starts
        self.begun: set[int] = set()  # recordings that this very model has simulated: `found` may be another's
        self.fresh: dict[int, tuple[Run, dict[str, float], Trajectory]] = {}  # whose slopes were not asked for yet

    def joined_by(self, *effects: type[Effect], slopes_of_base: bool = True) -> "Model":
        """The model with further effects."""
        joined = Model(self.stand, [*self.effects, *effects], slopes_of_base)
        joined.found = dict(self.found)
        return joined

    def anew(self, run: Run) -> None:
        self.begun.discard(id(run.recording))

    def outputs(self, run: Run, q: np.ndarray, slopes: bool = True) -> tuple[np.ndarray, np.ndarray]:
        """Simulated outputs (n, ny) over the whole run, as it measures them, and their slopes (n, ny, np)."""
        values = self.values(q) | dict.fromkeys(self.durations, run.duration)
        whose, told, made = self.fresh.pop(id(run), (None, {}, None))
        if made is None or whose is not run or told != values:
            made = self._simulated(run, values)
            self.begun.add(id(run.recording))
            self.found[id(run.recording)] = (run.recording, dict(zip(self.equations.states, made.states.T, strict=True)))
        if not slopes:
            self.fresh[id(run)] = run, values, made
        time, y = run.recording.time, made.outputs[:: run.finer]
        jacobian = np.zeros((len(self.names), *y.T.shape))
        if slopes:
            jacobian[[self.names.index(n) for n in self.sensitive]] = made.slopes[:: run.finer].T
            jacobian[: len(self.base)] *= np.array([values[n] for n in self.base])[:, None, None]
        if self.shift:  # all that is told arrives later, so the effort does; drift over a lag is nothing
            jacobian[self.names.index(self.shift), 0] = -self._lag_per_size(values, time) * CubicSpline(time, y[:, 0])(time, 1) if slopes else 0.0
            for i in range(1, y.shape[1]):  # what else is measured is on time
                early = time + self.lag(values, time)
                y = np.column_stack([y[:, :i], CubicSpline(time, y[:, i])(early), y[:, i + 1 :]])
                jacobian[:, i] = CubicSpline(time, jacobian[:, i], axis=1)(early)
        return y, jacobian.T

    def reduced(self, run: Run, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Reduced outputs (m,) and their slopes (m, np), both in units of the noise."""
        y, jacobian = self.outputs(run, q)
        both = run.reduced(np.concatenate([y[:, :, None], jacobian], axis=2))
        return both[:, 0], both[:, 1:]

    def predicted(self, run: Run, q: np.ndarray) -> np.ndarray:
        """Reduced outputs (m,) in units of the noise."""
        return run.reduced(self.outputs(run, q, slopes=False)[0])

    def largest(self, runs: Sequence[Run]) -> float:
        """The largest imposed motion in the runs."""
        return max(float(np.abs(run.moved(run.recording.time)[0]).max()) for run in runs)

    def with_noise_beside(self, run: Run, q: np.ndarray) -> Run:
        """The run with the noise of what this model leaves."""
        self.anew(run)
        return run.with_noise_beside(self.outputs(run, q, slopes=False)[0])

    def _simulated(self, run: Run, values: Mapping[str, float]) -> Trajectory:
        """The trajectory of a run. In one that is new to this model, a stiff effect may have to grow to its size."""
        equations, motion = self._measuring(run), self._motion(run, values)
        try:
            return simulate(equations, values, motion, self._guess(run))
        except InputError:
            sizes = [self.own[i] for i in self.sizes if values[self.own[i]]]
            if id(run.recording) in self.begun or not sizes:
                raise
            return led_in(equations, values, motion, sizes)

    def _measuring(self, run: Run) -> Equations:
        """The equations with the outputs that a run measures."""
        names = (*self.stand.outputs, *(self.stand.further[output.column].output for output in run.outputs[1:]))
        if names not in self.by_outputs:
            self.by_outputs[names] = Equations(self.component, names, self.sensitive)
        return self.by_outputs[names]

    def _guess(self, run: Run) -> np.ndarray | None:
        if id(run.recording) not in self.found or not self.equations.states:
            return None
        known = self.found[id(run.recording)][1]
        return np.array([known.get(s, np.zeros(len(run.nodes))) for s in self.equations.states]).T

    def lag(self, values: Mapping[str, float], time: np.ndarray) -> np.ndarray | float:
        """By how much all that is told arrives later, at times (n,) [s]."""
        return values[self.shift] * self._lag_per_size(values, time) if self.shift else 0.0

    def _lag_per_size(self, values: Mapping[str, float], time: np.ndarray) -> np.ndarray | float:
        """What the size of a lag is multiplied by, at times (n,) [s]."""
        return (time / values[self.shift_over] if self.shift_over else time) if self.shift_grows else 1.0

    def _motion(self, run: Run, values: Mapping[str, float]) -> Motion:
        time = run.nodes
        middle = (time[1:] + time[:-1]) / 2
        at, between = (self._inputs(run, t - self.lag(values, t), values) for t in (time, middle))
        return Motion(time, at, between)

    def _inputs(self, run: Run, time: np.ndarray, values: Mapping[str, float]) -> dict[str, np.ndarray]:
        angle, rate, acceleration = run.moved(time)
        component = self.component
        told: dict[str, Any] = dict.fromkeys(component.inputs, 0.0)
        if isinstance(component, Imposed | ThroughSpring):
            told |= {component.imposed: angle, component.rate: rate, component.acceleration: acceleration}
        for name, (_, delay) in component.delays.items():
            told[name], told[rate_of(name)], _ = run.moved(time - values[delay])
        return told
