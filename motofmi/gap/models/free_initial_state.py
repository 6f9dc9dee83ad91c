"""Base and effects simulated from initial states that nobody recorded, and that are taken out of what is compared.

    z(q) = min over x_0, o of |m(q, x_0) + o - y| / sigma

x_0 are the states at the start of each segment, o an offset of each sensor. They enter nearly linearly: a few
Gauss-Newton steps find them, and their tangent is projected out of the residuals and of every slope (variable projection).

Source: Golub, Pereyra, Inverse Problems 19 (2003) R1-R26; Bock's multiple shooting for the segments.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fmus.effects import Effect
from fmus.errors import InputError
from fmus.imposed import Imposed, ThroughSpring
from fmus.mathematics import NUMERIC
from identification.gap.data.flexible import features_of, noise_density
from identification.gap.data.sampled import Sampled
from identification.gap.models.segmented import Initial, Segmented
from identification.gap.models.simulate import Trajectory

STEPS = 6
SHORTER = 0.25  # of a step that led to worse initial states
SETTLED = 0.02  # of chi-square that a further step of the initial states would gain
SHARE = 1e-5  # of what is left, at which they are known well enough
RANK = 1e-7
OFFSET = 64  # samples of a segment, from which a sensor's offset is taken out as well
MICRO = 1e-4  # s: the step by which a lag is varied for its slope
LOST = 10.0  # times what was missed last (first: the noise), or would be at rest, in power: where more is, other initial states are tried
GROWING, SHORTEST = 3, 16  # steps of growing initial states, samples over which they begin


@dataclass(frozen=True)
class _Begun:
    """A segment from initial states x (nx,): what is left (m,) in units of the noise, and what the unknowns take out of it.

    step (nx,) leads to better initial states and would gain so much of chi2, which has the offsets taken out; rest is what would
    be left. made and samples are the trajectory that it is a part of, and its nodes there.
    """

    x: np.ndarray
    left: np.ndarray
    taken: np.ndarray  # (m, unknowns), orthonormal
    step: np.ndarray
    gain: float
    chi2: float
    rest: float
    made: Trajectory
    samples: slice


@dataclass(frozen=True)
class _Solved:
    """A segment from the best initial states x (nx,): its output (m,) and slopes (m, np) without the unknowns, the mean square that it misses."""

    x: np.ndarray
    output: np.ndarray
    slopes: np.ndarray
    missed: float


class FreeStart(Segmented):
    """Base and effects on sampled runs."""

    stand: Any
    predicted = None  # type: ignore[assignment]  # slopes come with the output

    def joined_by(self, *effects: type[Effect], slopes_of_base: bool = True) -> "FreeStart":
        """The model with further effects."""
        return FreeStart(self.stand, [*self.effects, *effects], slopes_of_base)

    def largest(self, runs: Sequence[Any]) -> float:
        """The largest deflection of the component's spring in the runs."""
        return self.stand.largest

    def reduced(self, run: Any, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Reduced output (m,) and its slopes (m, np) in units of the noise, the unknowns of the run taken out."""
        parts = self._solved(run, self._valued(run, q))
        return np.concatenate([part.output for part in parts]), np.concatenate([part.slopes for part in parts])

    def from_rest(self, run: Sampled, q: np.ndarray) -> np.ndarray:
        """What is answered (n, outputs) to the run's inputs by segments that begin at rest. Raises InputError where one cannot be simulated."""
        rest = {i: np.zeros(len(self.equations.states)) for i in range(len(run.segments))}
        return np.concatenate([outputs for outputs, _ in self._traces(run, self._valued(run, q), rest)])

    def unknowns(self, run: Any) -> int:
        """The initial states of every segment, and the offsets of the sensors in it."""
        offsets = sum(last - first >= OFFSET for first, last in run.segments)
        return len(run.segments) * len(self.equations.states) + offsets * run.measured.shape[1]

    def with_noise_beside(self, run: Any, q: np.ndarray) -> Any:
        """The run with the noise that a flexible model leaves of this one's residuals; never more than beside another model."""
        if run.noise_source != "flexible_model":
            return run
        residuals, deflections, rates, linear = self.traced(run, q)
        features = features_of(deflections, rates, linear)
        found = [noise_density(r, features, run.recording.rate) for r in residuals.T]
        if run.noise_rests_on_a_model:
            found = [new.or_less(old) for new, old in zip(found, run.densities, strict=True)]
        return replace(run.with_densities(found, run.noise_source), noise_rests_on_a_model=True)

    def traced(self, run: Sampled, q: np.ndarray) -> tuple[np.ndarray, list[np.ndarray], list[np.ndarray], list[np.ndarray]]:
        """Residuals (n, outputs), deflections and rates of the elements, and what is told and modelled, over the segments (n,).

        The noise of an imposed motion is in the residuals alone. Raises InputError where the run cannot be simulated.
        """
        self.reduced(run, q)  # finds the initial states
        values, initial = self._valued(run, q), {}
        for index in range(len(run.segments)):
            if (*self.own, index) not in run.guess:
                raise InputError(f"{self.component.name}: no initial states were found from which {run.name} is simulated")
            initial[index] = self._last(run, index)
        residuals, signals = [], []
        for (first, last), (outputs, _), (made, states) in zip(
            run.segments, self._traces(run, values, initial), self._traces(run.noiseless, values, initial), strict=True
        ):
            left = run.measured[first:last] - outputs
            residuals.append(left - left.mean(axis=0))
            time = run.recording.time[first:last]
            known = {**values, "time": time, **self._inputs(run.noiseless, time, values), **dict(zip(self.equations.states, states.T, strict=True))}
            signals.append((self._elements(known), [np.broadcast_to(known[n], len(time)) for n in self.component.inputs] + list(made.T)))
        deflections, rates = [[np.concatenate([np.broadcast_to(x, len(s[1][0])) for x, s in zip(each, signals, strict=True)]) for each in
                              zip(*(s[0][side] for s in signals), strict=True)] for side in (0, 1)]  # fmt: skip
        linear = [np.concatenate(each) for each in zip(*(s[1] for s in signals), strict=True)]
        return np.concatenate(residuals), deflections, rates, linear

    def _valued(self, run: Any, q: np.ndarray) -> dict[str, float]:
        return self.values(q) | dict.fromkeys(self.durations, run.duration)

    def _traces(self, run: Sampled, values: Mapping[str, float], initial: Initial) -> list[tuple[np.ndarray, np.ndarray]]:
        """Outputs (n, ny) and states (n, nx) at the samples of every segment. Raises InputError where one cannot be simulated."""
        traces: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        for indices, made, nodes in self.simulated_apart(run, range(len(run.segments)), values, initial):
            traces |= {i: (made.outputs[where], made.states[where]) for i, where in zip(indices, nodes.samples, strict=True)}
        self._complete(run, traces)
        return [traces[i] for i in range(len(run.segments))]

    def _complete(self, run: Sampled, found: Mapping[int, Any]) -> None:
        """Raises InputError where not every segment was found."""
        missing = [i for i in range(len(run.segments)) if i not in found]
        if missing:
            begin, end = (run.recording.time[k] for k in (run.segments[missing[0]][0], run.segments[missing[0]][1] - 1))
            raise InputError(f"{self.component.name}: the simulation of {run.name} diverges from {begin:.4g} to {end:.4g} s")

    def _elements(self, known: Mapping[str, Any]) -> tuple[list, list]:
        """Deflections and rates of the component's elements, once each."""
        component = self.component.inner if isinstance(self.component, Imposed | ThroughSpring) else self.component
        scope = component.run({**dict.fromkeys(component.inputs, 0.0), **known}, NUMERIC)
        seen = {(e.deflection, e.rate): None for e in component.elements.values()}
        both = [({**known, **scope}[d], {**known, **scope}[r]) for d, r in seen if d and r]
        return [d for d, _ in both], [r for _, r in both]

    def _last(self, run: Sampled, index: int) -> np.ndarray:
        """The initial states (nx,) that this model had last, or another."""
        known = (run.guess.get((*self.own, index)) or run.guess[index])["initial"]
        return np.array([known.get(n, 0.0) for n in self.equations.states])

    def _solved(self, run: Sampled, values: Mapping[str, float]) -> list[_Solved]:
        """Every segment from the initial states that this model had last, or another; where they lead astray, from grown ones."""
        every = range(len(run.segments))
        memories = [run.guess.get((*self.own, i)) or run.guess.get(i, {}) for i in every]
        at_rest = [float(np.mean(run.data[rows] ** 2)) for rows in run.reduction.rows]
        noise = [float(np.mean(run.deviation[rows] ** 2)) for rows in run.reduction.rows]
        usual = [LOST * min(memory.get("missed", n), rest) for memory, n, rest in zip(memories, noise, at_rest, strict=True)]
        found = self._segments(run, values, {i: self._last(run, i) for i in every if "initial" in memories[i]})
        lost = [i for i in every if i not in found or found[i].missed > usual[i]]
        for i, grown in self._segments(run, values, self._grown(run, lost, values)).items():
            found[i] = grown if i not in found or grown.missed < found[i].missed else found[i]
        self._complete(run, found)
        for i in every:
            if found[i].missed < (usual[i] if (*self.own, i) in run.guess else LOST * at_rest[i]):  # else it is a step too far, and no place to begin from
                run.guess[(*self.own, i)] = {"initial": dict(zip(self.equations.states, found[i].x.tolist(), strict=True)), "missed": found[i].missed}
                run.guess.setdefault(i, {}).update(run.guess[(*self.own, i)])
        return [found[i] for i in every]

    def _grown(self, run: Sampled, indices: Sequence[int], values: Mapping[str, float]) -> dict[int, np.ndarray]:
        """Initial states that fit ever more of a segment's beginning: from what is seen there, over one period, then over several."""
        x, length = {i: self.first_states(run, i) for i in indices}, max(int(run.recording.rate / run.middle_frequency), SHORTEST)
        while self.equations.states and (longer := [i for i in x if length < run.segments[i][1] - run.segments[i][0]]):
            for _ in range(GROWING):
                grown = {}
                for together, made, nodes in self.simulated_apart(run, longer, values, x, length):
                    for i, where in zip(together, nodes.samples, strict=True):
                        first = run.segments[i][0]
                        tangent = made.initial_slopes[where].reshape(-1, len(x[i]))  # type: ignore[index]  # asked for by states
                        missed = run.measured[first : first + length] - made.outputs[where]
                        grown[i] = x[i] + np.linalg.lstsq(tangent, missed.ravel(), rcond=RANK)[0]
                longer = list(grown)
                x = {i: known for i, known in x.items() if run.segments[i][1] - run.segments[i][0] <= length} | grown
            length *= 3
        return x

    def _segments(self, run: Sampled, values: Mapping[str, float], initial: Initial) -> dict[int, _Solved]:
        """Segments from the best initial states that are found from guesses; those that cannot be simulated are left out."""
        best = self._from(run, values, initial)
        steps = {i: begun.step for i, begun in best.items()}
        for _ in range(STEPS):
            open_ones = [i for i, begun in best.items() if begun.gain >= SETTLED + SHARE * begun.rest]
            others = self._from(run, values, {i: best[i].x + steps[i] for i in open_ones})
            for i in open_ones:
                if i in others and others[i].chi2 < best[i].chi2:
                    best[i], steps[i] = others[i], others[i].step
                else:  # it leads astray
                    steps[i] = SHORTER * steps[i]
        lags = {name: self._later(run, values, name, best) for name in self.lags}
        finished = {}
        for i in (i for i in best if all(i in later for later in lags.values())):
            with suppress(InputError):  # of slopes that leave finite numbers
                finished[i] = self._finished(run, values, i, best[i], {name: later[i] for name, later in lags.items()})
        return finished

    def _later(self, run: Sampled, values: Mapping[str, float], lag: str, best: Mapping[int, _Begun]) -> dict[int, np.ndarray]:
        """The slopes (m,) by a lag."""
        slopes, x = {}, {i: begun.x for i, begun in best.items()}
        for indices, made, nodes in self.simulated_apart(run, list(best), {**values, lag: values[lag] + MICRO}, x):
            for i, where in zip(indices, nodes.samples, strict=True):
                change = (made.outputs[where] - best[i].made.outputs[best[i].samples])[:, :, None] / MICRO
                slopes[i] = run.reduction.reduce(change, i, run.segments[i][0])[:, 0] / run.deviation[run.reduction.rows[i]]
        return slopes

    def _finished(self, run: Sampled, values: Mapping[str, float], index: int, begun: _Begun, lags: Mapping[str, np.ndarray]) -> _Solved:
        """A segment with all slopes, the unknowns taken out."""
        rows, first = run.reduction.rows[index], run.segments[index][0]
        deviation, full = run.deviation[rows], np.zeros((len(rows), len(self.names)))
        slopes = begun.made.slopes[begun.samples]
        full[:, [self.names.index(n) for n in self.equations.parameters]] = run.reduction.reduce(slopes, index, first) / deviation[:, None]
        for name, slope in lags.items():
            full[:, self.names.index(name)] = slope
        full[:, : len(self.base)] *= [values[n] for n in self.base]
        left = begun.left - begun.taken @ (begun.taken.T @ begun.left)
        missed = float(np.mean((left * deviation) ** 2))
        return _Solved(begun.x, run.data[rows] / deviation + left, full - begun.taken @ (begun.taken.T @ full), missed)

    def _from(self, run: Sampled, values: Mapping[str, float], initial: Initial) -> dict[int, _Begun]:
        """Segments from initial states, each with the step to better ones; those that cannot be simulated are left out."""
        begun = {}
        for indices, made, nodes in self.simulated_apart(run, list(initial), values, initial):
            for i, where in zip(indices, nodes.samples, strict=True):
                begun[i] = self._begun(run, i, initial[i], made, where)
        return begun

    def _begun(self, run: Sampled, index: int, x: np.ndarray, made: Trajectory, where: slice) -> _Begun:
        """One segment of a trajectory: what is left, and the step that the initial states want."""
        (first, last), rows = run.segments[index], run.reduction.rows[index]
        ny, nx, deviation = run.measured.shape[1], len(x), run.deviation[rows]
        count = ny if last - first >= OFFSET else 0
        stack = np.zeros((last - first, ny, 1 + nx + count))
        stack[:, :, 0] = made.outputs[where]
        if nx:
            stack[:, :, 1 : 1 + nx] = made.initial_slopes[where]  # type: ignore[index]  # asked for by states
        stack[:, :, 1 + nx :] = np.eye(ny)[:, :count]
        z = run.reduction.reduce(stack, index, first) / deviation[:, None]
        left, tangent = z[:, 0] - run.data[rows] / deviation, z[:, 1:]
        u, size, vt = np.linalg.svd(tangent, full_matrices=False)
        kept = size > RANK * size.max(initial=1e-300)
        u, pull = u[:, kept], u[:, kept].T @ left
        step = -(vt[kept].T @ (pull / size[kept]))[:nx]
        gain = float(np.sum((tangent[:, :nx] @ step) ** 2))
        offsets = np.linalg.qr(tangent[:, nx:])[0].T @ left
        return _Begun(x, left, u, step, gain, float(left @ left - offsets @ offsets), float(left @ left - pull @ pull), made, where)
