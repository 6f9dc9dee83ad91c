"""Base and effects as accelerations at the measured states, for runs in weak form.

The accelerations are the component's own, M^-1 f, at the recorded states and inputs; slopes by parameters are
differences, exact to rounding where a parameter enters linearly. An input that lags is the recorded one, earlier.
"""

from collections.abc import Sequence

import numpy as np

from fmus.errors import InputError
from fmus.mathematics import NUMERIC
from fmus.symbolic import symbolic
from identification.gap.data.weak_form import WeakRun, with_noise
from identification.gap.data.weak_noise import disturbance
from identification.gap.models.linear_model import LinearModel
from identification.gap.stands.linear_stand import LinearStand


def accelerated(stand: LinearStand) -> tuple[str, ...]:
    """The states of the component whose derivatives are not states themselves."""
    form = symbolic(stand.component)
    return tuple(n for n, rate in zip(stand.component.states, form.rates, strict=True) if str(rate) not in stand.component.states)


class WeakModel(LinearModel):
    """Accelerations at the measured states, for a fit."""

    def reduced(self, run: WeakRun, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The weak form of the accelerations (m,) and its slopes (m, np), over the deviation."""
        step = np.diag(self.steps(q))
        here = self.accelerations(run, q)
        wanted = range(self.sloped_from, len(q))
        signals = [here] + [(self.accelerations(run, q + step[i]) - here) / step[i, i] for i in wanted]
        weak = run.whitened(run.tested(np.stack(signals))) / run.deviation
        slopes = np.zeros((weak.shape[1], len(q)))
        slopes[:, self.sloped_from :] = weak[1:].T
        return weak[0], slopes

    def predicted(self, run: WeakRun, q: np.ndarray) -> np.ndarray:
        """The weak form of the accelerations (m,) over the deviation."""
        return run.whitened(run.tested(self.accelerations(run, q))) / run.deviation

    def accelerations(self, run: WeakRun, q: np.ndarray) -> np.ndarray:
        """(equations, blocks, length) [rad/s2]. Raises InputError for an effect with states, which no recording has."""
        if self.component.states != self.stand.component.states:
            raise InputError(f"{self.component.name}: an effect brings states, which no recording has")
        component, time = self.component, run.recording.time
        columns = run.recording.columns
        told = {n: columns[n] for n in component.states} | {n: run.told(n) for n in component.inputs if n in columns}
        values = {**component.start_values(), **self.values(q)}
        for name, (source, delay) in component.delays.items():
            told[name] = np.interp(time - values[delay], time, told[source])
        values |= {n: x[run.places] for n, x in {**told, "time": time}.items()}
        results = component.run(values, NUMERIC)
        coupled = accelerated(self.stand)
        entries = component.mass_entries(values, NUMERIC)
        mass = np.array([[entries.get((a, b), float(a == b)) for b in coupled] for a in coupled], float)
        forces = np.array([results[f"der({n})"] for n in coupled])
        rates = np.linalg.solve(mass, forces.reshape(len(coupled), -1)).reshape(forces.shape)
        return np.stack([rates[coupled.index(n)] for n in run.rates])

    def largest(self, runs: Sequence[WeakRun]) -> float:
        """The largest angle of the component's elements."""
        angles = [e.deflection for e in self.component.elements.values()]
        return max(float(np.abs(run.recording[n][run.places]).max()) for run in runs for n in angles)

    def with_noise_beside(self, run: WeakRun, q: np.ndarray) -> WeakRun:
        """The run with the disturbance that a rich model leaves of it; it rests on no model of the vehicle."""
        del q
        columns = run.recording.columns
        angles = [columns[e.deflection] for e in self.component.elements.values()]
        speeds = [columns[e.rate] for e in self.component.elements.values()]
        inputs = [run.told(n) for n in self.stand.component.inputs if n in columns and n != self.stand.over]
        return with_noise(run, disturbance(run, [columns[n] for n in self.stand.component.states], inputs, columns[self.stand.over], angles, speeds))
