"""Effects added to a fit: base and effects are fitted together, from several starts, many effects in parallel."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from fmus.effects import Effect
from fmus.support.deadline import time_is_up
from fmus.support.errors import InputError
from fmus.support.parallel import parallel_map
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import Candidate, adequate, one_each, ranked
from motofmi.gap.estimation.fit_result import Fit, PortableFit, initial_guesses, with_initial_guesses
from motofmi.gap.estimation.fitting import fit, fit_or_none, has_vanished_parameter, with_sensitive_base
from motofmi.gap.estimation.screening import Signature, far_from_data
from motofmi.gap.models.any_model import AnyModel

PROMISED = 0.5  # share of the screened gain (all of it where the base fits badly) below which further starts are tried
SMALLER = 0.2  # factor on the magnitude of an effect for a second start
OUT_OF_REACH = 4.0  # ratio of chi-square to the one to be reached above which no further start is tried
FAR_START = 1e4  # ratio of chi-square to that without the effect above which a start is not used: it rarely converges


def fit_each(found: Fit, signatures: Sequence[Signature], so_far: Sequence[Candidate], beat: float,
             known: Sequence[Fit], criteria: Criteria) -> list[Candidate]:  # fmt: skip
    """The candidates of these signatures, fitted as far as they may compete with the candidates so far; after a
    deadline not fitted."""
    beat = (
        min((beat, *(c.fit.chi2 for c in so_far if c.fitted and adequate(c.fit, criteria))))
        + criteria.clear_lead_delta_bic
    )
    known = [*known, *sorted((c.fit for c in so_far if c.fitted), key=lambda other: -other.chi2)]
    portable_fits = parallel_map(
        lambda signature: best_portable_fit(found, signature, beat, known, criteria), signatures, "fitting effects"
    )
    return [
        candidate_of(found, signature, portable) for signature, portable in zip(signatures, portable_fits, strict=True)
    ]


def fit_from_further_starts(found: Fit, signatures: Sequence[Signature], beat: float) -> list[Candidate]:
    """The candidates of further signatures of effects that have been fitted, each from its own start alone; a fit that
    cannot reach the chi-square `beat` is ended early. After a deadline they are not fitted."""

    def portable_fit(signature: Signature) -> PortableFit | None:
        if time_is_up():
            return None
        model = found.model.with_added_effects(signature.effect)
        start, guesses, _ = next(_starts(found, model, signature, [], False))
        with suppress(InputError):  # this start cannot be simulated
            runs = with_initial_guesses(found.runs, guesses)
            return PortableFit.of(fit(model, runs, start, beat=beat, most=_most(found, beat)))
        return None

    portable_fits = parallel_map(portable_fit, signatures, "fitting effects")
    return [
        candidate_of(found, signature, portable) for signature, portable in zip(signatures, portable_fits, strict=True)
    ]


def best_portable_fit(
    found: Fit, signature: Signature, beat: float, known: Sequence[Fit], criteria: Criteria
) -> PortableFit | None:
    """The best fit of an effect from several starts; None where none can be simulated, or after a deadline."""
    return None if time_is_up() else PortableFit.of(_best_fit(found, signature, beat, known, criteria))


def candidate_of(found: Fit, signature: Signature, portable: PortableFit | None) -> Candidate:
    """The candidate of a signature from its fit in another process; not fitted where there is none."""
    return _unpacked(found, signature.effect, portable) or Candidate.promised(found, signature)


def fitted_to_the_end(found: Fit, candidates: Sequence[Candidate], criteria: Criteria) -> list[Candidate]:
    """The ranked candidates with all adequate rivals of an adequate best fitted to convergence, since slow
    fits were ended early."""
    best = candidates[0]
    stopped_early: list[Candidate] = []
    if adequate(best.fit, criteria):
        behind = best.fit.chi2 + criteria.clear_lead_delta_bic
        stopped_early = [
            c for c in one_each(candidates) if c.fitted and adequate(c.fit, criteria) and c.fit.chi2 > behind
        ]
    portable_fits = parallel_map(
        lambda c: PortableFit.of(fit_or_none(c.fit.model, c.fit.runs, c.fit.x)),
        stopped_early,
        "fitting rivals to their end",
    )
    ended = [
        _unpacked(found, c.effect, portable) or c for c, portable in zip(stopped_early, portable_fits, strict=True)
    ]
    return ranked([*ended, *(c for c in candidates if not any(c is other for other in stopped_early))])


def _unpacked(found: Fit, effect: type[Effect], portable: PortableFit | None) -> Candidate | None:
    """The candidate from the fit of another process; None where no start could be simulated, or the fit is
    worse than without it."""
    if portable is None or portable.chi2 > found.chi2:
        return None
    return Candidate.gained(found, effect, portable.on(found.model.with_added_effects(effect), found.runs))


def _best_fit(found: Fit, signature: Signature, beat: float, known: Sequence[Fit], criteria: Criteria) -> Fit | None:
    """The best fit from several starts, the most promising first; None where none can be simulated."""
    model = found.model.with_added_effects(signature.effect)
    far = far_from_data(found)
    at_bound = has_vanished_parameter(found)
    # no start is known to be better than another
    blind = at_bound and signature.gain < criteria.first_effect_delta_bic
    promised = np.inf if blind else signature.gain * (1.0 if far else PROMISED)
    least = contained(model, known)
    insufficient = not adequate(found, criteria)  # otherwise an adequate fit need not be an improvement
    best = None
    for start, kept, settled in _starts(found, model, signature, known, far or blind):
        try:
            fitted = fit(
                model,
                with_initial_guesses(found.runs, kept),
                start,
                beat=beat if best is None else min(beat, best.chi2),
                most=_most(found, beat),
            )
        except InputError:  # this start cannot be simulated
            continue
        best = fitted if best is None or fitted.chi2 < best.chi2 else best
        as_promised = found.chi2 - best.chi2 > promised and not (
            far and best.chi2 > beat
        )  # screened gains are too small where the base fits badly
        as_promised &= best.chi2 < least
        out_of_reach = not at_bound and OUT_OF_REACH * beat < fitted.chi2 < found.chi2
        enough = as_promised or (insufficient and adequate(best, criteria))
        if enough or out_of_reach or (settled and fitted.chi2 > beat) or time_is_up():
            break
    if best is None or best.chi2 > found.chi2:
        with suppress(InputError):
            best = fit(model, found.runs, _without_effect(found, model, signature), beat=beat)
    return best


def _most(found: Fit, beat: float) -> float:
    """The largest chi-square of a start of an effect that has to reach `beat`."""
    return FAR_START * found.chi2 if np.isfinite(beat) else np.inf


def _starts(
    found: Fit, model: AnyModel, signature: Signature, known: Sequence[Fit], far: bool
) -> Iterator[tuple[np.ndarray, list[Any], bool]]:
    """Starts with initial guesses of the runs: the same effect in a known fit (final), another form, its
    signature, the given values."""
    shared, base, own = (
        len(found.model.names),
        with_sensitive_base(found),
        signature.start,
    )  # parameters that the effect needs may have vanished in the base
    first = np.concatenate([base[:shared], own, base[shared:]])
    alike = [other for other in known if _families(other.model) == _families(model)]
    same = [
        other
        for other in alike
        if set(other.model.effects) == set(model.effects) and other.chi2 < contained(model, known)
    ]
    yield from ((as_found(model, other, first), initial_guesses(other.runs), True) for other in same[-1:])
    if not same:
        yield from ((as_found(model, other, first), initial_guesses(other.runs), False) for other in alike[-1:])
    yield first, initial_guesses(found.runs), False
    if signature.effect.prior is None:
        smaller = _smaller(model, signature)
        yield np.concatenate([base[:shared], smaller, base[shared:]]), initial_guesses(found.runs), False
    if far or signature.effect.prior is not None:  # a base that compensates for a large effect may be a poor start
        yield (
            np.concatenate([model.start()[: len(model.base)], first[len(model.base) : shared], own]),
            initial_guesses(found.runs),
            False,
        )


def contained(model: AnyModel, known: Sequence[Fit]) -> float:
    """The least chi-square of fits with forms that a model's form contains; its own can only be smaller."""
    return min(
        (
            other.chi2
            for other in known
            if _families(other.model) == _families(model) and set(other.model.own) < set(model.own)
        ),
        default=np.inf,
    )


