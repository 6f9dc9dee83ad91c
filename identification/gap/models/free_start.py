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
from identification.gap.models.equations import rate_of
from identification.gap.models.model import Model
from identification.gap.models.simulate import Motion, Trajectory, simulate

STEPS = 6
SHORTER = 0.25  # of a step that led to worse initial states
SETTLED = 0.02  # of chi-square that a further step of the initial states would gain
SHARE = 1e-5  # of what is left, at which they are known well enough
RANK = 1e-7
OFFSET = 64  # samples of a segment, from which a sensor's offset is taken out as well
MICRO = 1e-4  # s: the step by which a lag is varied for its slope
LOST = 10.0  # times what was missed last (first: the noise), or would be at rest, in power: where more is, other initial states are tried
GROWING, SHORTEST = 3, 16  # steps of growing initial states, samples over which they begin
PIECE, SMALLEST_PIECE = 128, 1  # steps of a piece, where a trajectory is found piece by piece


@dataclass(frozen=True)
class _Begun:
    """A segment from initial states x (nx,): what is left (m,) in units of the noise, its slopes (m, np), and what the unknowns take out of both.

    step (nx,) leads to better initial states and would gain so much of chi2, which has the offsets taken out; rest is what would be left.
    """

    x: np.ndarray
    outputs: np.ndarray
    left: np.ndarray
    slopes: np.ndarray
    taken: np.ndarray  # (m, unknowns), orthonormal
    step: np.ndarray
    gain: float
    chi2: float
    rest: float


