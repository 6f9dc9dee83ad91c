"""The comparison of base, single effects and pairs on runs whose noise is not known.

Source: Hansen, Lunde, Nason (2011) for the decision (see `confidence_set`); the other modules cite their own sources.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from fmus.effects import Effect
from fmus.support.errors import InputError
from motofmi.gap.comparison.adjusted_likelihood_ratio import adjusted_errors
from motofmi.gap.comparison.closable import closed_share, closes_as_much, flexible_mean_square, low_of_mean
from motofmi.gap.comparison.compared_model import CommonBlocks, ComparedModel
from motofmi.gap.comparison.objections import MEMBER, NOT_CLEAR, SMALL, WITHHELD, effects_of
from motofmi.gap.comparison.outcome import Outcome, outcome
from motofmi.gap.comparison.outside_library import sufficient_law, with_values
from motofmi.gap.comparison.own_values import disagreement
from motofmi.gap.comparison.pair_search import pairs
from motofmi.gap.comparison.search import leading_models, with_narrower_transitions
from motofmi.gap.comparison.simplest_form import one_per_families
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import Candidate
from motofmi.gap.estimation.fit_result import Fit, standard_errors
from motofmi.gap.estimation.laws_outside_library import laws_outside_library
from motofmi.gap.estimation.stages import Stage, running
from motofmi.gap.preprocessing.sampled_run import SampledRun


@dataclass(frozen=True)
class Comparison:
    """The outcome, and what it rests on.

    models are the compared models other than the base, one of each family or pair of families, the least loss first.
    law is the law outside the library because of which nothing is named. All mean squares are over the squared scale
    of the outputs [1].
    """

    outcome: Outcome
    base: ComparedModel
    models: list[ComparedModel]
    flexible_mean_square: float  # of the residuals of a flexible regression
    motion_mean_square: float  # of the outputs about their means in each segment
    block_counts: tuple[int, int]  # blocks of fitted and of validation runs
    law: ComparedModel | None = None

    def clear_pairs(self) -> list[ComparedModel]:
        """The pairs, without those whose gain on validation runs is small or not clear although there are enough blocks
        of them."""
        refused = (NOT_CLEAR, SMALL)
        return [
            m
            for m in self.models
            if len(m.effects) > 1 and not (m.judged_alone and self.outcome.standing.get(id(m)) in refused)
        ]

    def __repr__(self) -> str:
        fitted, validation = self.block_counts
        blocks = f"{fitted} fitted and {validation} validation blocks"
        return f"Comparison({self.outcome.verdict!r}, {len(self.models)} models on {blocks})"


def compare(
    base: Fit,
    singles: Sequence[Candidate],
    library: Sequence[type[Effect]],
    validation: Sequence[SampledRun],
    criteria: Criteria,
    on_progress: Callable[[Callable[[], Comparison]], None] = lambda known: None,
) -> Comparison | None:
    """The comparison of a base, its fitted single effects and pairs of them; None where the base cannot be compared.

    singles are fits of one effect each on the runs of the base; validation are prepared runs with the noise of the
    fitted ones. on_progress is called after the single effects, with a function that compares them alone, and after the
    pairs. The fits of the compared models get the covariance that includes errors of the model.
    """
    with running(Stage.COMPARISON):
        blocks = _blocks(base, singles, validation, criteria)
        compared_base = blocks.evaluated(base)
        if compared_base is None:
            return None
        models = leading_models(blocks, base, singles)
    on_progress(lambda: _compared(blocks, compared_base, models))
    with running(Stage.PAIRS):
        both = pairs(blocks, base, one_per_families(models), library, criteria)
    narrow = with_narrower_transitions(blocks, [*models, *both])
    compared = _compared(blocks, compared_base, [*models, *narrow, *both])
    inside = _unless_runs_disagree(_unless_leader_diverges(compared, blocks), blocks)
    on_progress(lambda: inside)
    if inside is not compared:  # the comparison within the library is incomplete, or the base is another one
        return inside
    with running(Stage.OUTSIDE):
        return _with_law_outside(inside, library, blocks)


def _blocks(
    base: Fit, singles: Sequence[Candidate], validation: Sequence[SampledRun], criteria: Criteria
) -> CommonBlocks:
    """The blocks by the residuals of the single effect with the least chi-square, else of the base.

    Effects that are disturbances, and those whose simulation of the validation runs diverges, are passed over.
    """
    for found in sorted((c.fit for c in singles), key=lambda found: found.chi2):
        with suppress(InputError):
            blocks = CommonBlocks(found, validation, criteria)
            if not blocks.is_disturbance(found):
                return blocks
    return CommonBlocks(base, validation, criteria)


def _compared(blocks: CommonBlocks, compared_base: ComparedModel, models: Sequence[ComparedModel]) -> Comparison:
    """The comparison of the base with models that are evaluated on the same blocks."""
    covariances = {id(m): blocks.covariance(m.fit) for m in models}
    simpler = [m.fit for m in (compared_base, *models)]
    least = blocks.criteria.value_errors
    errors = {id(m): adjusted_errors(m.fit, standard_errors(covariances[id(m)]), simpler, least) for m in models}
    counts = (len(blocks.blocks), len(blocks.validation_blocks))
    motion = _motion_mean_square(blocks.validation or compared_base.fit.runs, blocks.scale)
    # Constant outputs leave the motion: no flexible model leaves more, however far the compared models are from it.
    flexible = min(_flexible_mean_square(compared_base, models, blocks), motion)
    result = outcome(compared_base, models, flexible, motion, counts, errors, blocks.criteria)
    for model in models:
        model.fit.sandwich = covariances[id(model)]
    of_families = {m.families: m for m in (*one_per_families(models), *result.members)}
    listed = sorted(of_families.values(), key=lambda m: m.losses.mean())
    return Comparison(result, compared_base, listed, flexible, motion, counts)


def _unless_leader_diverges(compared: Comparison, blocks: CommonBlocks) -> Comparison:
    """The comparison; `unknown` where a model with clearly less loss on the fitted runs than the named one could not be
    simulated on all runs, so that the comparison is incomplete. A model that contains what is named is no rival."""
    if compared.outcome.verdict == "none":
        return compared
    members = compared.outcome.members or [compared.base]
    least = min((m.fitted_losses for m in members), key=np.mean)
    of_members = [m.families for m in members]
    named = frozenset.intersection(*of_members)
    for found in blocks.not_simulated:
        families = frozenset(effect.family for effect in found.model.effects)
        losses = blocks.fitted_losses(found)
        if (
            losses is None
            or low_of_mean(least - losses) <= 0
            or families in of_members
            or (named and named <= families)
            or blocks.is_undetermined(found, [compared.base.fit])
        ):
            continue
        return _withheld(compared, (
            f"No effect is named: with {' and '.join(sorted(families))} the loss on the fitted runs is clearly less "
            f"(mean logarithmic loss {losses.mean():.3g}, of the best other model {least.mean():.3g}), "
            f"but the simulation diverges on the {'validation' if blocks.validation else 'fitted'} runs."
        ))  # fmt: skip
    return compared


def _unless_runs_disagree(compared: Comparison, blocks: CommonBlocks) -> Comparison:
    """The comparison; `unknown`, with the value that differs, where fitted and validation runs disagree on the base."""
    found = compared.outcome
    if found.verdict == "none":
        return compared
    best = found.best if found.members else found.nearest or compared.base
    sentence = disagreement(compared.base, best, compared.flexible_mean_square, blocks)
    return _withheld(compared, sentence, sentence) if sentence else compared


def _with_law_outside(compared: Comparison, library: Sequence[type[Effect]], blocks: CommonBlocks) -> Comparison:
    """The comparison, with the law outside the library that is sufficient in place of what is named, tied or nearest;
    nothing is named then.

    A law is not outside the library where one of its effects closes as much, as one of the user with the same term.
    """
    found, base = compared.outcome, compared.base
    if found.verdict == "none" or len(blocks.blocks) < blocks.criteria.fewest_fitted_blocks:
        return compared
    selected = found.best if found.members else found.nearest or base
    laws = laws_outside_library(library, failed=not found.members)
    flexible, equal = compared.flexible_mean_square, blocks.criteria.equal_share
    law = sufficient_law(selected, base, laws, flexible, blocks)
    if law is None or any(closes_as_much(m, law, base, flexible, equal) for m in compared.models):
        return compared
    law.fit.sandwich = blocks.covariance(law.fit)
    share, of_selected = (closed_share(base.reported, m.reported, flexible).share for m in (law, selected))
    inside = effects_of(selected) or "the base"
    ahead = "The missing effect is outside the library."
    if of_selected > share - equal:
        ahead = f"The data do not decide between {inside} and a law outside the library, which has fewer parameters."
    withheld = _withheld(compared, (
        f"{ahead} {with_values(law)} This law closes {share:.0%} of the closable misfit, and is sufficient in place of "
        f"{inside} (mean logarithmic loss {law.losses.mean():.3g} for {selected.losses.mean():.3g})."
    ))  # fmt: skip
    outcome = replace(withheld.outcome, standing=withheld.outcome.standing | {id(law): MEMBER})
    models = sorted([*compared.models, law], key=lambda m: m.losses.mean())
    return replace(withheld, outcome=outcome, models=models, law=law)


def _withheld(compared: Comparison, sentence: str, disagreement: str = "") -> Comparison:
    """The comparison with the verdict `unknown`, for the reason in a sentence."""
    found = compared.outcome
    unknown = replace(
        found,
        verdict="unknown",
        best=compared.base,
        members=[],
        sentences=[*found.sentences, sentence],
        standing=found.standing | dict.fromkeys(map(id, found.members), WITHHELD),
        disagreement=disagreement,
    )
    return replace(compared, outcome=unknown)


def _flexible_mean_square(base: ComparedModel, models: Sequence[ComparedModel], blocks: CommonBlocks) -> float:
    """The mean square [1] after a flexible regression on the residuals of the base or of the best model, the lesser."""
    best = min((base, *models), key=lambda m: float(m.out_of_sample.mean()))
    mean_squares = [float(best.out_of_sample.mean())]
    for model in (base, best):
        with suppress(InputError):  # it cannot be simulated without the noise of an imposed motion
            evaluated = model.validated or model.fit
            runs = [run.with_densities(run.densities, "flexible_model") for run in evaluated.runs]
            mean_squares.append(flexible_mean_square(replace(evaluated, runs=runs), blocks.scale))
    return min(mean_squares)


def _motion_mean_square(runs: Sequence[SampledRun], scale: np.ndarray) -> float:
    """The mean square [1] of the runs' outputs about their means in each segment, each over its scale (outputs,)."""
    return float(np.mean([np.mean(run.motion_variance / scale**2) for run in runs]))