def _families(model: AnyModel) -> list[str]:
    return sorted(effect.family for effect in model.effects)


def as_found(model: AnyModel, like: Fit, start: np.ndarray) -> np.ndarray:
    """A start with the values that parameters of the same names have in another fit."""
    values = dict(zip(like.model.names, like.x, strict=False))
    return np.concatenate(
        [[values.get(n, x) for n, x in zip(model.names, start, strict=False)], like.x[len(like.model.names) :]]
    )


def _smaller(model: AnyModel, signature: Signature) -> np.ndarray:
    """The signature's start with smaller magnitudes, since the linear estimate may be far too large."""
    start, first = signature.start.copy(), len(model.own) - len(signature.start)
    start[[i - first for i in model.sizes if i >= first]] *= SMALLER
    return start


def _without_effect(found: Fit, model: AnyModel, signature: Signature) -> np.ndarray:
    """A start with the fit and the least magnitude of the effect, from which no fit is worse than without it."""
    shared = len(found.model.names)
    own = without_magnitudes(model, np.concatenate([found.shared, signature.start]), len(found.model.own))[shared:]
    return np.concatenate([found.x[:shared], own, found.x[shared:]])


def without_magnitudes(model: AnyModel, x: np.ndarray, first: int = 0) -> np.ndarray:
    """The vector x of a model with the least magnitudes of effects, of all parameters of effects from `first` on."""
    x = x.copy()
    for i in model.sizes:
        if i >= first:
            x[len(model.base) + i] = max(model.rows[i].min, 0.0)
    return x
