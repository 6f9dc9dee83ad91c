"""The gap workflow on any component: base fitted from afar, noise found, effects of its own elements against each other.

The noise rests on the best model so far (see `flexible`), so a verdict that changes the model is reached again with
the noise that is left beside it.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fmus.effects import Effect
from fmus.effects.places import laws_at
from fmus.errors import InputError
from identification.gap.data.noise_sources import known_noise
from identification.gap.data.sampled import Sampled, excited, prepare_sampled
from identification.gap.data.told import KINDS, SMOOTHER
from identification.gap.models.free_start import FreeStart
from identification.gap.naming.begin import begin, equal_noise
from identification.gap.naming.common_factor import common_factor
from identification.gap.naming.competing import compete
from identification.gap.naming.decide import FAR_FROM_NOISE, Verdict, decide
from identification.gap.naming.fitted import Fit
from identification.gap.naming.fitting import fit
from identification.gap.naming.one_frequency import not_told_apart
from identification.gap.stands.component_test import ComponentTest
from identification.recordings import Recording
from identification.sampling import white_noise

ROUNDS = 3
MOST_MISSED, FAST = 0.2, 1.5  # share of the motion that slow noise may be; fast noise is this much larger than its estimate
ZERO = 0.3  # of what an input varies by (rms), by which its zero may be off
STEADY = 0.1  # change of the noise, relative, below which a verdict stands


@dataclass(frozen=True)
class Investigation:
    """The verdict, whose held-out runs have the noise of the fitted ones, with the test as it was scaled.

    factor is that by which the base came out from where it started (see `common_factor`); with another than 1 nothing is named.
    missed is the share of the measured motion that the best model misses; beyond MOST_MISSED it is no noise.
    kept are inertias that the runs do not tell from a stiffness, and that keep their values.
    """

    verdict: Verdict
    test: ComponentTest
    factor: float = 1.0
    missed: float = 0.0
    kept: tuple[str, ...] = ()


def investigate(test: ComponentTest, runs: Sequence[Sampled], more_effects: Sequence[type[Effect]] = (), given: Mapping[str, float] | None = None,
                so_far: Callable[[Verdict], None] = lambda verdict: None, holdout: Sequence[Recording] = (),
                library: Sequence[type[Effect]] = ()) -> Investigation:  # fmt: skip
    """The verdict on runs of a component, with the laws of mechanics at its elements (or a library) and a user's own effects.

    given holds known deviations of outputs by name; so_far is told what is known already at every stage;
    held-out recordings can only take a name back. Raises InputError where the base cannot be fitted.
    """
    test = test.with_zeros(_zeros(runs))
    component, model = test.component, FreeStart(test)
    found = begin(model, runs)
    kept = not_told_apart(found)
    if kept and len(kept) < len(test.free):
        test = replace(test, free=tuple(f for f in test.free if f.name not in kept))
        model = FreeStart(test)
        found = begin(model, [replace(run, test=test, guess={}) for run in runs])
    found = fit(model, equal_noise(found.runs, found), found.x)
    deflection, rate = largest_motion(found)
    test = replace(test, component=test.component.with_values(**_values(found))).scaled(deflection, rate)
    library = [*(library or laws_at(test.component, rate, _largest(runs, test.driven), _largest(runs, test.outputs))), *more_effects]
    model = FreeStart(test)
    base = fit(model, [_between_samples(model, run) for run in known_noise(found.runs, given or {})], model.start())
    so_far(Verdict("unknown", base, base))
    known: list[Fit] = []
    ready = _beside_the_best(base, library, known)
    verdict, held = Verdict("unknown", base, base), [prepare_sampled(r, test) for r in holdout]
    for first in (True, *(False,) * (ROUNDS - 1)):
        try:
            verdict = decide(model, ready, library, _like(held, ready[0]), so_far if first else _untold, known=known)  # a later round knows less while it lasts
        except InputError:  # with less noise the best of the last round cannot be simulated well enough: its verdict stands
            break
        so_far(verdict)
        known.append(verdict.best)
        before, ready = ready, list(verdict.best.runs)
        if _change(before, ready) < STEADY:
            break
    if verdict.verdict == "named" and _doubtful(verdict, library, bool(held)):
        verdict = replace(verdict, verdict="unknown", effects=[], tied=[], open_form=False)
    factor = common_factor(component, _values(verdict.best)) if excited(runs) else 1.0
    if factor != 1.0 and verdict.verdict != "none":
        verdict = replace(verdict, verdict="unknown", effects=[], tied=[], open_form=False)
    missed = _missed(verdict.best)
    if missed > MOST_MISSED and verdict.verdict == "none":
        verdict = replace(verdict, verdict="unknown")
    with suppress(InputError):  # else they stay as they were compared with the noise of the last round
        verdict.held_out = verdict.on(_like(held, verdict.best.runs[0]))
    return Investigation(verdict, test, factor, missed, tuple(kept))


def _untold(verdict: Verdict) -> None:
    """Tells nobody."""


def _like(held: Sequence[Sampled], fitted: Sampled) -> list[Sampled]:
    """Held-out runs with the noise of a fitted one, and inputs joined as there."""
    return [run.with_told(fitted.kind).with_densities(fitted.densities, fitted.noise_source) for run in held]


def _between_samples(model: FreeStart, run: Sampled) -> Sampled:
    """The run with what is not known of its inputs between their samples as noise."""
    if run.kind != KINDS[0]:
        return run
    one, other = (model.reduced(r, model.start())[0] for r in (run, run.with_told(SMOOTHER)))
    return run.with_unsure((one - other) * run.deviation)


def _beside_the_best(base: Fit, library: Sequence[type[Effect]], known: list[Fit]) -> list[Sampled]:
    """The runs with the noise beside the best single effect: a base that is far off has residuals that no filter explains.

    What is fitted is added to `known`.
    """
    for candidate in compete(base, library, known=known):
        with suppress(InputError):  # of one that was simulated well nowhere
            return _beside(candidate.fit)
    return _beside(base)


def _beside(found: Fit) -> list[Sampled]:
    """The runs of a fit with the noise beside it."""
    return [found.model.with_noise_beside(run, found.of_run(i)) for i, run in enumerate(found.runs)]


def _values(found: Fit) -> dict[str, float]:
    model: Any = found.model
    values = model.values(found.shared)
    return {n: float(np.clip(values[n], found.model.component.table[n].min, found.model.component.table[n].max)) for n in found.model.base}


def largest_motion(found: Fit) -> tuple[float, float]:
    """The largest deflection and rate of the component's first element in the runs."""
    sizes = []
    model: Any = found.model
    for index, run in enumerate(found.runs):
        _, deflections, rates, _ = model.traced(run, found.of_run(index))
        if deflections:
            sizes.append((np.quantile(np.abs(deflections[0]), 0.999), np.quantile(np.abs(rates[0]), 0.999)))
    return tuple(float(max(s)) for s in zip(*sizes, strict=True)) if sizes else (1.0, 1.0)  # type: ignore[return-value]


