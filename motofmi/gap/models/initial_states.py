r"""Segments simulated from the initial states that fit best, and residuals without them.

    z(q) = min over x_0, o of |m(q, x_0) + o - y| / sigma

x_0 are the states at the start of each segment, known where it begins at rest; o is an offset of each sensor. The
output is nearly linear in them: a few Gauss-Newton steps find them, and their derivatives are projected out of the
residuals and of all other derivatives (variable projection). Without a guess they are estimated over a segment's first
samples, and then over more and more.

Source: Golub, Pereyra, Inverse Problems 19 (2003) R1-R26; Bock's multiple shooting for the segments.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from fmus.support.errors import InputError
from motofmi.gap.models.segmented import Initial, SegmentedModel
from motofmi.gap.models.simulation import Trajectory
from motofmi.gap.preprocessing.sampled_run import SampledRun

STEPS = 6  # Gauss-Newton steps
SHORTER = 0.25  # factor on a step that increased chi-square
SETTLED = 0.02  # gain of chi-square below which no further step is made
# The same as a share of chi-square. The step itself is in the result already, as it is eliminated linearly: what
# is left out is of second order.
SHARE = 3e-5
RANK = 1e-7  # relative singular value below which initial states are not identifiable
OFFSET_SAMPLES = 64  # samples of a segment from which sensor offsets are eliminated as well
DELAY_STEP = 1e-4  # s, step of the finite difference by a delay
# Ratio of the misfit's power to the last one (at first: the noise), or to that at rest, above which
# other starts are tried
RESTART_RATIO = 10.0
# Steps at each length, and the least length in samples, when initial states are estimated without a guess
EXTENSION_STEPS, LEAST_LENGTH = 3, 16


@dataclass(frozen=True)
class _SegmentStart:
    """A segment from initial states x (nx,): residuals (m,) over the noise, and the directions of the unknowns.

    step (nx,) is the Gauss-Newton step and gain its expected gain; chi2 excludes the offsets, rest is chi2 after the
    step. made and samples are the trajectory that contains the segment, and its nodes there.
    """

    x: np.ndarray
    left: np.ndarray
    taken: np.ndarray  # (m, unknowns), orthonormal
    states_of_taken: np.ndarray  # (nx, unknowns): the initial states whose change is each direction
    step: np.ndarray
    gain: float
    chi2: float
    rest: float
    made: Trajectory
    samples: slice


@dataclass(frozen=True)
class _SegmentSolution:
    """A segment from its best initial states x (nx,): output (m,) and derivatives (m, np) without unknowns, and
    mean square misfit. x_slopes (nx, np) are the derivatives of x."""

    x: np.ndarray
    output: np.ndarray
    slopes: np.ndarray
    misfit: float
    x_slopes: np.ndarray


class InitialStateModel(SegmentedModel):
    """Base and effects over segments, each from its best initial states."""

    def _valued(self, run: Any, q: np.ndarray) -> dict[str, float]:
        return self.values(q) | dict.fromkeys(self.durations, run.duration)

    def _complete(self, indices: Sequence[int], run: SampledRun, found: Mapping[int, Any]) -> None:
        """Raises InputError where not each of these segments was found."""
        missing = [i for i in indices if i not in found]
        if missing:
            begin, end = (run.recording.time[k] for k in (run.segments[missing[0]][0], run.segments[missing[0]][1] - 1))
            raise InputError(
                f"{self.component.name}: the simulation of {run.name} diverges from {begin:.4g} to {end:.4g} s"
            )

    def _last(self, run: SampledRun, index: int) -> np.ndarray:
        """The latest initial states (nx,) that were estimated with this model, otherwise with another one."""
        known = (run.guess.get((*self.own, index)) or run.guess[index])["initial"]
        return np.array([known.get(n, 0.0) for n in self.equations.states])

    def _predicted(self, run: SampledRun, index: int, q: np.ndarray) -> np.ndarray:
        """The initial states (nx,) for a vector q, linearly from the latest ones of this model."""
        known = run.guess.get((*self.own, index), {})
        move = (
            known["slopes"] @ (q - known["at"]) if known.get("at") is not None and len(known["at"]) == len(q) else 0.0
        )
        return self._last(run, index) + move

    def _at_known_initial(self, run: SampledRun, q: np.ndarray) -> list[_SegmentSolution]:
        """Every segment from the initial states of this model, or of the one with the most of its effects, without a
        search for better ones; none where the states of a segment are not known, or it cannot be simulated."""
        every, known = range(len(run.segments)), {}
        for i in every:
            contained = (run.guess.get((*self.own[:count], i)) for count in range(len(self.own), -1, -1))
            guess: dict[str, Any] = next(filter(None, contained), {})
            if "initial" not in guess:
                return []
            known[i] = np.array([guess["initial"].get(n, 0.0) for n in self.equations.states])
        found = self._segments(run, self._valued(run, q), known, steps=0)
        return [found[i] for i in every] if len(found) == len(every) else []

    def _solved(self, run: SampledRun, q: np.ndarray, trial: bool = False) -> list[_SegmentSolution]:
        """Every segment from the last initial states of this model or another one; where the misfit is large,
        from new estimates.

        In a trial of a fit there are no new estimates: where the misfit from the last initial states is large, the step
        of the fit is too long.
        Raises InputError where a segment cannot be simulated.
        """
        every, values = range(len(run.segments)), self._valued(run, q)
        if self.experiment.from_rest:
            found = self._segments(run, values, self._at_rest(run), steps=0)
            self._complete(every, run, found)
            return [found[i] for i in every]
        initial_guesses = [run.guess.get((*self.own, i)) or run.guess.get(i, {}) for i in every]
        at_rest = [float(np.mean(run.data[rows] ** 2)) for rows in run.reduction.rows]
        noise = [float(np.mean(run.deviation[rows] ** 2)) for rows in run.reduction.rows]
        usual = [
            RESTART_RATIO * min(guess.get("misfit", n), rest)
            for guess, n, rest in zip(initial_guesses, noise, at_rest, strict=True)
        ]
        known = {i: self._predicted(run, i, q) for i in every if "initial" in initial_guesses[i]}
        found = self._segments(run, values, known)
        if trial and len(known) == len(every):
            self._complete(every, run, found)
        else:
            self._restart(run, values, found, usual)
        for i in every:
            if found[i].misfit < (
                usual[i] if (*self.own, i) in run.guess else RESTART_RATIO * at_rest[i]
            ):  # otherwise the parameters are inaccurate, and the states are not a useful start
                best = {
                    "initial": dict(zip(self.equations.states, found[i].x.tolist(), strict=True)),
                    "misfit": found[i].misfit,
                }
                run.guess[(*self.own, i)] = best | {"at": np.array(q), "slopes": found[i].x_slopes}
                run.guess.setdefault(i, {}).update(best)
        return [found[i] for i in every]

    def _restart(
        self, run: SampledRun, values: Mapping[str, float], found: dict[int, _SegmentSolution], usual: Sequence[float]
    ) -> None:
        """Segments that are not found, or with a larger misfit than usual, from new estimates of their initial states.

        Raises InputError where one cannot be simulated.
        """
        restarted = [i for i in range(len(run.segments)) if i not in found or found[i].misfit > usual[i]]
        lost = [i for i in restarted if i not in found][:1]
        # One segment that cannot be simulated is enough for an error: the others are not restarted then.
        for some in (lost, [i for i in restarted if i not in lost]):
            for i, extended in self._segments(run, values, self._extended(run, some, values)).items():
                found[i] = extended if i not in found or extended.misfit < found[i].misfit else found[i]
            self._complete(some, run, found)

    def _at_rest(self, run: SampledRun) -> dict[int, np.ndarray]:
        """The initial states (nx,) of every segment where the component is at rest."""
        return dict.fromkeys(range(len(run.segments)), self._start_values)

    def _extended(self, run: SampledRun, indices: Sequence[int], values: Mapping[str, float]) -> dict[int, np.ndarray]:
        """Initial states estimated from a segment's first samples, then from one period, then from several."""
        x, length = (
            {i: self.first_states(run, i) for i in indices},
            max(int(run.recording.rate / run.middle_frequency), LEAST_LENGTH),
        )
        while self.equations.states and (longer := [i for i in x if length < run.segments[i][1] - run.segments[i][0]]):
            for _ in range(EXTENSION_STEPS):
                extended = {}
                for together, made, nodes in self.simulated_apart(run, longer, values, x, length):
                    for i, where in zip(together, nodes.samples, strict=True):
                        first = run.segments[i][0]
                        # there are slopes by initial states wherever there are states
                        tangent = made.initial_slopes[where].reshape(-1, len(x[i]))  # type: ignore[index]
                        misfit = run.measured[first : first + length] - made.outputs[where]
                        extended[i] = x[i] + np.linalg.lstsq(tangent, misfit.ravel(), rcond=RANK)[0]
                longer = list(extended)
                x = {i: known for i, known in x.items() if run.segments[i][1] - run.segments[i][0] <= length} | extended
            length *= 3
        return x

    def _segments(
        self, run: SampledRun, values: Mapping[str, float], initial: Initial, steps: int = STEPS
    ) -> dict[int, _SegmentSolution]:
        """Segments from the best initial states, by at most so many Gauss-Newton steps from guesses; those that cannot
        be simulated are left out."""
        best = self._from(run, values, initial)
        moves = {i: begun.step for i, begun in best.items()}
        for _ in range(steps):
            unconverged = [i for i, begun in best.items() if begun.gain >= SETTLED + SHARE * begun.rest]
            others = self._from(run, values, {i: best[i].x + moves[i] for i in unconverged})
            for i in unconverged:
                if i in others and others[i].chi2 < best[i].chi2:
                    best[i], moves[i] = others[i], others[i].step
                else:  # worse, or it cannot be simulated
                    moves[i] = SHORTER * moves[i]
        lags = {name: self._later(run, values, name, best) for name in self.lags}
        fitted_to_the_end = {}
        for i in (i for i in best if all(i in later for later in lags.values())):
            with suppress(InputError):  # derivatives that are not finite
                fitted_to_the_end[i] = self._finished(
                    run, values, i, best[i], {name: later[i] for name, later in lags.items()}
                )
        return fitted_to_the_end

    def _later(
        self, run: SampledRun, values: Mapping[str, float], lag: str, best: Mapping[int, _SegmentStart]
    ) -> dict[int, np.ndarray]:
        """The derivatives (m,) by a delay."""
        slopes, x = {}, {i: begun.x for i, begun in best.items()}
        for indices, made, nodes in self.simulated_apart(run, list(best), {**values, lag: values[lag] + DELAY_STEP}, x):
            for i, where in zip(indices, nodes.samples, strict=True):
                change = (made.outputs[where] - best[i].made.outputs[best[i].samples])[:, :, None] / DELAY_STEP
                slopes[i] = (
                    run.reduction.reduce(change, i, run.segments[i][0])[:, 0] / run.deviation[run.reduction.rows[i]]
                )
        return slopes

    def _finished(
        self,
        run: SampledRun,
        values: Mapping[str, float],
        index: int,
        begun: _SegmentStart,
        lags: Mapping[str, np.ndarray],
    ) -> _SegmentSolution:
        """A segment with all derivatives, the unknowns eliminated."""
        rows, first = run.reduction.rows[index], run.segments[index][0]
        deviation, full = run.deviation[rows], np.zeros((len(rows), len(self.names)))
        slopes = begun.made.slopes[begun.samples]
        full[:, [self.names.index(n) for n in self.equations.parameters]] = (
            run.reduction.reduce(slopes, index, first) / deviation[:, None]
        )
        for name, slope in lags.items():
            full[:, self.names.index(name)] = slope
        full[:, : len(self.base)] *= [values[n] for n in self.base]
        left = begun.left - begun.taken @ (begun.taken.T @ begun.left)
        misfit = float(np.mean((left * deviation) ** 2))
        by_unknowns = begun.taken.T @ full
        return _SegmentSolution(
            begun.x + begun.step,
            run.data[rows] / deviation + left,
            full - begun.taken @ by_unknowns,
            misfit,
            -begun.states_of_taken @ by_unknowns,
        )

    def _from(self, run: SampledRun, values: Mapping[str, float], initial: Initial) -> dict[int, _SegmentStart]:
        """Segments from initial states, each with the step to better ones; those that cannot be
        simulated are left out."""
        begun = {}
        for indices, made, nodes in self.simulated_apart(run, list(initial), values, initial):
            for i, where in zip(indices, nodes.samples, strict=True):
                begun[i] = self._begun(run, i, initial[i], made, where)
        return begun

    def _begun(self, run: SampledRun, index: int, x: np.ndarray, made: Trajectory, where: slice) -> _SegmentStart:
        """One segment of a trajectory: residuals, and the Gauss-Newton step of the initial states."""
        (first, last), rows = run.segments[index], run.reduction.rows[index]
        ny, deviation = run.measured.shape[1], run.deviation[rows]
        nx = 0 if self.experiment.from_rest else len(x)  # the initial states that are unknown
        offsets = np.eye(ny)[:, run.with_offset if last - first >= OFFSET_SAMPLES else []]
        stack = np.zeros((last - first, ny, 1 + nx + offsets.shape[1]))
        stack[:, :, 0] = made.outputs[where]
        if nx:
            stack[:, :, 1 : 1 + nx] = made.initial_slopes[where]  # type: ignore[index]  # asked for by states
        stack[:, :, 1 + nx :] = offsets
        z = run.reduction.reduce(stack, index, first) / deviation[:, None]
        left, tangent = z[:, 0] - run.data[rows] / deviation, z[:, 1:]
        u, size, vt = np.linalg.svd(tangent, full_matrices=False)
        kept = size > RANK * size.max(initial=1e-300)
        u, pull = u[:, kept], u[:, kept].T @ left
        states_of_taken = np.zeros((len(x), int(np.sum(kept))))
        states_of_taken[:nx] = (vt[kept].T / size[kept])[:nx]
        step = -states_of_taken @ pull
        gain = float(np.sum((tangent[:, :nx] @ step[:nx]) ** 2))
        of_offsets = np.linalg.qr(tangent[:, nx:])[0].T @ left
        return _SegmentStart(
            x,
            left,
            u,
            states_of_taken,
            step,
            gain,
            float(left @ left - of_offsets @ of_offsets),
            float(left @ left - pull @ pull),
            made,
            where,
        )
