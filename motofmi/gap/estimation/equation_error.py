"""Base and single effects fitted by equation error: the recorded motion is imposed, and the effort that it requires is
compared with the recorded input.

    u = f(y, y', y''; theta, e)

The effort is linear in mass, damping, stiffness and the magnitudes of effects, and the motion is not simulated: the
result hardly depends on the starting values, and errors do not grow over time where the motion is unstable. The noise
of the recorded motion biases the values. They are therefore starting values of fits by output error only.

Source: Klein, Morelli, Aircraft System Identification (2006), ch. 5 (equation error), ch. 6 (its values as starts).
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from fmus.effects import Effect
from fmus.support.deadline import time_is_up
from fmus.support.errors import InputError
from fmus.support.parallel import parallel_map
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.inverse_dynamics import ImposedMotions, imposed_motions, inverse_dynamics_fit
from motofmi.gap.estimation.screening import Signature, screen
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run import SampledRun
from motofmi.gap.preprocessing.sampled_run_preparation import sampled_run
from motofmi.recordings.resampling import varies

LEAST_SHARE = 1e-12  # of the effort's rms, which the term of a parameter is taken to have at least


@dataclass(frozen=True)
class EquationErrorFit:
    """Values of the base (logarithms, in order) and of an effect's free parameters, with their chi-square.

    effect is None for the base alone.
    """

    effect: type[Effect] | None
    base: np.ndarray
    own: np.ndarray
    chi2: float

    def on(self, found: Fit) -> tuple[FreeInitialStateModel, np.ndarray]:
        """The base of a fit with the effect, and a vector x with these values and the sensor offsets of the fit."""
        of_base: Any = found.model
        model = of_base.with_added_effects(*([self.effect] if self.effect else []))
        bases, shared = len(self.base), len(found.model.names)
        return model, np.concatenate([self.base, found.x[bases:shared], self.own, found.x[shared:]])


def effort_model(
    model: FreeInitialStateModel, runs: Sequence[SampledRun]
) -> tuple[FreeInitialStateModel, list[SampledRun]] | None:
    """The model with a recorded output imposed and the effort of an input as output, and its runs; None where no
    recorded input drives a recorded state, or no band of the motion is resolved."""
    experiment = runs[0].experiment
    seen = [n for n in experiment.outputs if n in experiment.component.states]
    driving = [n for n in experiment.driven if all(varies(run.recording[n]) for run in runs)]
    for state, effort in product(seen, driving):
        with suppress(InputError):
            others = tuple(n for n in experiment.inputs if n != effort)
            turned = replace(
                model.experiment, inputs=(state, *others), outputs=(effort,), imposed=state, sensor_offsets={},
                measured_effects={},
            )  # fmt: skip
            return FreeInitialStateModel(turned), [sampled_run(run.recording, turned) for run in runs]
    return None


def equation_error_fits(found: Fit, library: Sequence[type[Effect]]) -> list[EquationErrorFit]:
    """The base of a fit and its single effects fitted by equation error, the least chi-square first.

    Effects that do not reduce chi-square, and flexible ones, are left out; so are those at several elements where one
    motion alone is imposed. Empty where no effort is recorded.
    """
    model: Any = found.model
    turned: tuple[FreeInitialStateModel, list[SampledRun]] | None
    if model.experiment.imposed:  # its output is the effort
        alone = replace(model.experiment, sensor_offsets={}, measured_effects={})
        turned = FreeInitialStateModel(alone), [sampled_run(run.recording, alone) for run in found.runs]
    elif motions := imposed_motions(model, found.runs):
        return _by_inverse_dynamics(found, motions, library)
    else:
        turned = effort_model(model, found.runs)
    if turned is None:
        return []
    bases = len(model.base)
    with suppress(InputError):
        base = _base(*turned, found.x[:bases])
        signatures = screen(base, [e for e in library if not (e.flexible or e.at_one)], keep=1)
        alike = _with_equal_terms(base)

        def fit_one(signature: Signature) -> tuple[np.ndarray, float] | None:
            if time_is_up():
                return None
            model = base.model.with_added_effects(signature.effect)
            # A declared share of the base's term is of the right size; a declared stiffness need not be.
            shares = [row.unit == "1" for row in model.rows]
            own = np.where(shares, model.start()[bases:], signature.start)
            best: Fit | None = None
            for start in (np.concatenate([base.x, signature.start]), np.concatenate([alike, own])):
                with suppress(InputError):  # it cannot be simulated from this start
                    again = fit(model, base.runs, start, beat=best.chi2 if best else base.chi2)
                    best = again if best is None or again.chi2 < best.chi2 else best
            return (best.x, best.chi2) if best is not None and best.chi2 < base.chi2 else None

        fits = parallel_map(fit_one, signatures, "fitting by equation error")
        singles = [
            EquationErrorFit(signature.effect, made[0][:bases], made[0][bases:], made[1])
            for signature, made in zip(signatures, fits, strict=True)
            if made is not None
        ]
        return sorted([EquationErrorFit(None, base.x, np.zeros(0), base.chi2), *singles], key=lambda each: each.chi2)
    return []


def _by_inverse_dynamics(
    found: Fit, motions: Sequence[ImposedMotions], library: Sequence[type[Effect]]
) -> list[EquationErrorFit]:
    """The same with all recorded deflections imposed together."""
    bases, shared = len(found.model.base), len(found.model.names)

    def fit_one(effect: type[Effect] | None) -> tuple[np.ndarray, float] | None:
        model: Any = found.model.with_added_effects(effect) if effect else found.model
        start = np.concatenate([found.x[:shared], model.start()[shared:]])
        return None if time_is_up() else inverse_dynamics_fit(model, motions, start)

    plain = [None, *(effect for effect in library if not effect.flexible)]
    base, *others = parallel_map(fit_one, plain, "fitting by inverse dynamics")
    if base is None:
        return []
    made = [(None, base), *((e, x) for e, x in zip(plain[1:], others, strict=True) if x and x[1] < base[1])]
    fits = [EquationErrorFit(effect, x[:bases], x[shared:], chi2) for effect, (x, chi2) in made]
    return sorted(fits, key=lambda each: each.chi2)


def _base(model: FreeInitialStateModel, runs: Sequence[SampledRun], start: np.ndarray) -> Fit:
    """The base by equation error, from given values and from those of the component. Raises InputError where neither
    can be simulated."""
    fits = []
    for each in (start, model.start()):
        with suppress(InputError):
            fits.append(fit(model, runs, each))
    if not fits:
        raise InputError(f"{model.component.name} cannot be simulated with its motion imposed")
    return min(fits, key=lambda each: each.chi2)


def _with_equal_terms(base: Fit) -> np.ndarray:
    """The base's vector with every parameter changed so that its term has the rms of the recorded effort.

    An effect may need a parameter that vanishes without it: the sine of a pendulum that goes round needs its stiffness.
    """
    effort = np.concatenate([run.data / run.deviation for run in base.runs])
    size = np.linalg.norm(effort)
    terms = np.linalg.norm(base.jacobian[: len(effort)], axis=0)
    return base.x + np.log(size / np.maximum(terms, LEAST_SHARE * size))
