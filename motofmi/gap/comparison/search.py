"""The contenders of a library: every form of every effect once, then pairs of which the leading effects are the first.

The order of effects is that of their mean logarithmic loss on blocks, not of chi-square: chi-square of a run with a
large misfit hides what an effect does in all others.
"""

from collections.abc import Callable, Sequence

import numpy as np

from fmus.effects import Effect
from fmus.support.errors import InputError
from fmus.support.parallel import parallel_map
from motofmi.gap.comparison.contender import Arena, Contender
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import Candidate
from motofmi.gap.estimation.effect_fit import as_found, fit_each
from motofmi.gap.estimation.fit_result import Fit, PortableFit, initial_guesses, with_initial_guesses
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.screening import screen

LEADING = 5  # families that are compared, and that are tried as the first effect of a pair
CLEARLY = 5.0  # standard errors behind the leading effect from which another one is not compared further
SECONDS = 3  # effects that are fitted on top of each of them


def single_effects(base: Fit, library: Sequence[type[Effect]], criteria: Criteria) -> list[Candidate]:
    """Every form of the library that is not flexible, fitted together with the base; those that gain something."""
    plain = [effect for effect in library if not effect.flexible]
    signatures = [s for s in screen(base, plain, keep=1) if s.gain > 0]
    return [c for c in fit_each(base, signatures, [], np.inf, [], criteria) if c.fitted]


def leading_contenders(
    arena: Arena, base: Fit, singles: Sequence[Candidate]
) -> tuple[Contender | None, list[Contender]]:
    """The base, and the forms of the leading families, compared on all blocks.

    Effects that are clearly behind the leading one on the fitted blocks are left out: they cannot be in the model
    confidence set. A form is also fitted from the best form of its family, which it may contain or be contained in.
    """
    losses = {id(c): loss for c in singles if (loss := arena.fitted_losses(c.fit)) is not None}
    order = sorted((c for c in singles if id(c) in losses), key=lambda c: losses[id(c)].mean())
    alone = arena.contender(base)
    if not order:
        return alone, []
    best = losses[id(order[0])]
    near = [c for c in order if not clearly_behind(losses[id(c)], best)]
    families = list(dict.fromkeys(c.family for c in near))[:LEADING]
    fits = [found for family in families for found in _forms_of(family, order, base)]
    return alone, arena.contenders(fits, "comparing effects")


def clearly_behind(losses: np.ndarray, best: np.ndarray) -> bool:
    """Whether the mean of losses (blocks,) exceeds that of the best by more than CLEARLY standard errors."""
    difference = losses - best
    return bool(difference.mean() > CLEARLY * difference.std(ddof=1) / np.sqrt(len(difference)))


def _forms_of(family: str, order: Sequence[Candidate], base: Fit) -> list[Fit]:
    """The fits of a family's forms, each also from the values of the other form with the least chi-square."""
    forms = sorted((c for c in order if c.family == family), key=lambda c: c.fit.chi2)
    others = list(forms[1:2]) + forms[:1] * (len(forms) - 1)  # what each form starts from

    def again(pair: tuple[Candidate, Candidate]) -> PortableFit | None:
        form, like = pair
        model, runs = form.fit.model, with_initial_guesses(base.runs, initial_guesses(like.fit.runs))
        try:
            return PortableFit.of(fit(model, runs, as_found(model, like.fit, form.fit.x[: len(model.names)])))
        except InputError:
            return None

    made = parallel_map(again, list(zip(forms, others, strict=False)), "fitting forms")
    fits = [c.fit for c in forms]
    for i, portable in enumerate(made):
        if portable is not None and portable.chi2 < fits[i].chi2:
            fits[i] = portable.on(forms[i].fit.model, base.runs)
    return fits


def pairs(arena: Arena, firsts: Sequence[Contender], library: Sequence[type[Effect]], criteria: Criteria,
          so_far: Callable[[], None] = lambda: None) -> list[Contender]:  # fmt: skip
    """Pairs of a leading effect and the effects that gain most on top of it, then the best pair in other forms."""
    fits: dict[frozenset[type[Effect]], Fit] = {}
    plain = [effect for effect in library if not effect.flexible]
    for first in firsts[:LEADING]:
        others = [effect for effect in plain if effect.family not in first.families]
        signatures = sorted(screen(first.fit, others, keep=1), key=lambda s: -s.gain)
        leading = list({s.effect.family: s for s in reversed(signatures) if s.gain > 0}.values())[::-1][:SECONDS]
        for candidate in fit_each(first.fit, leading, [], np.inf, [], criteria):
            effects = frozenset(candidate.fit.model.effects)
            if candidate.fitted and (effects not in fits or candidate.fit.chi2 < fits[effects].chi2):
                fits[effects] = candidate.fit
        so_far()
    losses = {effects: loss for effects, found in fits.items() if (loss := arena.fitted_losses(found)) is not None}
    order = sorted(losses, key=lambda effects: losses[effects].mean())
    order = [effects for effects in order if not clearly_behind(losses[effects], losses[order[0]])]
    contenders = arena.contenders([fits[effects] for effects in order[:LEADING]], "comparing pairs")
    if not contenders:
        return []
    best = min(contenders, key=lambda c: c.losses.mean())
    return contenders + arena.contenders(
        _in_other_forms(best, firsts, plain, fits, criteria), "comparing forms of a pair"
    )


def _in_other_forms(best: Contender, firsts: Sequence[Contender], plain: Sequence[type[Effect]],
                    fits: dict[frozenset[type[Effect]], Fit], criteria: Criteria) -> list[Fit]:  # fmt: skip
    """The pair with other forms of one effect, each on top of the other effect."""
    found = []
    for kept in best.effects:
        alone = next((c for c in firsts if c.effects == (kept,)), None)
        replaced = next(e for e in best.effects if e is not kept)
        forms = [e for e in plain if e.family == replaced.family and frozenset((e, kept)) not in fits]
        if alone is None or not forms:
            continue
        made = fit_each(alone.fit, screen(alone.fit, forms, keep=1), [], np.inf, [], criteria)
        found += [c.fit for c in made if c.fitted]
    return found
