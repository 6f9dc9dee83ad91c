r"""Segments simulated from the initial states that fit best, and residuals without them.

    z(q) = min over x_0, o of |m(q, x_0) + o - y| / sigma

x_0 are the states at the start of each segment, known where it begins at rest; o is an offset of each sensor. The
output is nearly linear in them: a few Gauss-Newton steps find them, and they are eliminated (see `segment_unknowns`).
Without a guess they are estimated over a segment's first samples, and then over more and more.

Source: Bock, Plitt, Proc. 9th IFAC World Congress (1984), on multiple shooting.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from fmus.support.errors import InputError
from motofmi.gap.models.segment_unknowns import (
    RANK,
    SegmentSolution,
    SegmentStart,
    groups,
    segment_solutions,
    segment_starts,
)
from motofmi.gap.models.segmented import Initial, SegmentedModel
from motofmi.gap.preprocessing.sampled_run import SampledRun

STEPS = 6  # Gauss-Newton steps
SHORTER = 0.25  # factor on a step that increased chi-square
SETTLED = 0.02  # gain of chi-square below which no further step is made
# The same as a share of chi-square. The step itself is in the result already, as it is eliminated linearly: what
# is left out is of second order.
SHARE = 3e-5
DELAY_STEP = 0.01  # sampling intervals: step of the finite difference by a delay
# Ratio of the misfit's power to the last one (at first: the noise), or to that at rest, above which
# other starts are tried
RESTART_RATIO = 10.0
# Steps at each length, and the least length in samples, when initial states are estimated without a guess
EXTENSION_STEPS, LEAST_LENGTH = 3, 16
# Parts of a segment of an unstable motion, over the first of which its initial states are estimated first: a motion
# that grows by a factor of 20 over the segment (`estimation.initial_fit.GROWTH`) grows by 1.5 over an eighth of it.
UNSTABLE_PARTS = 8


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

    def _known(self, run: SampledRun, index: int) -> dict[str, Any]:
        """What is known of a segment's initial states with this model, otherwise with another one."""
        return run.guess.get((*self.own, index)) or run.guess.get(index, {})

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

    def _at_known_initial(self, run: SampledRun, q: np.ndarray, held: int = 0) -> list[SegmentSolution]:
        """Every segment from the known initial states, without a search for better ones; none where those of a segment
        are not known, or it cannot be simulated. The first `held` states are those of the last simulation."""
        every, known = range(len(run.segments)), self._known_initial(run)
        found = self._segments(run, self._valued(run, q), known, steps=0, held=held)
        return [found[i] for i in every] if len(found) == len(every) else []

    def _known_initial(self, run: SampledRun) -> dict[int, np.ndarray]:
        """The initial states (nx,) of the segments in this model, or in the one with the most of its effects; empty
        where those of a segment are not known."""
        known = {}
        for i in range(len(run.segments)):
            contained = (run.guess.get((*self.own[:count], i)) for count in range(len(self.own), -1, -1))
            guess: dict[str, Any] = next(filter(None, contained), {})
            if "initial" not in guess:
                return {}
            known[i] = np.array([guess["initial"].get(n, 0.0) for n in self.equations.states])
        return known

    def simulated_once(self, run: SampledRun, q: np.ndarray) -> dict[int, SegmentStart]:
        """Every segment simulated once, from initial states that are predicted linearly from the last ones; empty where
        these are not known, or where segments begin at rest.

        Raises InputError where a segment cannot be simulated.
        """
        every = range(len(run.segments))
        if run.experiment.from_rest or not all("initial" in self._known(run, i) for i in every):
            return {}
        found = self._from(run, self._valued(run, q), {i: self._predicted(run, i, q) for i in every})
        self._complete(every, run, found)
        return found

    def _solved(
        self, run: SampledRun, q: np.ndarray, begun: Mapping[int, SegmentStart] | None = None
    ) -> list[SegmentSolution]:
        """Every segment from the last initial states of this model or another one; where the misfit is large,
        from new estimates.

        In a trial of a fit (`begun`) there are no new estimates: where the misfit from the last initial states is
        large, the step of the fit is too long. Raises InputError where a segment cannot be simulated.
        """
        every, values = range(len(run.segments)), self._valued(run, q)
        if run.experiment.from_rest:
            found = self._segments(run, values, self._at_rest(run), steps=0)
            self._complete(every, run, found)
            return [found[i] for i in every]
        initial_guesses = [self._known(run, i) for i in every]
        at_rest, noise = run.powers_of_segments
        usual = [
            RESTART_RATIO * min(guess.get("misfit", n), rest)
            for guess, n, rest in zip(initial_guesses, noise, at_rest, strict=True)
        ]
        if begun:
            found = self._refined(run, values, dict(begun))
            self._complete(every, run, found)
        else:
            known = {i: self._predicted(run, i, q) for i in every if "initial" in initial_guesses[i]}
            found = self._segments(run, values, known)
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
        self, run: SampledRun, values: Mapping[str, float], found: dict[int, SegmentSolution], usual: Sequence[float]
    ) -> None:
        """Segments that are not found, or with a larger misfit than usual, from new estimates of their initial states.

        Raises InputError where one cannot be simulated.
        """
        lost = [i for i in range(len(run.segments)) if i not in found]
        inaccurate = [i for i, solution in found.items() if solution.misfit > usual[i]]
        # One segment that cannot be simulated is enough for an error: the others are not restarted then. Those that are
        # found already do not need a simulation piece by piece, which may take a hundred times as long.
        for some in (lost[:1], lost[1:], inaccurate):
            estimated = self._extended(run, some, values, in_pieces=some is not inaccurate)
            for i, extended in self._segments(run, values, estimated).items():
                found[i] = extended if i not in found or extended.misfit < found[i].misfit else found[i]
            self._complete(some, run, found)
        self._continue(run, values, found)

    def _continue(self, run: SampledRun, values: Mapping[str, float], found: dict[int, SegmentSolution]) -> None:
        """Simulate segments with a far larger misfit than the others from the final states of the segment before.

        The motion is continuous: initial states that the samples do not show, as the position of a mass with an
        accelerometer, need not stay in a local minimum.
        """
        noise = run.powers_of_segments[1]
        limit = RESTART_RATIO * np.median([solution.misfit / noise[i] for i, solution in found.items()])
        accurate = {i for i, solution in found.items() if solution.misfit <= limit * noise[i]}
        for i in sorted(found.keys() - accurate):
            begin = self._end(run, i - 1) if i - 1 in accurate else None
            if begin is not None:
                again = self._segments(run, values, {i: begin}).values()
                found[i] = min([found[i], *again], key=lambda solution: solution.misfit)
                accurate |= {i} if found[i].misfit <= limit * noise[i] else set()

    def _end(self, run: SampledRun, index: int) -> np.ndarray | None:
        """The states (nx,) at the first sample after a segment, extrapolated from its last two samples; None where the
        next segment does not begin there."""
        states, known = self.equations.states, run.guess.get(index, {}).get("states", {})
        if not states or run.segments[index][1] != run.segments[index + 1][0] or not {*states} <= {*known}:
            return None
        samples = run.segments[index][1] - run.segments[index][0]
        steps = (len(known[states[0]]) - 1) // (samples - 1)
        last, before = (np.array([known[n][place] for n in states]) for place in (-1, -1 - steps))
        return 2 * last - before

    def _at_rest(self, run: SampledRun) -> dict[int, np.ndarray]:
        """The initial states (nx,) of every segment where the component is at rest."""
        return dict.fromkeys(range(len(run.segments)), self._start_values)

    def _extended(
        self, run: SampledRun, indices: Sequence[int], values: Mapping[str, float], in_pieces: bool
    ) -> dict[int, np.ndarray]:
        """Initial states estimated from a segment's first samples, then from one period, then from several.

        Over a segment of an unstable motion an error of the first estimate grows so much that the motion may be
        another one: there the first period is a part of the segment.
        """
        x, length = {i: self.first_states(run, i) for i in indices}, int(run.recording.rate / run.middle_frequency)
        if run.stable_length is not None and indices:
            shortest = min(last - first for first, last in (run.segments[i] for i in indices))
            length = min(length, shortest // UNSTABLE_PARTS)
        length = max(length, LEAST_LENGTH)
        while self.equations.states and (longer := [i for i in x if length < run.segments[i][1] - run.segments[i][0]]):
            for _ in range(EXTENSION_STEPS):
                extended = {}
                for together, made, nodes in self.simulated_apart(
                    run, longer, values, x, length, in_pieces=in_pieces
                ):
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
        self, run: SampledRun, values: Mapping[str, float], initial: Initial, steps: int = STEPS, held: int = 0
    ) -> dict[int, SegmentSolution]:
        """Segments from the best initial states, by at most so many Gauss-Newton steps from guesses; those that cannot
        be simulated are left out."""
        return self._refined(run, values, self._from(run, values, initial, held), steps)

    def _refined(
        self, run: SampledRun, values: Mapping[str, float], best: dict[int, SegmentStart], steps: int = STEPS
    ) -> dict[int, SegmentSolution]:
        """The same for segments that have been simulated once."""
        moves = {i: begun.step for i, begun in best.items()}
        for _ in range(steps):
            unconverged = [i for i, begun in best.items() if begun.gain >= SETTLED + SHARE * begun.rest]
            self._predict_states(run, {i: (best[i], moves[i]) for i in unconverged})
            others = self._from(run, values, {i: best[i].x + moves[i] for i in unconverged})
            for i in unconverged:
                if i in others and others[i].chi2 < best[i].chi2:
                    best[i], moves[i] = others[i], others[i].step
                else:  # worse, or it cannot be simulated
                    moves[i] = SHORTER * moves[i]
        lags = {name: self._later(run, values, name, best) for name in self.lags}
        fitted_to_the_end: dict[int, SegmentSolution] = {}
        delayed = [i for i in best if all(i in later for later in lags.values())]
        for made in {id(best[i].made): best[i].made for i in delayed}.values():
            for alike in groups(run, {i for i in delayed if best[i].made is made}):
                with suppress(InputError):  # derivatives that are not finite
                    slopes = self._slopes(run, values, alike, best, lags)
                    fitted_to_the_end |= segment_solutions(run, alike, best, slopes)
        return fitted_to_the_end

    def _predict_states(self, run: SampledRun, changes: Mapping[int, tuple[SegmentStart, np.ndarray]]) -> None:
        """Predict the states of segments to first order after a change (nx,) of the initial states of each, as the
        guess of their next simulation."""
        for made in {id(begun.made): begun.made for begun, _ in changes.values()}.values():
            own = {i: (begun.samples, change) for i, (begun, change) in changes.items() if begun.made is made}
            states = made.states_after({samples.start: change for samples, change in own.values()})
            for i, (samples, _) in own.items():
                known = states[samples.start : samples.stop].T.copy()
                run.guess[i]["states"] = dict(zip(self.equations.states, known, strict=True))

    def _later(
        self, run: SampledRun, values: Mapping[str, float], lag: str, best: Mapping[int, SegmentStart]
    ) -> dict[int, np.ndarray]:
        """The derivatives (m,) by a delay."""
        slopes: dict[int, np.ndarray] = {}
        x, step = {i: begun.x for i, begun in best.items()}, DELAY_STEP / run.recording.rate
        for indices, made, nodes in self.simulated_apart(run, list(best), {**values, lag: values[lag] + step}, x):
            where = dict(zip(indices, nodes.samples, strict=True))
            for alike in groups(run, where):
                change = np.array([made.outputs[where[i]] - best[i].made.outputs[best[i].samples] for i in alike])
                rows = run.reduction.rows_of(alike)
                of_data = run.reduction.reduce_segments(change / step, alike) / run.deviation[rows]
                slopes |= dict(zip(alike, of_data, strict=True))
        return slopes

    def _slopes(
        self,
        run: SampledRun,
        values: Mapping[str, float],
        alike: Sequence[int],
        best: Mapping[int, SegmentStart],
        lags: Mapping[str, Mapping[int, np.ndarray]],
    ) -> np.ndarray:
        """The derivatives (segments, m, np) of the reduced outputs of segments that are alike, over the noise; lags
        holds those (m,) by delays."""
        rows = run.reduction.rows_of(alike)
        found = np.zeros((*rows.shape, len(self.names)))
        slopes = np.array([best[i].made.slopes[best[i].samples] for i in alike])
        of_data = run.reduction.reduce_segments(slopes, alike) / run.deviation[rows][..., None]
        found[..., [self.names.index(n) for n in self.equations.parameters]] = of_data
        for name, by_delay in lags.items():
            found[..., self.names.index(name)] = [by_delay[i] for i in alike]
        found[..., : len(self.base)] *= [values[n] for n in self.base]
        return found

    def _from(
        self, run: SampledRun, values: Mapping[str, float], initial: Initial, held: int = 0
    ) -> dict[int, SegmentStart]:
        """Segments from initial states, each with the step to better ones; those that cannot be
        simulated are left out."""
        begun: dict[int, SegmentStart] = {}
        deviations = np.zeros(0) if run.experiment.from_rest else self._initial_deviations
        for indices, made, nodes in self.simulated_apart(run, list(initial), values, initial, held=held):
            where = dict(zip(indices, nodes.samples, strict=True))
            for alike in groups(run, where):
                begun |= segment_starts(run, {i: initial[i] for i in alike}, made, where, deviations)
        return begun
