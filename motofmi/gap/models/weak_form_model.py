"""Base and effects as accelerations at the measured states, for runs in weak form.

The accelerations are those of the component, M^-1 f, at the recorded states and inputs. Derivatives by
parameters are finite differences, exact to rounding for linear parameters. A delayed input is the recorded one,
interpolated at earlier times.
"""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from fmus.equations.sympy_form import symbolic
from fmus.expressions.functions import NUMERIC
from fmus.support.errors import InputError
from motofmi.gap.experiments.vehicle_over_speed import VehicleOverSpeedExperiment
from motofmi.gap.models.linear_model import LinearModel
from motofmi.gap.preprocessing.weak_form import WeakFormRun, with_noise
from motofmi.gap.preprocessing.weak_form_noise import disturbance


def accelerated(experiment: VehicleOverSpeedExperiment) -> tuple[str, ...]:
    """The states of the component whose derivatives are not states themselves."""
    form = symbolic(experiment.component)
    return tuple(
        n
        for n, rate in zip(experiment.component.states, form.rates, strict=True)
        if str(rate) not in experiment.component.states
    )


class WeakFormModel(LinearModel):
    """Accelerations at the measured states, for a fit."""

    @cached_property
    def accelerated(self) -> tuple[str, ...]:
        """The states of the component whose derivatives are not states themselves."""
        return accelerated(self.experiment)

    def reduced(self, run: WeakFormRun, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The weak form of the accelerations (m,) and its slopes (m, np), over the deviation."""
        step = np.diag(self.steps(q))
        here = self.accelerations(run, q)
        wanted = range(self.sloped_from, len(q))
        signals = [here] + [(self.accelerations(run, q + step[i]) - here) / step[i, i] for i in wanted]
        weak = run.whitened(run.tested(np.stack(signals))) / run.deviation
        slopes = np.zeros((weak.shape[1], len(q)))
        slopes[:, self.sloped_from :] = weak[1:].T
        return weak[0], slopes

    def predicted(self, run: WeakFormRun, q: np.ndarray) -> np.ndarray:
        """The weak form of the accelerations (m,) over the deviation."""
        return run.whitened(run.tested(self.accelerations(run, q))) / run.deviation

    def accelerations(self, run: WeakFormRun, q: np.ndarray) -> np.ndarray:
        """Accelerations (equations, blocks, length) [rad/s2]. Raises InputError for an effect with states,
        which are not recorded."""
        if self.component.states != self.experiment.component.states:
            raise InputError(f"{self.component.name}: an effect has states, which are not recorded")
        component, time = self.component, run.recording.time
        columns = run.recording.columns
        inputs = {n: columns[n] for n in component.states} | {
            n: run.inputs(n) for n in component.inputs if n in columns
        }
        values = {**component.start_values(), **self.values(q)}
        for name, (source, delay) in component.delays.items():
            inputs[name] = np.interp(time - values[delay], time, inputs[source])
        values |= {n: x[run.places] for n, x in {**inputs, "time": time}.items()}
        results = component.run(values, NUMERIC)
        coupled = self.accelerated
        entries = component.mass_entries(values, NUMERIC)
        mass = np.array([[entries.get((a, b), float(a == b)) for b in coupled] for a in coupled], float)
        forces = np.array([results[f"der({n})"] for n in coupled])
        rates = np.linalg.solve(mass, forces.reshape(len(coupled), -1)).reshape(forces.shape)
        return np.stack([rates[coupled.index(n)] for n in run.rates])

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
