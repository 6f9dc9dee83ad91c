"""Base and effects as accelerations at the measured states, for runs in weak form.

    M(p) x' = f(x, u, p),   with dx'/dp at the recorded states x and inputs u

A delayed input is the recorded one, interpolated linearly at earlier times.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from fmus.equations.numpy_program import recorded_equations
from fmus.support.errors import InputError
from motofmi.gap.experiments.vehicle_over_speed import VehicleOverSpeedExperiment
from motofmi.gap.models.equations import Equations, rate_of
from motofmi.gap.models.linear_model import LinearModel
from motofmi.gap.preprocessing.weak_form import WeakFormRun, with_noise
from motofmi.gap.preprocessing.weak_form_noise import disturbance


def accelerated(experiment: VehicleOverSpeedExperiment) -> tuple[str, ...]:
    """The states of the component whose derivatives are not states themselves."""
    form = recorded_equations(experiment.component)
    states = [form.symbols[n] for n in experiment.component.states]
    return tuple(s.word for s, rate in zip(states, form.rates, strict=True) if not any(rate is x for x in states))


class WeakFormModel(LinearModel):
    """Accelerations at the measured states, for a fit."""

    @cached_property
    def equations(self) -> Equations:
        """The rates of the states, with slopes by the parameters."""
        return Equations(self.component, (), self.names[self.sloped_from :])

    def reduced(self, run: WeakFormRun, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The weak form of the accelerations (m,) and its slopes (m, np), over the deviation."""
        values, states = self._recorded(run, q), self.component.states
        by_parameters = self.equations.slopes(values)
        signals = np.zeros((1 + len(q) - self.sloped_from, len(run.rates), *run.places.shape))
        signals[0] = self._of_rates(run, values)
        for (i, k), slope in by_parameters.items():
            if states[i] in run.rates:
                factor = values[self.names[self.sloped_from + k]] if self.sloped_from + k < len(self.base) else 1.0
                signals[1 + k, run.rates.index(states[i])] = factor * slope
        weak = run.whitened(run.tested(signals)) / run.deviation
        slopes = np.zeros((weak.shape[1], len(q)))
        slopes[:, self.sloped_from :] = weak[1:].T
        return weak[0], slopes

    def predicted(self, run: WeakFormRun, q: np.ndarray) -> np.ndarray:
        """The weak form of the accelerations (m,) over the deviation."""
        return run.whitened(run.tested(self.accelerations(run, q))) / run.deviation

    def accelerations(self, run: WeakFormRun, q: np.ndarray) -> np.ndarray:
        """Accelerations (equations, blocks, length) [rad/s2]. Raises InputError for an effect with states,
        which are not recorded."""
        return self._of_rates(run, self._recorded(run, q))

    def _of_rates(self, run: WeakFormRun, values: Mapping[str, Any]) -> np.ndarray:
        """The accelerations for values by name."""
        rates = dict(zip(self.component.states, self.equations(values)[0], strict=True))
        return np.stack([np.broadcast_to(rates[n], run.places.shape) for n in run.rates])

    def _recorded(self, run: WeakFormRun, q: np.ndarray) -> dict[str, Any]:
        """The parameters' values for a vector, and the recorded signals (blocks, length), by name. Raises InputError
        for an effect with states."""
        component, time, columns = self.component, run.recording.time, run.recording.columns
        if component.states != self.experiment.component.states:
            raise InputError(f"{component.name}: an effect has states, which are not recorded")
        signals = {"time": time, **{n: columns[n] for n in component.states}}
        signals |= {n: run.inputs(n) for n in component.inputs if n in columns}
        values = {**component.start_values(), **self.values(q)}
        for name, (source, delay) in component.delays.items():
            known, late = signals[source], time - values[delay]
            before = np.clip(np.searchsorted(time, late, side="right") - 1, 0, len(time) - 2)
            slope = (np.diff(known) / np.diff(time))[before]
            signals |= {name: np.interp(late, time, known), rate_of(name): np.where(late < time[0], 0.0, slope)}
        return values | {n: x[run.places] for n, x in signals.items()}

    def largest(self, runs: Sequence[WeakFormRun]) -> float:
        """The largest angle of the component's elements."""
        angles = [e.deflection for e in self.component.elements.values()]
        return max(float(np.abs(run.recording[n][run.places]).max()) for run in runs for n in angles)

    def with_remaining_noise(self, run: WeakFormRun, q: np.ndarray) -> WeakFormRun:
        """The run with the disturbance that a flexible regression leaves; it does not depend on the
        vehicle's parameters."""
        del q
        columns = run.recording.columns
        angles = [columns[e.deflection] for e in self.component.elements.values()]
        speeds = [columns[e.rate] for e in self.component.elements.values()]
        inputs = [run.inputs(n) for n in self.experiment.component.inputs if n in columns and n != self.experiment.over]
        return with_noise(
            run,
            disturbance(
                run,
                [columns[n] for n in self.experiment.component.states],
                inputs,
                columns[self.experiment.over],
                angles,
                speeds,
            ),
        )
