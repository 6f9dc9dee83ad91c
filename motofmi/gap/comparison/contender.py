"""Contenders: the base, single effects and pairs, each fitted once, with their losses on the same blocks.

The parameters of a contender are refined until another step would change them by much less than their errors; on
validation runs only initial states and sensor offsets are estimated.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fmus.effects import Effect
from fmus.support.errors import InputError
from fmus.support.parallel import parallel_map
from motofmi.gap.comparison.block_losses import Block, left_out_mean_squares, mean_squares, partition
from motofmi.gap.comparison.residuals import TimeResiduals, time_residuals
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.fit_result import Fit, PortableFit
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.preprocessing.sampled_run import ACCURACY, SampledRun
from motofmi.gap.validation.before_after import on_validation_runs

REFINED = 1e-3  # of chi-square per datum: the gain of a step below which a refinement ends
STEPS = 15  # of a refinement


@dataclass(frozen=True)
class Contender:
    """A fitted model: mean squares on the blocks of fitted runs (without each block) and of validation runs (or empty).

    Mean squares are in units of the fit's noise; floor is the mean square that no model of a real component is below.
    """

    effects: tuple[type[Effect], ...]
    fit: Fit
    fitted: np.ndarray
    validation: np.ndarray
    floor: float

    @property
    def families(self) -> frozenset[str]:
        return frozenset(effect.family for effect in self.effects)

    @property
    def parameters(self) -> int:
        """The number of parameters of its effects."""
        return len(self.fit.model.own)

    @property
    def losses(self) -> np.ndarray:
        """The logarithmic losses (blocks,) on all blocks, fitted runs first."""
        return np.log(np.concatenate([self.fitted, self.validation]) + self.floor)

    @property
    def held_out(self) -> np.ndarray:
        """The mean squares (blocks,) on validation runs, or, where there are none, on blocks left out of the fit."""
        return self.validation if len(self.validation) else self.fitted

    def __repr__(self) -> str:
        named = " and ".join(f"{e.family} ({e.form})" for e in self.effects) or "base alone"
        return f"Contender({named}, mean loss {self.losses.mean():.3f})"


class Arena:
    """The blocks on which contenders are compared: those of the fitted runs and of the validation runs.

    The length of blocks follows from what the leading fit leaves.
    """

    def __init__(self, leading: Fit, validation: Sequence[SampledRun], criteria: Criteria):
        self.validation, self.criteria = list(validation), criteria
        left = time_residuals(leading)
        self.scale, self.blocks = left.scale, partition(left)
        outputs = np.concatenate([run.measured for run in leading.runs])
        self.floor = float(np.mean((ACCURACY * outputs.std(axis=0) / self.scale) ** 2))
        self.validation_blocks: list[Block] = []
        if self.validation:
            seen = time_residuals(on_validation_runs(leading, self.validation, criteria).fit, self.scale)
            longest = max(last - first for _, first, last in self.blocks)
            self.validation_blocks = [
                (i, int(a), int(b))
                for i, n in enumerate(seen.lengths)
                for edges in [np.linspace(0, n, max(n // longest, 1) + 1).astype(int)]
                for a, b in pairwise(edges)
            ]

    def contender(self, found: Fit) -> Contender | None:
        """The contender of a fit; None where it cannot be simulated or differentiated."""
        try:
            fitted = left_out_mean_squares(time_residuals(found, self.scale), self.blocks)
            seen = np.zeros(0)
            if self.validation:
                again = on_validation_runs(found, self.validation, self.criteria).fit
                seen = mean_squares(time_residuals(again, self.scale), self.validation_blocks)
        except (InputError, ValueError, np.linalg.LinAlgError):
            return None
        if not (np.all(np.isfinite(fitted)) and np.all(np.isfinite(seen))):
            return None
        return Contender(found.model.effects, found, fitted, seen, self.floor)

    def contenders(self, fits: Sequence[Fit], description: str) -> list[Contender]:
        """The contenders of refined fits, without those that cannot be simulated."""

        def compared(found: Fit) -> tuple[PortableFit, tuple[np.ndarray, np.ndarray]] | None:
            refined = refined_fit(found)
            made = self.contender(refined)
            portable = PortableFit.of(refined)
            return None if made is None or portable is None else (portable, (made.fitted, made.validation))

        made = []
        for found, answer in zip(fits, parallel_map(compared, fits, description), strict=True):
            if answer is not None:
                portable, (fitted, seen) = answer
                made.append(
                    Contender(found.model.effects, portable.on(found.model, found.runs), fitted, seen, self.floor)
                )
        return made

    def fitted_losses(self, found: Fit) -> np.ndarray | None:
        """The logarithmic losses (blocks,) on the fitted runs; None where they cannot be computed."""
        try:
            squares = left_out_mean_squares(time_residuals(found, self.scale), self.blocks)
        except (ValueError, np.linalg.LinAlgError):
            return None
        losses = np.log(squares + self.floor)
        return losses if np.all(np.isfinite(losses)) else None

    def residuals(self, found: Fit) -> TimeResiduals:
        """The residuals of a fit over time in the units of the comparison."""
        return time_residuals(found, self.scale)


def refined_fit(found: Fit) -> Fit:
    """The fit continued until a step gains little; itself where it cannot be simulated again."""
    try:
        again = fit(found.model, found.runs, found.x, gain=REFINED * found.chi2 / found.count, iterations=STEPS)
    except InputError:
        return found
    return again if again.chi2 <= found.chi2 else found
