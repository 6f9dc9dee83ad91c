"""Base and effects on sampled runs, whose unknown initial states and sensor offsets are eliminated from the
comparison."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fmus.composition.imposed_motion import ImposedMotion, ImposedThroughSpring
from fmus.declaration.component import Component
from fmus.effects import Effect
from fmus.expressions.functions import NUMERIC
from fmus.support.errors import InputError
from motofmi.gap.models.initial_states import InitialStateModel
from motofmi.gap.models.segment_unknowns import OFFSET_SAMPLES, SegmentStart
from motofmi.gap.models.segmented import Initial
from motofmi.gap.preprocessing.flexible_noise_model import features_of, noise_density
from motofmi.gap.preprocessing.sampled_run import SampledRun

REVOLUTION = 2 * np.pi  # rad
# Change of the rates by one revolution, over their range in it, below which they repeat: a spring changes them by the
# whole range, the sine of a pendulum by the error of its fitted share.
REPEATED = 0.1


class FreeInitialStateModel(InitialStateModel):
    """Base and effects on sampled runs."""

    experiment: Any
    predicted = None  # type: ignore[assignment]  # slopes come with the output

    def with_added_effects(self, *effects: type[Effect], slopes_of_base: bool = True) -> "FreeInitialStateModel":
        """The model with further effects."""
        joined = FreeInitialStateModel(self.experiment, [*self.effects, *effects], slopes_of_base)
        joined.extended = self
        return joined

    def with_experiment(self, experiment: Any) -> "FreeInitialStateModel":
        """The same effects on another experiment."""
        return FreeInitialStateModel(experiment, self.effects)

    def largest(self, runs: Sequence[Any]) -> float:
        """The largest deflection of the component's spring in the runs."""
        return self.experiment.largest

    def reduced(self, run: Any, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Reduced output (m,) and its derivatives (m, np) over the noise, with the unknowns of the run eliminated."""
        return self._reduced(run, q)

    def trial(self, run: Any, q: np.ndarray, begun: Mapping[int, SegmentStart]) -> tuple[np.ndarray, np.ndarray]:
        """`reduced`, from the initial states of segments that were simulated once (`begun`)."""
        return self._reduced(run, q, begun)

    def _reduced(
        self, run: SampledRun, q: np.ndarray, begun: Mapping[int, SegmentStart] | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        parts = self._solved(run, q, begun)
        return np.concatenate([part.output for part in parts]), np.concatenate([part.slopes for part in parts])

    def simulate_again(self, run: Any, q: np.ndarray) -> None:
        if len(self._from(run, self._valued(run, q), self._known_initial(run))) < len(run.segments):
            raise InputError(f"{self.component.name}: {run.name} cannot be simulated from the known initial states")

    def slopes(self, run: Any, q: np.ndarray, from_last: bool = False) -> np.ndarray:
        """The derivatives (m, np) of `reduced`, at the initial states of the model that these effects were added to."""
        held = self.states_without(self.values(q)) if from_last else 0
        found = self._at_known_initial(run, q, held) or self._solved(run, q)
        return np.concatenate([part.slopes for part in found])

    def from_rest(self, run: SampledRun, q: np.ndarray) -> np.ndarray:
        """The outputs (n, outputs) of segments that start at rest. Raises InputError where one cannot be simulated."""
        rest = {i: np.zeros(len(self.equations.states)) for i in range(len(run.segments))}
        return np.concatenate([outputs for outputs, _ in self._traces(run, self._valued(run, q), rest)])

    def unknowns(self, run: Any) -> int:
        """The number of unknown initial states and sensor offsets of all segments."""
        offsets = sum(last - first >= OFFSET_SAMPLES for first, last in run.segments)
        states = 0 if run.experiment.from_rest else len(run.segments) * len(self.equations.states)
        return states + offsets * int(np.sum(run.with_offset))

    def with_remaining_noise(self, run: Any, q: np.ndarray) -> Any:
        """The run with the noise that a flexible model leaves of the residuals; never more than
        with an earlier model."""
        if run.noise_source != "flexible_model":
            return run
        residuals, deflections, rates, linear = self.residuals_and_motion(run, q)
        features = features_of(deflections, rates, linear)
        found = [noise_density(r, features, run.recording.rate) for r in residuals.T]
        if run.noise_from_model:
            found = [new.or_less(old) for new, old in zip(found, run.densities, strict=True)]
        return replace(run.with_densities(found, run.noise_source), noise_from_model=True)

    def residuals_and_motion(
        self, run: SampledRun, q: np.ndarray
    ) -> tuple[np.ndarray, list[np.ndarray], list[np.ndarray], list[np.ndarray]]:
        """Residuals (n, outputs), deflections and rates of the elements, and inputs and outputs,
        over the segments (n,).

        The noise of an imposed motion is included in the residuals only. A component without elements has the
        deviations of its states from their means as deflections, and no rates. Raises InputError where the run cannot
        be simulated.
        """
        initial = self._found_initial(run, q)
        values = self._valued(run, q)
        residuals = [
            np.where(compared, left - run.with_offset * offset, 0.0)
            for left, compared, offset in self._without_mean(run, values, initial)
        ]
        deflections, rates, linear = self._signals(run, values, initial)
        return np.concatenate(residuals), deflections, rates, linear

    def offsets_of_outputs(self, run: SampledRun, q: np.ndarray) -> np.ndarray:
        """The mean (outputs,) over the segments of the fitted offset of each output; zero for one without an offset.

        Whole revolutions that do not change the equations are no offset. Raises InputError where the run cannot be
        simulated.
        """
        values = self._valued(run, q)
        segments = self._without_mean(run, values, self._found_initial(run, q))
        offsets = np.array([offset for _, _, offset in segments])
        for output, name in enumerate(run.experiment.outputs):
            if self._repeats_with_revolutions(name, values):
                offsets[:, output] -= REVOLUTION * np.round(offsets[:, output] / REVOLUTION)
        return run.with_offset * offsets.mean(axis=0)

    def _repeats_with_revolutions(self, state: str, values: Mapping[str, float]) -> bool:
        """Whether the equations are those of one revolution before, as with the sine of a pendulum."""
        component = self.component
        if state not in component.states or component.table[state].unit != "rad":
            return False
        angle = np.linspace(-REVOLUTION / 2, REVOLUTION / 2, 9)
        known = {n: np.zeros_like(angle) for n in (*component.states, *component.inputs, "time")}
        once, again = (component.run({**values, **known, state: each}, NUMERIC) for each in (angle, angle + REVOLUTION))
        rates = [n for n in once if n.startswith("der(")]
        return all(np.max(np.abs(again[n] - once[n])) <= REPEATED * np.ptp(once[n]) for n in rates)

    def _without_mean(
        self, run: SampledRun, values: Mapping[str, float], initial: Initial
    ) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Of every segment: recorded minus simulated outputs (n, outputs), which of them are compared, and the means
        (outputs,) of these."""
        found = []
        for (first, last), (outputs, _) in zip(run.segments, self._traces(run, values, initial), strict=True):
            left = run.measured[first:last] - outputs
            counts = np.ones_like(left, bool) if run.reduction.compared is None else run.reduction.compared[first:last]
            found.append((left, counts, np.sum(left * counts, axis=0) / np.maximum(counts.sum(axis=0), 1)))
        return found

    def ranges_of_states(self, run: SampledRun, q: np.ndarray) -> dict[str, tuple[float, float]]:
        """The least and the largest value of each state over the segments. Raises InputError where the run cannot be
        simulated."""
        initial = self._found_initial(run, q)
        states = np.concatenate([x for _, x in self._traces(run, self._valued(run, q), initial)])
        return {n: (float(x.min()), float(x.max())) for n, x in zip(self.equations.states, states.T, strict=True)}

    def _found_initial(self, run: SampledRun, q: np.ndarray) -> dict[int, np.ndarray]:
        """The best initial states of every segment."""
        if run.experiment.from_rest:
            return self._at_rest(run)
        self.reduced(run, q)
        missing = [i for i in range(len(run.segments)) if (*self.own, i) not in run.guess]
        if missing:
            raise InputError(
                f"{self.component.name}: no initial states were found with which {run.name} can be simulated; are "
                "inputs and outputs exchanged, is a unit wrong, or are the start values far from those of the recorded "
                "component?"
            )
        return {i: self._last(run, i) for i in range(len(run.segments))}

    def _signals(
        self, run: SampledRun, values: Mapping[str, float], initial: Initial
    ) -> tuple[list[np.ndarray], list[np.ndarray], list[np.ndarray]]:
        """Deflections, rates, and inputs and outputs (n,) over the segments, without the noise of an imposed motion."""
        found = []
        for (first, last), (made, states) in zip(
            run.segments, self._traces(run.noiseless, values, initial), strict=True
        ):
            time = run.recording.time[first:last]
            known = {
                **values,
                "time": time,
                **self._inputs(run.noiseless, time, values),
                **dict(zip(self.equations.states, states.T, strict=True)),
            }
            linear = [known[n] for n in self.component.inputs] + list(made.T)
            found.append(
                tuple([np.broadcast_to(x, len(time)) for x in each] for each in (*self._elements(known), linear))
            )
        deflections, rates, linear = ([np.concatenate(parts) for parts in zip(*each, strict=True)] for each in
                                      zip(*found, strict=True))  # fmt: skip
        if not self._bearing.elements:
            own = zip(*(states.T for _, states in self._traces(run.noiseless, values, initial)), strict=True)
            deflections = [x - x.mean() for x in map(np.concatenate, own)]
            rates = [np.zeros_like(x) for x in deflections]
        return deflections, rates, linear

    def _traces(
        self, run: SampledRun, values: Mapping[str, float], initial: Initial
    ) -> list[tuple[np.ndarray, np.ndarray]]:
        """Outputs (n, ny) and states (n, nx) at the samples of every segment. Raises InputError where one
        cannot be simulated."""
        traces: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        for indices, made, nodes in self.simulated_apart(run, range(len(run.segments)), values, initial):
            traces |= {
                i: (made.outputs[where], made.states[where]) for i, where in zip(indices, nodes.samples, strict=True)
            }
        self._complete(range(len(run.segments)), run, traces)
        return [traces[i] for i in range(len(run.segments))]

    @property
    def _bearing(self) -> Component:
        """The component that declares the elements."""
        return (
            self.component.inner if isinstance(self.component, ImposedMotion | ImposedThroughSpring) else self.component
        )

    @property
    def moving(self) -> list[tuple[str, str]]:
        """The deflections and rates of the elements by name, once each; the rate stands for a deflection that is not
        known."""
        elements = self._bearing.elements.values()
        return list(dict.fromkeys((e.deflection or e.rate, e.rate) for e in elements if e.rate))

    def _elements(self, known: Mapping[str, Any]) -> tuple[list, list]:
        """The values of deflections and rates that are named in `moving`."""
        component = self._bearing
        scope = component.run({**dict.fromkeys(component.inputs, 0.0), **known}, NUMERIC)
        both = [({**known, **scope}[d], {**known, **scope}[r]) for d, r in self.moving]
        return [d for d, _ in both], [r for _, r in both]
