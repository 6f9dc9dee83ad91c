"""A mechanism with several driven degrees of freedom fitted by inverse dynamics: the recorded deflections are imposed
with their rates and accelerations, and the efforts that they require are compared with the recorded ones.

    x'' = f(x, x', u; theta),   f affine in u
    u = -B^-1 (f(x, x', 0; theta) - x''),   B = df/du,   du/dtheta = -B^-1 df/dtheta

The efforts are linear in masses, dampings, stiffnesses and the magnitudes of effects, and no motion is simulated: the
result hardly depends on the starting values, and errors do not grow over time where the motion is unstable. The noise
of the recorded motion biases the values. They are therefore starting values of fits by output error only.

Source: Khalil, Dombre, Modeling, Identification and Control of Robots (2002), ch. 12.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from fmus.support.errors import InputError
from motofmi.gap.experiments.state_rates import rates_of_states
from motofmi.gap.models.equations import Equations
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.blocks import Blocks, blocks_of
from motofmi.gap.preprocessing.input_interpolation import (
    INTERPOLATIONS,
    RESOLVED_RATIO,
    motion_functions,
    resolved_frequency,
)
from motofmi.gap.preprocessing.sampled_run import SampledRun
from motofmi.gap.preprocessing.sampled_run_preparation import END_SHARE
from motofmi.gap.preprocessing.segments import LEAST_LENGTH
from motofmi.recordings.resampling import varies

LARGEST_CHANGE = np.log(1e4)  # of the logarithm of a parameter of the base
TOLERANCE = 1e-6  # relative change of chi-square, and of the parameters, at which a fit of starting values ends


@dataclass(frozen=True)
class ImposedMotions:
    """A run with its time [s], deflections and rates (n,) by name in `known`, the derivatives (n, k) of the states
    `rates`, and the recorded efforts (n, k) of the inputs `efforts`."""

    rates: list[str]
    efforts: list[str]
    known: dict[str, np.ndarray]
    acceleration: np.ndarray
    recorded: np.ndarray
    reduction: Blocks

    def residuals(self, equations: Equations, values: dict[str, float]) -> np.ndarray:
        """The required less the recorded efforts (m,), each over its rms, in the band in which all motions are
        resolved."""
        return self._reduced(self.required(equations, values)[0] - self.recorded)

    def slopes(self, equations: Equations, values: dict[str, float]) -> np.ndarray:
        """The derivatives (m, np) of the residuals by the parameters of the equations."""
        required, by_effort = self.required(equations, values)
        known = {**values, **self.known, **dict(zip(self.efforts, required.T, strict=True))}
        rates = np.zeros((*required.shape, len(equations.parameters)))
        places = {equations.states.index(n): row for row, n in enumerate(self.rates)}
        for (i, k), slope in equations.slopes(known).items():
            if i in places:
                rates[:, places[i], k] = slope
        return self._reduced(-np.linalg.solve(by_effort, rates))

    def required(self, equations: Equations, values: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
        """The efforts (n, k) that the motions require, and the derivatives (n, k, k) of the accelerations by them."""
        size, places = len(self.acceleration), [equations.states.index(n) for n in self.rates]

        def accelerations(effort: str = "") -> np.ndarray:
            """(n, k), with one effort of 1 in its unit, or without any."""
            forced = {n: float(n == effort) for n in self.efforts}
            rates = equations({**values, **self.known, **forced})[0]
            return np.column_stack([np.broadcast_to(rates[i], size) for i in places])

        unforced = accelerations()
        by_effort = np.stack([accelerations(n) - unforced for n in self.efforts], axis=-1)
        return np.linalg.solve(by_effort, (self.acceleration - unforced)[..., None])[..., 0], by_effort

    def _reduced(self, efforts: np.ndarray) -> np.ndarray:
        """Efforts (n, k, ...) over the rms of the recorded ones, as coefficients (m, ...) in the compared band."""
        scale = self.recorded.std(axis=0)
        return self.reduction.reduce(efforts / scale.reshape(-1, *(1,) * (efforts.ndim - 2)))


def imposed_motions(model: FreeInitialStateModel, runs: Sequence[SampledRun]) -> list[ImposedMotions]:
    """The runs with all their deflections imposed; empty where the component has one degree of freedom, other states
    than deflections and rates, or a deflection or effort that is not recorded."""
    experiment, component = model.experiment, model.experiment.component
    if experiment.imposed or experiment.from_rest:
        return []
    rates = {n: found[0] for n, found in rates_of_states(component).items() if len(found) == 1}
    rates = {n: rate for n, rate in rates.items() if n in experiment.outputs}
    efforts = [n for n in experiment.driven if all(varies(run.recording[n]) for run in runs)]
    if {*rates, *rates.values()} != set(component.states) or not len(rates) == len(efforts) > 1:
        return []
    return [_imposed(run, rates, efforts) for run in runs]


def _imposed(run: SampledRun, rates: dict[str, str], efforts: list[str]) -> ImposedMotions:
    recording, time, rate = run.recording, run.recording.time, run.recording.rate
    known = {"time": time}
    accelerations = []
    for deflection, speed in rates.items():
        functions = motion_functions(time, recording[deflection], speed, INTERPOLATIONS[0])
        known |= {deflection: functions[""](time), speed: functions[speed](time)}
        accelerations.append(functions[f"der({speed})"](time))
    band = min(run.reduction_band, *(resolved_frequency(recording[n], rate, RESOLVED_RATIO) for n in rates))
    margin = int(END_SHARE * len(time))
    cut = [(max(first, margin), min(last, len(time) - margin)) for first, last in run.intervals]
    inside = [(first, last) for first, last in cut if last - first >= LEAST_LENGTH]
    return ImposedMotions(
        list(rates.values()), efforts, known, np.column_stack(accelerations),
        np.column_stack([recording[n] for n in efforts]), blocks_of(inside, len(efforts), rate, band),
    )  # fmt: skip


def inverse_dynamics_fit(
    model: FreeInitialStateModel, motions: Sequence[ImposedMotions], start: np.ndarray
) -> tuple[np.ndarray, float] | None:
    """The model's vector from a start, and the sum of squares over the variance of the efforts; None where an effect
    has states or delays, which are not recorded, or where no vector gives finite efforts.

    Sensor offsets keep their start.
    """
    if model.component.states != model.experiment.component.states or model.lags:
        return None
    offsets = model.experiment.unrestricted
    fitted = [i for i, name in enumerate(model.names) if name not in offsets]
    low, high = start - LARGEST_CHANGE, start + LARGEST_CHANGE
    for i in fitted:
        if i >= len(model.base):
            low[i], high[i] = (getattr(model.rows[i - len(model.base)], bound) for bound in ("min", "max"))

    def vector(free: np.ndarray) -> np.ndarray:
        x = start.copy()
        x[fitted] = free
        return x

    def residuals(free: np.ndarray) -> np.ndarray:
        values = model.values(vector(free))
        return np.concatenate([each.residuals(model.equations, values) for each in motions])

    def slopes(free: np.ndarray) -> np.ndarray:
        values = model.values(vector(free))
        of_logarithms = np.array([values[n] if n in model.base else 1.0 for n in model.names])
        by_parameter = np.concatenate([each.slopes(model.equations, values) for each in motions])
        return (by_parameter * of_logarithms)[:, fitted]

    with suppress(InputError, ValueError, np.linalg.LinAlgError), np.errstate(all="ignore"):
        begin = np.clip(start, np.nextafter(low, np.inf), np.nextafter(high, -np.inf))
        found = least_squares(
            residuals, begin[fitted], jac=slopes, bounds=(low[fitted], high[fitted]), x_scale="jac", ftol=TOLERANCE,
            xtol=TOLERANCE,
        )
        return vector(found.x), 2 * float(found.cost)
    return None
