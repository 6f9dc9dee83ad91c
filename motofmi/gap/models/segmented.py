"""Base and effects simulated over segments of a recording together, each from initial states of its own."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import chain, pairwise, takewhile
from typing import Any

import numpy as np

from fmus.support.errors import InputError
from motofmi.gap.experiments.state_rates import rates_of_states
from motofmi.gap.models.collocation import DivergenceError, Motion, inner_times
from motofmi.gap.models.equations import rate_of
from motofmi.gap.models.harmonic_model import HarmonicModel
from motofmi.gap.models.implicit_formulas import HERMITE_SIMPSON, ImplicitFormula, formula_for
from motofmi.gap.models.newton_method import CONVERGED
from motofmi.gap.models.simulation import MANY_PIECES, Trajectory, simulate
from motofmi.gap.preprocessing.sampled_run import MOST_STEPS, SampledRun

PIECE, SMALLEST_PIECE = 128, 1  # steps of a piece, where a trajectory is simulated piece by piece
WIDTH = "sliding_rate"  # the parameter that an experiment gives to effects with a transition
BEGINNING = 12  # samples from which a measured state's initial value and slope are estimated

Initial = Mapping[int, np.ndarray]  # states (nx,) by segment


@dataclass(frozen=True)
class Nodes:
    """Simulation nodes of segments: times (n,), the first node of each segment, and the nodes of its samples."""

    time: np.ndarray
    begins: np.ndarray
    samples: Sequence[slice]

    @property
    def pieces(self) -> Iterator[tuple[int, int]]:
        """The nodes [first, last) of every segment."""
        return pairwise([*self.begins.tolist(), len(self.time)])

    @property
    def step(self) -> float:
        """The simulation step [s]."""
        return float(self.time[1] - self.time[0])


def nodes_of(run: SampledRun, indices: Sequence[int], steps: int, length: int = 0) -> Nodes:
    """The nodes of some segments, or of their first `length` samples, with so many steps per sample."""
    first = np.array([run.segments[i][0] for i in indices])
    counts = np.array([min(run.segments[i][1] - run.segments[i][0], length or np.inf) for i in indices], int)
    sizes = (counts - 1) * steps + 1
    begins = np.cumsum(sizes) - sizes
    step = 1 / (run.recording.rate * steps)
    time = np.repeat(run.recording.time[first] - begins * step, sizes) + np.arange(sizes.sum()) * step
    return Nodes(time, begins, [slice(b, b + n, steps) for b, n in zip(begins.tolist(), sizes.tolist(), strict=True)])


class SegmentedModel(HarmonicModel):
    """Base and effects on sampled runs. The states of a segment's last simulation are the guess of the next one."""

    def steps_per_sample(self, run: SampledRun) -> int:
        """The simulation steps per sample: those of the run; at least one while dry friction passes through a
        transition that is narrower than at first, with the acceleration 2 pi f v of the largest rate v."""
        experiment, steps = self.experiment, run.steps_per_sample
        if not (experiment.narrowed and any(WIDTH in effect.given for effect in self.effects)):
            return steps
        change = 2 * np.pi * run.middle_frequency * experiment.largest_rate / run.recording.rate / steps
        most = MOST_STEPS // (len(run.measured) * steps)
        return steps * int(np.clip(np.ceil(change / experiment.sliding_rate), 1, max(most, 1)))

    def simulated(
        self, run: SampledRun, indices: Sequence[int], values: Mapping[str, float], initial: Initial, length: int = 0,
        accuracy: float = CONVERGED, held: int = 0, in_pieces: bool = True,
    ) -> tuple[Trajectory, Nodes]:  # fmt: skip
        """Segments, or their first `length` samples, simulated from initial states; at every node.

        accuracy and held are those of `simulate`. A single segment that does not converge as a whole is simulated
        piece by piece, if `in_pieces`.

        Raises InputError where one of several cannot be simulated with the others, or a single one neither from its
        last simulation nor, without one, piece by piece. A fit then takes a shorter step.
        """
        nodes, states = nodes_of(run, indices, self.steps_per_sample(run), length), self.equations.states
        formula = self._formula(values, nodes.step)
        times = nodes.time, inner_times(nodes.time, formula)
        at, between = (self._inputs(run, t - self.lag(values, t), values) for t in times)
        motion = Motion(nodes.time, at, between, nodes.begins, formula)
        begin = np.array([initial[i] for i in indices]).reshape(len(indices), len(states))
        guess = self._guessed(run, indices, nodes, length) if states else None
        try:
            made = simulate(
                self.equations, values, motion, guess, begin, with_initial=True, accuracy=accuracy, held=held
            )
        except InputError:
            if len(indices) > 1 or not in_pieces or (not length and "states" in run.guess.get(indices[0], {})):
                raise
            guess = self._piecewise(values, motion, begin[0], accuracy)
            made = simulate(self.equations, values, motion, guess, begin, with_initial=True, accuracy=accuracy)
        if not length:
            for i, (a, b) in zip(indices, nodes.pieces, strict=True):
                run.guess.setdefault(i, {})["states"] = dict(zip(states, made.states[a:b].T.copy(), strict=True))
        return made, nodes

    def simulated_apart(
        self, run: SampledRun, indices: Sequence[int], values: Mapping[str, float], initial: Initial, length: int = 0,
        held: int = 0, in_pieces: bool = True,
    ) -> Iterator[tuple[Sequence[int], Trajectory, Nodes]]:  # fmt: skip
        """Segments simulated together where possible, else those that diverge without the others, and in halves where
        all do; those that cannot be simulated alone are left out.

        Of many segments those that diverge are known from one simulation. They are simulated one by one until one of
        them diverges alone as well: that one and the rest are left out.
        """
        if not indices:
            return
        try:
            yield indices, *self.simulated(run, indices, values, initial, length, held=held, in_pieces=in_pieces)
        except DivergenceError as error:
            diverging = [indices[k] for k in error.pieces]
            others, middle = [i for i in indices if i not in diverging], len(indices) // 2
            apart = partial(
                self.simulated_apart, run, values=values, initial=initial, length=length, held=held, in_pieces=in_pieces
            )
            if len(indices) < MANY_PIECES:
                halves = (indices[:middle], indices[middle:]) if middle else ()
                yield from chain.from_iterable(map(apart, (others, diverging) if others and diverging else halves))
                return
            yield from apart(others)
            alone = (list(apart([i])) for i in diverging)
            yield from chain.from_iterable(takewhile(bool, alone))

    def _guessed(self, run: SampledRun, indices: Sequence[int], nodes: Nodes, length: int) -> np.ndarray:
        """The guess of the states (n, nx): those of the segments' last simulation, which is known for whole segments
        (`length` 0). Without one, the recorded states and their rates, and the start values of the others.
        """
        guess = np.repeat(self._start_values[:, None], len(nodes.time), axis=1)
        recorded = self._recorded_states(run)
        for i, (a, b) in zip(indices, nodes.pieces, strict=True):
            known = {} if length else run.guess.get(i, {}).get("states", {})
            for row, name in zip(guess, self.equations.states, strict=True):
                if name in known:  # of a model with other steps where the number of nodes differs
                    places = np.linspace(0, len(known[name]) - 1, b - a)
                    row[a:b] = np.interp(places, np.arange(len(known[name])), known[name])
                elif name in recorded:
                    row[a:b] = np.interp(nodes.time[a:b], run.recording.time, recorded[name])
        return guess.T

    def _recorded_states(self, run: SampledRun) -> dict[str, np.ndarray]:
        """The recorded outputs (n,) that are states, and their derivatives where a state is the rate of one and is not
        recorded itself."""
        found = {n: y for n, y in zip(run.experiment.outputs, run.measured.T, strict=True) if n in self._rates_of_states}
        rates = {r: np.gradient(y, run.recording.time) for n, y in found.items() for r in self._rates_of_states[n]}
        return rates | found

    def _piecewise(
        self, values: Mapping[str, float], motion: Motion, begin: np.ndarray, accuracy: float
    ) -> np.ndarray:
        """The states (n, nx) simulated piece by piece, for segments that do not converge as a whole."""
        n, first, length = len(motion.time), 0, PIECE
        states = np.empty((n, len(begin)))
        states[0] = begin
        while first < n - 1:
            last = min(first + length, n - 1)
            at, between = ({name: x if np.ndim(x) == 0 else x[first : last + more] for name, x in columns.items()}
                           for columns, more in ((motion.at, 1), (motion.between, 0)))  # fmt: skip
            piece = Motion(motion.time[first : last + 1], at, between, formula=motion.formula)
            try:
                states[first : last + 1] = simulate(
                    self.equations, values, piece, np.tile(states[first], (last - first + 1, 1)), states[first],
                    accuracy=accuracy,
                ).states  # fmt: skip
                first, length = last, min(2 * length, PIECE)
            except InputError:
                if length <= SMALLEST_PIECE:
                    raise
                length //= 2
        return states

    @np.errstate(all="ignore")  # slopes that are not finite make the simulation diverge, which raises an InputError
    def _formula(self, values: Mapping[str, float], step: float) -> ImplicitFormula:
        """The implicit formula for these values and a simulation step [s], by the component's slopes at rest."""
        states = self.equations.states
        rates = {states.index(n) for names in self._rates_of_states.values() for n in names}
        if not rates:
            return HERMITE_SIMPSON
        inputs = dict.fromkeys((*self.component.inputs, *map(rate_of, self.component.inputs)), 0.0)
        rest = {**inputs, **values, "time": 0.0, **dict(zip(states, self._start_values, strict=True))}
        return formula_for(self.equations(rest)[1], sorted(rates), step)

    def _inputs(self, run: Any, time: np.ndarray, values: Mapping[str, float]) -> dict[str, Any]:
        inputs = dict.fromkeys(self.component.inputs, 0.0) | run.inputs(time)
        component: Any = self.component
        for name, (_, delay) in component.delays.items():  # of what is imposed
            late = run.inputs(time - values[delay])
            inputs[name], inputs[rate_of(name)] = late[component.imposed], late[component.rate]
        return inputs

    def first_states(self, run: SampledRun, index: int) -> np.ndarray:
        """Initial states (nx,): measured states and their rates from the first samples, start values for the others."""
        found: dict[str, float] = {}
        first = run.segments[index][0]
        some = slice(first, min(first + BEGINNING, len(run.measured)))
        for name, y in zip(run.experiment.outputs, run.measured.T, strict=True):
            slope, value = np.polyfit(np.arange(len(y[some])) / run.recording.rate, y[some], 1)
            found[name] = float(value)
            found |= {r: float(slope) for r in self._rates_of_states.get(name, ()) if r not in run.experiment.outputs}
        return np.array([found.get(n, x) for n, x in zip(self.equations.states, self._start_values, strict=True)])

    @cached_property
    def _start_values(self) -> np.ndarray:
        """The declared start values (nx,) of the states."""
        return np.array([self.component.table[n].start for n in self.equations.states])

    @cached_property
    def _initial_deviations(self) -> np.ndarray:
        """The standard deviations (nx,) of the priors of the initial states, about zero; infinite without one."""
        known = {
            self.experiment.parameter(effect, n): deviation
            for effect in self.effects
            for n, deviation in effect.initial_deviations.items()
        }
        return np.array([known.get(n, np.inf) for n in self.equations.states])

    @cached_property
    def _rates_of_states(self) -> dict[str, list[str]]:
        """The states that are the rate of a state, by its name."""
        return rates_of_states(self.component)
