"""The models of a comparison: the base, single effects and pairs, with their losses on the same blocks.

The fit of every compared model is refined until another step would change its parameters by much less than their
standard errors. On validation runs only initial states and sensor offsets are estimated.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fmus.effects import Effect
from fmus.support.deadline import time_is_up
from fmus.support.errors import InputError
from fmus.support.parallel import parallel_map
from motofmi.gap.comparison.active_bounds import at_zero
from motofmi.gap.comparison.adjusted_likelihood_ratio import adjusted_errors
from motofmi.gap.comparison.band_dependence import LOWEST_PART, band_dependence
from motofmi.gap.comparison.block_losses import divided, left_out_mean_squares, mean_squares, partition
from motofmi.gap.comparison.residuals import Block, TimeResiduals, time_residuals
from motofmi.gap.comparison.sandwich import sandwich_covariance
from motofmi.gap.comparison.unresolved_modes import unresolved_modes
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import undetermined_magnitude
from motofmi.gap.estimation.fit_result import (
    Fit,
    PortableFit,
    initial_guesses,
    or_from_recorded_motion,
    standard_errors,
    with_initial_guesses,
)
from motofmi.gap.estimation.fitting import fit, shape_at_bound
from motofmi.gap.preprocessing.sampled_run import ACCURACY, SampledRun
from motofmi.gap.validation.before_after import on_validation_runs

LEAST_GAIN = 1e-3  # gain of a step over the chi-square per datum [1] below which a refinement ends
MOST_STEPS = 15  # steps of a refinement


@dataclass(frozen=True)
class ComparedModel:
    """A fitted model with its mean squares on blocks.

    fitted (blocks,) are the mean squares on blocks of the fitted runs, each in the fit without that block; validation
    (blocks,) are those on validation runs, empty where there are none. Every output is divided by the scale of the
    comparison, so that mean squares have no unit. floor [1] is the mean square that no model of a real component is
    expected to go below. judged_alone is whether the validation blocks are enough to be judged without the fitted runs.
    validated is the fit on the validation runs, with the values of the fitted ones; None without such runs.
    """

    effects: tuple[type[Effect], ...]
    fit: Fit
    fitted: np.ndarray
    validation: np.ndarray
    floor: float
    judged_alone: bool = True
    validated: Fit | None = None

    @property
    def families(self) -> frozenset[str]:
        """The families of its effects."""
        return frozenset(effect.family for effect in self.effects)

    @property
    def parameters(self) -> int:
        """The number of parameters of its effects."""
        return len(self.fit.model.own)

    @property
    def losses(self) -> np.ndarray:
        """The logarithmic losses (blocks,) [1] on all blocks, fitted runs first."""
        return np.log(np.concatenate([self.fitted, self.validation]) + self.floor)

    @property
    def fitted_losses(self) -> np.ndarray:
        """The logarithmic losses (blocks,) [1] on the blocks of the fitted runs."""
        return np.log(self.fitted + self.floor)

    @property
    def validation_loss(self) -> float:
        """The mean logarithmic loss [1] on validation runs, of which there must be some."""
        return float(np.mean(np.log(self.validation + self.floor)))

    @property
    def out_of_sample(self) -> np.ndarray:
        """The mean squares (blocks,) [1] on data that were not used for the fit.

        These are the validation runs; where there are none or too few blocks of them, blocks that are left out of the
        fit as well.
        """
        alone = len(self.validation) and self.judged_alone
        return self.validation if alone else np.concatenate([self.fitted, self.validation])

    @property
    def reported(self) -> np.ndarray:
        """The mean squares (blocks,) [1] to which reported shares refer: those of validation runs, however few; without
        them those of left-out blocks."""
        return self.validation if len(self.validation) else self.fitted

    def __repr__(self) -> str:
        named = " and ".join(f"{e.family} ({e.form})" for e in self.effects) or "base alone"
        return f"ComparedModel({named}, mean loss {self.losses.mean():.3f})"


class CommonBlocks:
    """The blocks of the fitted runs and of the validation runs on which all models are compared.

    The length of the blocks is the correlation length of the residuals of the leading fit. scale (outputs,) are the
    standard deviations by which the outputs are divided. not_simulated are the fits that were to be compared and could
    not be simulated on all runs.
    """

    def __init__(self, leading: Fit, validation: Sequence[SampledRun], criteria: Criteria):
        self.validation, self.criteria = list(validation), criteria
        self.not_simulated: list[Fit] = []
        self._refined: dict[int, Fit] = {}  # the results of `refined` by id; kept, so that no id recurs
        residuals = time_residuals(leading)
        self.scale, self.blocks = residuals.scale, partition(residuals)
        outputs = np.concatenate([run.measured for run in leading.runs])
        self.floor = float(np.mean((ACCURACY * outputs.std(axis=0) / self.scale) ** 2))
        self.validation_blocks: list[Block] = []
        if self.validation:
            validated = on_validation_runs(leading, self.validation, criteria).fit
            longest = max(last - first for _, first, last in self.blocks)
            # The search of each model for its initial states begins at those of the leading one.
            self.validation = with_initial_guesses(self.validation, initial_guesses(validated.runs))
            self.validation_blocks = partition(time_residuals(validated, self.scale), longest)

    def evaluated(self, found: Fit) -> ComparedModel | None:
        """The mean squares of a fit on all blocks; None where it cannot be simulated or differentiated, or after a
        deadline."""
        if time_is_up():
            return None
        try:
            fitted = left_out_mean_squares(time_residuals(found, self.scale), self.blocks)
            validation, validated = np.zeros(0), None
            if self.validation:
                validated = or_from_recorded_motion(
                    lambda runs: on_validation_runs(found, runs, self.criteria).fit, self.validation
                )
                validation = mean_squares(time_residuals(validated, self.scale), self.validation_blocks)
        except (InputError, ValueError, np.linalg.LinAlgError):
            return None
        if not (np.all(np.isfinite(fitted)) and np.all(np.isfinite(validation))):
            return None
        return self._compared(found, fitted, validation, validated)

    def _compared(
        self, found: Fit, fitted: np.ndarray, validation: np.ndarray, validated: Fit | None
    ) -> ComparedModel:
        alone = len(validation) >= self.criteria.fewest_validation_blocks
        return ComparedModel(found.model.effects, found, fitted, validation, self.floor, alone, validated)

    def refined_and_evaluated(self, fits: Sequence[Fit], description: str) -> list[ComparedModel]:
        """The compared models of refined fits, without those that cannot be simulated.

        description names the computation in the progress display.
        """

        def mean_squares_of(found: Fit) -> tuple[PortableFit, np.ndarray, np.ndarray, PortableFit | None] | None:
            refined = found if id(found) in self._refined else refined_fit(found)
            model, portable = self.evaluated(refined), PortableFit.of(refined)
            if model is None or portable is None:
                return None
            return portable, model.fitted, model.validation, PortableFit.of(model.validated)

        models = []
        for found, result in zip(fits, parallel_map(mean_squares_of, fits, description), strict=True):
            if result is None:
                self.not_simulated += [] if time_is_up() else [found]
            else:
                portable, fitted, validation, validated = result
                refined = portable.on(found.model, found.runs)
                again = None if validated is None else validated.on(found.model, self.validation)
                models.append(self._compared(refined, fitted, validation, again))
        return models

    def refined(self, found: Fit) -> Fit:
        """The refined fit, which later evaluations on these blocks do not refine again."""
        again = refined_fit(found)
        self._refined[id(again)] = again
        return again

    def fitted_losses(self, found: Fit) -> np.ndarray | None:
        """The logarithmic losses (blocks,) [1] on the fitted runs; None where they cannot be computed, or after a
        deadline."""
        if time_is_up():
            return None
        try:
            squares = left_out_mean_squares(time_residuals(found, self.scale), self.blocks)
        except (ValueError, np.linalg.LinAlgError):
            return None
        losses = np.log(squares + self.floor)
        return losses if np.all(np.isfinite(losses)) else None

    def is_undetermined(self, found: Fit, simpler: Sequence[Fit] = ()) -> bool:
        """Whether the magnitude of an effect is not distinguishable from zero, by its standard errors.

        simpler are fits without one effect of the fit, by whose chi-square the errors are adjusted.
        """
        errors = adjusted_errors(
            found, standard_errors(self.covariance(found)), simpler, self.criteria.value_errors
        )
        return undetermined_magnitude(found, errors, self.criteria) is not None

    def covariance(self, found: Fit) -> np.ndarray:
        """The covariance (parameters, parameters) of fitted values, with errors of the model: the sandwich over blocks,
        and the squared differences of values that depend on the compared band. Parameters at an active bound are fixed
        for the errors of all others.

        Fewer blocks than a name needs do not show how much the values vary: they are divided. The residuals of their
        parts are correlated, so that these errors are underestimated."""
        every, fixed = (self.residuals(found), time_residuals(found, self.scale, LOWEST_PART)), at_zero(found)
        blocks = divided(self.blocks, self.criteria.fewest_fitted_blocks)
        whole, low = (residuals.with_fixed(fixed) for residuals in every)
        of_band = band_dependence(whole, low, blocks, self.criteria.value_errors)
        covariance = sandwich_covariance(whole, blocks) + np.diag(of_band**2)
        if len(fixed):
            covariance[fixed, fixed] = np.diag(sandwich_covariance(every[0], blocks))[fixed]
        return covariance

    def is_disturbance(self, found: Fit) -> bool:
        """Whether a fit reduces the misfit by the free initial states of an effect without a magnitude, or has an
        effect whose shape is at a bound, where it is not distinguishable from another one (see `shape_at_bound`).

        An effect with states of its own does so even where its magnitude is not distinguishable from zero, and where
        its mode is not resolved (see `unresolved_modes`).
        """
        if not any(effect.has_states() for effect in found.model.effects):
            return False
        return bool(unresolved_modes(found) is not None or shape_at_bound(found) or self.is_undetermined(found))

    def residuals(self, found: Fit) -> TimeResiduals:
        """The residuals of a fit over time, each output over the scale of the comparison."""
        return time_residuals(found, self.scale)


def refined_fit(found: Fit) -> Fit:
    """The fit continued until a step gains little; itself where it cannot be simulated again."""
    try:
        again = fit(found.model, found.runs, found.x, gain=LEAST_GAIN * found.chi2 / found.count, iterations=MOST_STEPS)
    except InputError:
        return found
    return again if again.chi2 <= found.chi2 else found