class FreeStart(Model):
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
        values = self.values(q) | dict.fromkeys(self.durations, run.duration)
        parts = [self._solved(run, index, values) for index in range(len(run.segments))]
        return np.concatenate([z for z, _ in parts]), np.concatenate([s for _, s in parts])

    def from_rest(self, run: Sampled, q: np.ndarray) -> np.ndarray:
        """What is answered (n, outputs) to the run's inputs by segments that begin at rest."""
        values = self.values(q) | dict.fromkeys(self.durations, run.duration)
        return np.concatenate([self._simulated(run, index, values, {}).outputs for index in range(len(run.segments))])

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
        values = self.values(q) | dict.fromkeys(self.durations, run.duration)
        residuals, signals = [], []
        for index, (first, last) in enumerate(run.segments):
            if (*self.own, index) not in run.guess:
                raise InputError(f"{self.component.name}: no initial states were found from which {run.name} is simulated")
            initial = run.guess[(*self.own, index)]["initial"]
            left = run.measured[first:last] - self._simulated(run, index, values, initial).outputs
            residuals.append(left - left.mean(axis=0))
            made, time = self._simulated(run.noiseless, index, values, initial), run.recording.time[first:last]
            known = {**values, "time": time, **self._inputs(run.noiseless, time, values)}
            known |= dict(zip(self.equations.states, made.states[:: run.finer].T, strict=True))
            signals.append((self._elements(known), [np.broadcast_to(known[n], len(time)) for n in self.component.inputs] + list(made.outputs.T)))
        deflections, rates = [[np.concatenate([np.broadcast_to(x, len(s[1][0])) for x, s in zip(each, signals, strict=True)]) for each in
                              zip(*(s[0][side] for s in signals), strict=True)] for side in (0, 1)]  # fmt: skip
        linear = [np.concatenate(each) for each in zip(*(s[1] for s in signals), strict=True)]
        return np.concatenate(residuals), deflections, rates, linear

    def _elements(self, known: Mapping[str, Any]) -> tuple[list, list]:
        """Deflections and rates of the component's elements, once each."""
        component = self.component.inner if isinstance(self.component, Imposed | ThroughSpring) else self.component
        scope = component.run({**dict.fromkeys(component.inputs, 0.0), **known}, NUMERIC)
        seen = {(e.deflection, e.rate): None for e in component.elements.values()}
        both = [({**known, **scope}[d], {**known, **scope}[r]) for d, r in seen if d and r]
        return [d for d, _ in both], [r for _, r in both]

    def _solved(self, run: Sampled, index: int, values: Mapping[str, float]) -> tuple[np.ndarray, np.ndarray]:
        """One segment from the initial states that this model had last, or another; where they lead astray, from grown ones."""
        own, found, rows = run.guess.get((*self.own, index)), None, self._rows(run, index)
        last = own or run.guess.get(index, {})
        known = last.get("initial")
        noise, at_rest = (float(np.mean(x[rows] ** 2)) for x in (run.deviation, run.data))
        usual = LOST * min(last.get("missed", noise), at_rest)
        if known is not None:
            with suppress(InputError):
                found = self._segment(run, index, values, known)
        if found is None or found[2] > usual:
            try:
                grown = self._segment(run, index, values, self._grown(run, index, values))
                found = grown if found is None or grown[2] < found[2] else found
            except InputError:
                if found is None:
                    raise
        z, slopes, missed, initial = found
        if missed < (usual if own else LOST * at_rest):  # else it is a step too far, and no place to begin from
            run.guess[(*self.own, index)] = {"initial": initial, "missed": missed}
            run.guess.setdefault(index, {}).update(run.guess[(*self.own, index)])
        return z, slopes

    def _grown(self, run: Sampled, index: int, values: Mapping[str, float]) -> dict[str, float]:
        """Initial states that fit ever more of a segment's beginning: from what is seen there, over one period, then over several."""
        first, last = run.segments[index]
        initial, length = self._first_states(run, first), max(int(run.recording.rate / run.middle_frequency), SHORTEST)
        while length < last - first and self.equations.states:
            for _ in range(GROWING):
                made = self._simulated(run, index, values, initial, length)
                tangent = made.initial_slopes.reshape(-1, len(self.equations.states))  # type: ignore[union-attr]  # asked for by states
                step = np.linalg.lstsq(tangent, (run.measured[first : first + length] - made.outputs).ravel(), rcond=RANK)[0]
                initial = {n: initial.get(n, 0.0) + float(s) for n, s in zip(self.equations.states, step, strict=True)}
            length *= 3
        return initial

    def _segment(self, run: Sampled, index: int, values: Mapping[str, float],
                 initial: Mapping[str, float]) -> tuple[np.ndarray, np.ndarray, float, dict[str, float]]:  # fmt: skip
        """Reduced output and slopes of one segment, the mean square that is missed, and the initial states found from a guess."""
        rows, names = self._rows(run, index), self.equations.states
        best = self._from(run, index, values, np.array([initial.get(n, 0.0) for n in names]))
        step = best.step
        for _ in range(STEPS):
            if best.gain < SETTLED + SHARE * best.rest:
                break
            try:
                other = self._from(run, index, values, best.x + step)
            except InputError:  # it leads astray
                other = None
            if other is None or not other.chi2 < best.chi2:
                step = SHORTER * step
            else:
                best, step = other, other.step
        full = np.zeros((len(rows), len(self.names)))
        full[:, [self.names.index(n) for n in self.equations.parameters]] = best.slopes
        found = dict(zip(names, best.x.tolist(), strict=True))
        for name in self.lags:
            later = self._simulated(run, index, {**values, name: values[name] + MICRO}, found)
            change = (later.outputs - best.outputs)[:, :, None] / MICRO
            full[:, self.names.index(name)] = run.reduction.reduce(change, index, run.segments[index][0])[:, 0] / run.deviation[rows]
        full[:, : len(self.base)] *= [values[n] for n in self.base]
        left = best.left - best.taken @ (best.taken.T @ best.left)
        missed = float(np.mean((left * run.deviation[rows]) ** 2))
        return run.data[rows] / run.deviation[rows] + left, full - best.taken @ (best.taken.T @ full), missed, found

    def _from(self, run: Sampled, index: int, values: Mapping[str, float], x: np.ndarray) -> "_Begun":
        """One segment from initial states (nx,), with the step to better ones."""
        first, last = run.segments[index]
        rows = self._rows(run, index)
        made = self._simulated(run, index, values, dict(zip(self.equations.states, x, strict=True)))
        count = run.measured.shape[1] if last - first >= OFFSET else 0
        offset = np.broadcast_to(np.eye(run.measured.shape[1])[:, :count], (last - first, run.measured.shape[1], count))
        stack = np.concatenate([made.outputs[:, :, None], made.initial_slopes, offset, made.slopes], axis=2)
        z = run.reduction.reduce(stack, index, first) / run.deviation[rows, None]
        left, tangent, slopes = z[:, 0] - run.data[rows] / run.deviation[rows], z[:, 1 : 1 + len(x) + count], z[:, 1 + len(x) + count :]
        u, size, vt = np.linalg.svd(tangent, full_matrices=False)
        kept = size > RANK * size.max(initial=1e-300)
        u, pull = u[:, kept], u[:, kept].T @ left
        step = -(vt[kept].T @ (pull / size[kept]))[: len(x)]
        gain = float(np.sum((tangent[:, : len(x)] @ step) ** 2))
        offsets = np.linalg.qr(tangent[:, len(x) :])[0].T @ left
        return _Begun(x, made.outputs, left, slopes, u, step, gain, float(left @ left - offsets @ offsets), float(left @ left - pull @ pull))

    def _simulated(self, run: Sampled, index: int, values: Mapping[str, float], initial: Mapping[str, float], length: int = 0) -> Trajectory:
        """One segment, or so many of its samples, from initial states by name; outputs and slopes at the samples, states at every step."""
        first, last = run.segments[index]
        last = first + length if length else last
        time = run.recording.time[first] + np.arange((last - 1 - first) * run.finer + 1) / (run.recording.rate * run.finer)
        middle = (time[1:] + time[:-1]) / 2
        motion = Motion(time, *(self._inputs(run, t - self.lag(values, t), values) for t in (time, middle)))
        names = self.equations.states
        states = None if length else run.guess.get(index, {}).get("states")
        guess = None
        if states is not None:
            guess = np.column_stack([states.get(n, np.zeros(len(time))) for n in names]) if names else None
        begin = np.array([initial.get(n, 0.0) for n in names])
        try:
            made = simulate(self.equations, values, motion, guess, begin, with_initial=bool(names))
        except InputError:
            made = simulate(self.equations, values, motion, self._piecewise(values, motion, begin), begin, with_initial=bool(names))
        if not length:
            run.guess.setdefault(index, {})["states"] = dict(zip(names, made.states.T, strict=True))
        made.outputs, made.slopes = made.outputs[:: run.finer], made.slopes[:: run.finer]
        made.initial_slopes = np.zeros((*made.outputs.shape, 0)) if made.initial_slopes is None else made.initial_slopes[:: run.finer]
        return made

    def _piecewise(self, values: Mapping[str, float], motion: Motion, begin: np.ndarray) -> np.ndarray:
        """The states (n, nx) piece after piece, each from the end of the last: where the whole at once does not converge."""
        n, first, length = len(motion.time), 0, PIECE
        states = np.empty((n, len(begin)))
        states[0] = begin
        while first < n - 1:
            last = min(first + length, n - 1)
            piece = Motion(motion.time[first : last + 1], *({name: x if np.ndim(x) == 0 else x[first : last + more] for name, x in told.items()}
                           for told, more in ((motion.at, 1), (motion.between, 0))))  # fmt: skip
            try:
                states[first : last + 1] = simulate(self.equations, values, piece, np.tile(states[first], (last - first + 1, 1)), states[first]).states
                first, length = last, min(2 * length, PIECE)
            except InputError:
                if length <= SMALLEST_PIECE:
                    raise
                length //= 2
        return states

    def _inputs(self, run: Any, time: np.ndarray, values: Mapping[str, float]) -> dict[str, Any]:
        told = dict.fromkeys(self.component.inputs, 0.0) | run.told(time)
        component: Any = self.component
        for name, (_, delay) in component.delays.items():  # of what is imposed
            late = run.told(time - values[delay])
            told[name], told[rate_of(name)] = late[component.imposed], late[component.rate]
        return told

    def _first_states(self, run: Sampled, first: int) -> dict[str, float]:
        """Where the states that are measured begin, and the slopes of those."""
        found: dict[str, float] = {}
        step = 1 / run.recording.rate
        some = slice(first, min(first + 12, len(run.measured)))
        for name, y in zip(run.test.outputs, run.measured.T, strict=True):
            slope, value = np.polyfit(np.arange(len(y[some])) * step, y[some], 1)
            found[name] = float(value)
            found |= {r: float(slope) for r in self._rate_of(name) if r not in run.test.outputs}
        return found

    def _rate_of(self, name: str) -> list[str]:
        """The state that is the rate of a state, if there is one."""
        if name not in self.component.states:
            return []
        start = self.component.start_values()
        probe = {n: start | {n: start[n] + 1.0} for n in self.component.states}
        rate = f"der({name})"
        rest = self.component.run(start, NUMERIC)[rate]
        return [n for n in self.component.states if abs(self.component.run(probe[n], NUMERIC)[rate] - rest - 1.0) < 1e-12]

    @staticmethod
    def _rows(run: Sampled, index: int) -> np.ndarray:
        """The places of a segment's cosines among the run's."""
        reduction = run.reduction
        sizes = [kept * reduction.outputs for _, _, kept in reduction.spans]
        edges = np.concatenate([[0], np.cumsum(sizes)])
        return np.concatenate([np.arange(edges[i], edges[i + 1]) for i, owner in enumerate(reduction.segment_of) if owner == index])
