r"""A fitted model simulated open loop over whole recordings, and its refit to the error of that simulation.

    e_k = limited(m_k(q, x_0) + o) - y_k,   q, o = argmin of the sum of e_k^2 over all samples of all runs
    x_0(q, o) = argmin of the sum of e_k^2 over the first w samples of a run

The workflow compares models over segments of a few periods, each with initial states of its own, so that errors of the
model do not accumulate and its values describe the physics. In open loop errors accumulate over a whole recording, and
the values that predict it best are those of the least simulation error (output error; Ljung, System Identification, 2nd
ed. (1999), Sect. 7.2). The initial states are those of the prediction: they rest on the first w samples, and follow q
and o by the implicit derivative dx_0/dq = -(J_x' J_x)^-1 J_x' J_q. A sensor reads no further than the limits at which
samples of the runs are; there, a model beyond the limit has no error (censored data; Tobin, Econometrica 26 (1958) 24).
A motion that decays within a step of the simulation is not distinguishable from one that decays at once, and its error
has many minima at the switching of the overflow from sample to sample; relative rates of decay are therefore bounded.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from fmus.declaration.variables import Variable
from fmus.support.errors import InputError
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.models.segmented import Nodes
from motofmi.gap.models.simulation import Trajectory
from motofmi.gap.preprocessing.input_interpolation import INTERPOLATIONS
from motofmi.gap.preprocessing.sampled_run import SampledRun
from motofmi.gap.preprocessing.sampled_run_preparation import sampled_run
from motofmi.recordings.quality import clipped
from motofmi.recordings.recording import Recording

DIVERGED = 1e3  # residual over an output's standard deviation where a trial cannot be simulated
STEPS = 8  # simulation steps per sample
# Largest last step of Newton's method over a state's rms: less than in other comparisons, so that the error of a trial
# hardly depends on the trial before it, from whose states the method begins.
ACCURATE = 1e-6
MOST_TRIALS = 100  # simulations of a fit
RANK = 1e-9  # relative singular value below which initial states are not identifiable from the first samples


@dataclass(frozen=True)
class Simulated:
    """A simulation: outputs (n, outputs), and their derivatives by initial states (n, outputs, nx), by parameters and
    offsets (n, outputs, np + outputs); zero where a sensor is at its limit."""

    outputs: np.ndarray
    by_state: np.ndarray
    by_parameters: np.ndarray


@dataclass(frozen=True)
class OpenLoop:
    """A fitted model for simulation.

    q (np,) is the vector of `model`, with the mean sensor offsets of the fitted runs; offset (outputs,) are the offsets
    of the outputs, in their units; limits (2, outputs) those between which the sensors read. The initial states fit the
    first `window` samples. interpolation is that of the inputs.
    """

    model: Any  # FreeInitialStateModel
    q: np.ndarray
    offset: np.ndarray
    limits: np.ndarray
    window: int
    interpolation: str

    @property
    def fitted_numbers(self) -> int:
        """The number of fitted values: of the base, of the effects, and of the offsets of inputs and outputs."""
        return len(self.q) + len(self.offset)

    def simulated(self, recording: Recording) -> np.ndarray:
        """The outputs (n, outputs) over a recording. Raises InputError where it cannot be simulated."""
        run = self.prepared(sampled_run(recording.from_zero(), self.model.experiment))
        return self.over(run, self.initial_states(run)).outputs

    def prepared(self, run: SampledRun) -> SampledRun:
        """The run in one segment, with the interpolation and the steps of this simulation."""
        run = replace(run.with_interpolation(self.interpolation), steps_per_sample=STEPS)
        return replace(run, intervals=[(0, len(run.measured))], stable_length=None).cut(len(run.measured))

    def initial_states(self, run: SampledRun) -> np.ndarray:
        """The initial states (nx,) that fit the first samples of a run best.

        Raises InputError where these cannot be simulated from the first guess.
        """
        first, measured = self.model.first_states(run, 0), run.measured[: self.window]
        slopes: np.ndarray = np.zeros(0)

        def misfit(x: np.ndarray) -> np.ndarray:
            nonlocal slopes
            try:
                made = self.over(run, x, self.window)
            except InputError:
                if not len(slopes):
                    raise
                return np.full(measured.size, DIVERGED * measured.std())
            slopes = made.by_state.reshape(-1, len(x))
            return (made.outputs - measured).ravel()

        return least_squares(misfit, first, lambda _: slopes, x_scale="jac").x if len(first) else first

    def over(self, run: SampledRun, x: np.ndarray, length: int = 0, by_parameters: bool = False) -> Simulated:
        """A run, or its first samples, simulated from initial states x (nx,).

        Raises InputError where it cannot be simulated.
        """
        values = self.model.values(self.q) | dict.fromkeys(self.model.durations, run.duration)
        made, nodes = self._accurate(run, values, {0: x}, length)
        where = nodes.samples[0]
        outputs = made.outputs[where] + self.offset
        n, ny = outputs.shape
        inside = ((self.limits[0] < outputs) & (outputs < self.limits[1]))[:, :, None]
        slopes = np.zeros((n, ny, len(self.q) + ny if by_parameters else 0))
        if by_parameters:
            fitted = self.model.equations.parameters
            scale = [values[name] if name in self.model.base else 1.0 for name in fitted]
            slopes[:, :, [self.model.names.index(name) for name in fitted]] = made.slopes[where] * scale
            slopes[:, :, len(self.q) :] = np.eye(ny)
        by_state = np.zeros((n, ny, 0)) if made.initial_slopes is None else made.initial_slopes[where]
        return Simulated(np.clip(outputs, *self.limits), by_state * inside, slopes * inside)

    def _accurate(
        self, run: SampledRun, values: dict[str, float], initial: dict[int, np.ndarray], length: int
    ) -> tuple[Trajectory, Nodes]:
        """The trajectory and its nodes; simulated afresh where it is not found from that of the last trial."""
        try:
            return self.model.simulated(run, [0], values, initial, length, ACCURATE)
        except InputError:
            if length or not run.guess:
                raise
        run.guess.clear()
        return self.model.simulated(run, [0], values, initial, length, ACCURATE)

    def error(self, run: SampledRun) -> np.ndarray:
        """The simulation error (n, outputs) over a prepared run after the first samples."""
        return (self.over(run, self.initial_states(run)).outputs - run.measured)[self.window :]

    def mean_square(self, runs: Sequence[SampledRun]) -> float:
        """The mean square error over prepared runs, each output over its standard deviation.

        It is infinite where a run cannot be simulated.
        """
        try:
            return float(np.mean([np.mean((self.error(run) / run.measured.std(axis=0)) ** 2) for run in runs]))
        except InputError:
            return np.inf


def open_loop(found: Fit, runs: Sequence[SampledRun], window: int) -> OpenLoop:
    """A fit for simulation with its own values; only the offsets of the outputs are estimated from whole runs."""
    model: Any = found.model
    q = np.mean([found.of_run(index) for index in range(len(found.runs))], axis=0)
    limits = np.array([_limits(y) for y in np.concatenate([run.measured for run in runs]).T]).T
    made = OpenLoop(model, q, np.zeros(limits.shape[1]), limits, window, found.runs[0].kind)
    return _fitted(made, [made.prepared(run) for run in runs], np.arange(len(q), made.fitted_numbers))


def refitted_in_open_loop(made: OpenLoop, runs: Sequence[SampledRun]) -> OpenLoop:
    """The simulation with the values that have the least error over whole runs. Delays keep their values.

    Each interpolation of the inputs is tried. The error has several minima: fits with the initial states as unknowns of
    their own, and with those that follow the values, end in different ones. The result is that with the least error,
    which may be the simulation itself.
    """
    every = np.arange(made.fitted_numbers)

    def fitted(start: OpenLoop, following: bool = False) -> OpenLoop:
        return _fitted(start, [start.prepared(run) for run in runs], every, following)

    def least(tried: Sequence[OpenLoop]) -> OpenLoop:
        return min(tried, key=lambda each: each.mean_square([each.prepared(run) for run in runs]))

    free = least([fitted(replace(made, interpolation=kind)) for kind in INTERPOLATIONS])
    starts = replace(made, interpolation=free.interpolation), free
    return least([made, free, *(fitted(start, following=True) for start in starts)])


def _fitted(made: OpenLoop, runs: Sequence[SampledRun], free: np.ndarray, following: bool = False) -> OpenLoop:
    """The simulation with the least error over prepared runs by the parameters and offsets `free` (indices).

    The initial states are unknowns as well or, with `following`, those that fit the first samples. The same simulation
    where a run cannot be simulated from its beginning to its end.
    """
    first, scale = np.concatenate([made.q, made.offset]), np.std(np.concatenate([run.measured for run in runs]), axis=0)
    try:
        states = [] if following else [made.initial_states(run) for run in runs]
    except InputError:
        return made
    edges = np.cumsum([len(free), *map(len, states)])
    slopes: np.ndarray = np.zeros((sum(run.measured.size for run in runs), edges[-1]))

    def at(z: np.ndarray) -> OpenLoop:
        every = first.copy()
        every[free] = z[: len(free)]
        return replace(made, q=every[: len(made.q)], offset=every[len(made.q) :])

    def misfit(z: np.ndarray) -> np.ndarray:
        nonlocal slopes
        here, left, blocks = at(z), [], []
        try:
            for index, run in enumerate(runs):
                x = here.initial_states(run) if following else z[edges[index] : edges[index + 1]]
                simulated = here.over(run, x, by_parameters=True)
                left.append(((simulated.outputs - run.measured) / scale).ravel())
                blocks.append(_slopes(simulated, made.window if following else 0, index, edges, free) / scale[:, None])
        except InputError:
            return np.full(len(slopes), DIVERGED)
        slopes = np.concatenate([block.reshape(-1, edges[-1]) for block in blocks])
        return np.concatenate(left)

    rows = [None] * len(made.model.base) + list(made.model.rows) + [None] * len(made.offset)
    low, high = np.full(edges[-1], -np.inf), np.full(edges[-1], np.inf)
    low[: len(free)] = [-np.inf if rows[i] is None else rows[i].min for i in free]
    high[: len(free)] = [np.inf if rows[i] is None else _greatest(rows[i], runs[0]) for i in free]
    start = np.clip(np.concatenate([first[free], *states]), low, high)
    if misfit(start)[0] == DIVERGED:
        return made
    return at(least_squares(misfit, start, lambda _: slopes, (low, high), x_scale="jac", max_nfev=MOST_TRIALS).x)


def _slopes(made: Simulated, window: int, index: int, edges: np.ndarray, free: np.ndarray) -> np.ndarray:
    """The derivatives (n, outputs, unknowns) of a run by the free values, and by its own initial states where these are
    unknowns; with a window, by the free values with the initial states that follow them."""
    found = np.zeros((*made.outputs.shape, edges[-1]))
    found[:, :, : len(free)] = made.by_parameters[:, :, free]
    if window:
        of_states, of_values = (part[:window].reshape(-1, part.shape[2]) for part in (made.by_state, found))
        found -= made.by_state @ np.linalg.lstsq(of_states, of_values, rcond=RANK)[0]
    else:
        found[:, :, edges[index] : edges[index + 1]] = made.by_state
    return found


def _greatest(row: Variable, run: SampledRun) -> float:
    """The upper bound of a fitted value; that of a relative rate of decay is one over a step of the simulation."""
    return min(row.max, run.recording.rate * run.steps_per_sample) if row.unit == "1/s" else row.max


def _limits(measured: np.ndarray) -> tuple[float, float]:
    """The limits between which a sensor reads (n,), infinite where no sample is at one."""
    low, high = (bool(len(clipped(sign * measured))) for sign in (-1, 1))
    return (float(measured.min()) if low else -np.inf), (float(measured.max()) if high else np.inf)