def _largest(runs: Sequence[Sampled], names: Sequence[str]) -> dict[str, float]:
    """The largest values of what was recorded, without what is always zero."""
    levels = {n: max(float(np.quantile(np.abs(run.recording[n]), 0.999)) for run in runs) for n in names}
    return {n: level for n, level in levels.items() if level > 0}


def _zeros(runs: Sequence[Sampled]) -> dict[str, float]:
    """By how much what was told to a component may be off."""
    told = {n: max(float(np.std(run.recording[n])) for run in runs) for n in runs[0].test.inputs}
    return {n: ZERO * deviation for n, deviation in told.items() if deviation > 0}


def _doubtful(verdict: Verdict, library: Sequence[type[Effect]], confirmed: bool) -> bool:
    """Whether a name is far from the noise and no held-out run confirms it, or its form is open in a family that has no other.

    One body more takes up much of anything.
    """
    forms = sum(effect.family == verdict.effects[0].family for effect in library)
    return (verdict.best.reduced > FAR_FROM_NOISE and not confirmed) or (verdict.open_form and forms == 1)


def _missed(found: Fit) -> float:
    """The largest share of an output (rms) that the model misses, over what fast noise in it explains."""
    model: Any = found.model
    shares = []
    for index, run in enumerate(found.runs):
        left = np.std(model.traced(run, found.of_run(index))[0], axis=0)
        noise = np.array([white_noise(y) for y in run.measured.T])
        shares += list(np.sqrt(np.maximum(left**2 - (FAST * noise) ** 2, 0.0)) / np.std(run.measured, axis=0))
    return float(max(shares))


def _change(before: Sequence[Sampled], after: Sequence[Sampled]) -> float:
    """By how much the deviations changed, relative, in the mean over the cosines."""
    return max(float(np.mean(np.abs(np.log(b.deviation / a.deviation)))) for a, b in zip(before, after, strict=True))
