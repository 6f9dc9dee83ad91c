"""The single effects that a comparison considers: every form of every effect of a library.

Effects are ordered by their mean logarithmic loss on blocks, not by chi-square: a single run with a large misfit
dominates chi-square and hides the gain of an effect in all other runs.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TypeVar

import numpy as np

from fmus.effects import Effect
from fmus.support.deadline import time_is_up
from fmus.support.errors import InputError
from fmus.support.parallel import parallel_map
from motofmi.gap.comparison.block_losses import standard_error
from motofmi.gap.comparison.compared_model import CommonBlocks, ComparedModel
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import Candidate
from motofmi.gap.estimation.effect_fit import as_found, fit_each, without_magnitudes
from motofmi.gap.estimation.equation_error import EquationErrorFit
from motofmi.gap.estimation.fit_result import (
    Fit,
    PortableFit,
    initial_guesses,
    or_from_recorded_motion,
    with_initial_guesses,
)
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.friction_transition import has_transition, worth_narrowing
from motofmi.gap.estimation.screening import Signature, screen

Key = TypeVar("Key")

LEADING_FAMILIES = 5  # families that are compared
FITTED_FIRST = 4  # effects with the largest screened gain, that are fitted before the others
# Ratio of chi-square to that of the best of them above which another effect need not be fitted to the end: a model with
# three times the mean square on every block is not in the confidence set.
FAR_BEHIND = 3.0
# The same, of a family, above which its further forms need not be fitted.
OUT_OF_REACH = 30.0
CLEARLY_BEHIND = 5.0  # standard errors of the mean loss above the best one from which a model is not compared further


def single_effects(
    base: Fit, library: Sequence[type[Effect]], criteria: Criteria, starts: Sequence[EquationErrorFit] = ()
) -> list[Candidate]:
    """The forms of the library that are not flexible and reduce chi-square, each fitted with the base.

    The effects with the least equation error are fitted from its values, `starts`, and all effects from the screened
    ones; of two fits the one with less chi-square is kept. Those with the largest screened gain come first; fits of the
    others end where they cannot come near them. Effects with states of their own do not end others, since their free
    initial states can reduce the misfit without a magnitude, and their simulations are the slowest: they are fitted
    last. Of a family of such effects further forms are fitted where the simplest one is not far behind, and of any
    family those at several elements at once: with friction in both joints the base compensates for most of it, and the
    screened gain is hardly larger than with one of them.
    """
    plain = [effect for effect in library if not effect.flexible]
    at_one, at_several = ([e for e in plain if bool(e.at_one) is several] for several in (False, True))
    known = _from_equation_error(base, starts)
    signatures = [s for s in screen(base, at_one, keep=1) if s.gain > 0]
    signatures.sort(key=lambda s: (s.effect.has_states(), -s.gain))
    further = _further_forms(signatures)
    order = [s for s in signatures if s not in further]
    found = fit_each(base, order[:FITTED_FIRST], [], base.chi2, [], criteria)
    best = min((c.fit.chi2 for c in (*known, *found) if c.fitted and not c.effect.has_states()), default=np.inf)
    beat = min(base.chi2, FAR_BEHIND * best)
    first, others = _on_which_others_depend(order[FITTED_FIRST:], further)
    found += fit_each(base, first, [], beat, [], criteria)
    near = {c.family for c in found if c.fit.chi2 < OUT_OF_REACH * best}
    further = [s for s in further if s.effect.family in near]
    of_near = [effect for effect in at_several if effect.family in near]
    further += [s for s in screen(base, of_near, keep=1) if s.gain > 0]
    found += fit_each(base, [*further, *others], [], beat, [], criteria)
    every = list(dict.fromkeys([*(s.effect for s in (*order, *further)), *plain]))
    place = {effect: i for i, effect in enumerate(every)}
    of_effects: dict[type[Effect], Candidate] = {}
    for c in sorted((c for c in (*known, *found) if c.fitted), key=lambda c: c.fit.chi2):
        of_effects.setdefault(c.effect, c)
    return sorted(of_effects.values(), key=lambda c: place[c.effect])


def _from_equation_error(base: Fit, starts: Sequence[EquationErrorFit]) -> list[Candidate]:
    """The effects that are not far behind in equation error, fitted from its values; none where the base is not
    either.

    Where a model diverges from the states of the base, it is simulated from the recorded motion.
    """
    least = min((start.chi2 for start in starts), default=0.0)
    near = [start for start in starts if start.chi2 < FAR_BEHIND * least]
    near = near if all(start.effect for start in near) else []

    def fit_one(start: EquationErrorFit) -> PortableFit | None:
        model, x = start.on(base)
        with suppress(InputError):  # it cannot be simulated with these values
            if not time_is_up():
                return PortableFit.of(
                    or_from_recorded_motion(lambda runs: fit(model, runs, x, beat=base.chi2), base.runs)
                )
        return None

    fits = parallel_map(fit_one, near, "fitting from equation error")
    return [
        Candidate.gained(base, start.effect, portable.on(start.on(base)[0], base.runs))
        for start, portable in zip(near, fits, strict=True)
        if start.effect and portable is not None and portable.chi2 < base.chi2
    ]


def _on_which_others_depend(
    signatures: Sequence[Signature], further: Sequence[Signature]
) -> tuple[list[Signature], list[Signature]]:
    """Signatures to be fitted before further forms of their families, and those to be fitted together with these.

    The first half of those without further forms is fitted before, last of all: short fits keep the processors busy
    while the longest ones end.
    """
    families = {s.effect.family for s in further}
    needed = [s for s in signatures if s.effect.family in families]
    free = [s for s in signatures if s.effect.family not in families]
    half = len(free) // 2 if further else len(free)
    return [*needed, *free[:half]], free[half:]


def _further_forms(signatures: Sequence[Signature]) -> list[Signature]:
    """The forms with states that are not the ones with the fewest parameters of their family."""
    simplest: dict[str, Signature] = {}
    for s in sorted(signatures, key=lambda s: len(s.effect.free_parameters())):
        simplest.setdefault(s.effect.family, s)
    return [s for s in signatures if s.effect.has_states() and s is not simplest[s.effect.family]]


def leading_models(blocks: CommonBlocks, base: Fit, singles: Sequence[Candidate]) -> list[ComparedModel]:
    """The forms of the leading families, evaluated on all blocks.

    Effects that are clearly behind the leading one on fitted blocks, and on all together, are left out: they cannot be
    in the model confidence set. A disturbance (`CommonBlocks.is_disturbance`) leads nothing; where it has the least
    loss it is the last of the models. A form is also fitted from the best form of its family, which it may contain or
    be contained in.
    """
    fits_of = {id(c): c.fit for c in singles}
    order, near = leading(blocks, fits_of)
    fitted = {id(c): replace(c, fit=fits_of[id(c)]) for c in singles}
    best = {fitted[key].family: key for key in reversed(order) if not blocks.is_disturbance(fits_of[key])}
    others = [key for family, key in best.items() if family not in {fitted[key].family for key in near}]
    if near and blocks.validation:
        near += not_behind_on_all(blocks, fits_of, near[0], others)
    families = list(dict.fromkeys(fitted[key].family for key in near))[:LEADING_FAMILIES]
    fits = _in_all_forms([[fitted[key] for key in order if fitted[key].family == family] for family in families], base)
    withheld = [fitted[key].fit for key in order[:1] if key not in near]
    return blocks.refined_and_evaluated([*fits, *withheld], "comparing effects")


def with_narrower_transitions(blocks: CommonBlocks, models: Sequence[ComparedModel]) -> list[ComparedModel]:
    """The models with dry friction again, in the transition with which each fits best (see `friction_transition`);
    without those whose transition is not worth narrowing."""
    wide = [m.fit for m in models if has_transition(m.effects)]
    best = min(wide, key=lambda found: found.chi2, default=None)
    narrow = worth_narrowing(best, wide, len(blocks.blocks)) if best else []
    return blocks.refined_and_evaluated(narrow, "comparing dry friction")


def leading(blocks: CommonBlocks, fits: dict[Key, Fit]) -> tuple[list[Key], list[Key]]:
    """The keys of fits in the order of their mean loss on fitted blocks, and those that are not clearly behind the best
    one that is no disturbance.

    The best one is refined before it is judged; the refined fit takes its place in fits.
    """
    losses = {key: loss for key, found in fits.items() if (loss := blocks.fitted_losses(found)) is not None}
    order = sorted(losses, key=lambda key: losses[key].mean())
    real: list[Key] = []
    for key in order:
        if not real:
            fits[key] = blocks.refined(fits[key])
        if not blocks.is_disturbance(fits[key]):
            real.append(key)
    return order, [key for key in real if not clearly_behind(losses[key], losses[real[0]])]


def not_behind_on_all(blocks: CommonBlocks, fits: dict[Key, Fit], leader: Key, others: Sequence[Key]) -> list[Key]:
    """The keys of others that are not far behind the leader on the fitted blocks, and not clearly behind it on fitted
    and validation blocks together.

    A few fitted runs with similar inputs may not show the difference of two effects that the validation runs show.
    """
    fitted = {key: blocks.fitted_losses(fits[key]) for key in (leader, *others)}
    levels = {key: loss.mean() for key, loss in fitted.items() if loss is not None}
    near = [key for key in others if key in levels and levels[key] < levels[leader] + np.log(FAR_BEHIND)]
    if not near:
        return []

    def losses_of(key: Key) -> np.ndarray | None:
        model = blocks.evaluated(fits[key])
        return None if model is None else model.losses

    best, *losses = parallel_map(losses_of, [leader, *near], "validating effects")
    if best is None:
        return []
    return [k for k, loss in zip(near, losses, strict=True) if loss is not None and not clearly_behind(loss, best)]


def clearly_behind(losses: np.ndarray, best: np.ndarray) -> bool:
    """Whether the mean of losses (blocks,) exceeds that of the best by more than `CLEARLY_BEHIND` standard errors."""
    difference = losses - best
    return bool(difference.mean() > CLEARLY_BEHIND * standard_error(difference))


def _in_all_forms(families: Sequence[Sequence[Candidate]], base: Fit) -> list[Fit]:
    """The fits of the forms of each family, each also from the values of another form.

    A form that contains a better one starts where it is equal to that one, so that it cannot end in a worse minimum.
    Of the others the best one starts from the second, and all others from the best.
    """
    forms: list[Candidate] = []
    pairs: list[tuple[int, Candidate]] = []  # the place of a form, and the one from whose values it starts
    for family in families:
        alike = sorted(family, key=lambda c: c.fit.chi2)
        pairs += [(len(forms), second) for second in alike[1:2]]
        for rank, form in enumerate(alike[1:], 1):
            contained = [c for c in alike[:rank] if set(c.fit.model.own) < set(form.fit.model.own)]
            pairs.append((len(forms) + rank, (contained or alike)[0]))
        forms += alike

    def fit_again(pair: tuple[int, Candidate]) -> PortableFit | None:
        form, start = forms[pair[0]], pair[1]
        model, runs = form.fit.model, with_initial_guesses(base.runs, initial_guesses(start.fit.runs))
        own = form.fit.x[: len(model.names)]
        if set(start.fit.model.own) < set(model.own):
            own = without_magnitudes(model, own)
        try:
            return PortableFit.of(fit(model, runs, as_found(model, start.fit, own), beat=form.fit.chi2))
        except InputError:
            return None

    fits = [c.fit for c in forms]
    for (i, _), portable in zip(pairs, parallel_map(fit_again, pairs, "fitting forms"), strict=True):
        if portable is not None and portable.chi2 < fits[i].chi2:
            fits[i] = portable.on(forms[i].fit.model, base.runs)
    return fits
