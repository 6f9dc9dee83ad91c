"""Model selection on sampled runs: by chi-square where the residuals of a model are noise, else by comparison.

Where some model leaves only noise, known or estimated, models are selected by chi-square (`noise_rounds`). On real
machines usually none does; the models are then compared on blocks of their residuals (see the package `comparison`).
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

from fmus.effects import Effect
from fmus.support.errors import InputError
from motofmi.gap.comparison.compare import Comparison, compare
from motofmi.gap.comparison.search import single_effects
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import Candidate, noise_is_known, ranked
from motofmi.gap.estimation.equation_error import EquationErrorFit
from motofmi.gap.estimation.fit_result import Fit, or_from_recorded_motion
from motofmi.gap.estimation.fitting import fit, fit_or_none
from motofmi.gap.estimation.initial_fit import CLOSER, equal_noise, in_interpolation_of, unless_held
from motofmi.gap.estimation.stages import Stage, running
from motofmi.gap.preprocessing.sampled_run import SHORTEST_SEGMENT, SampledRun
from motofmi.gap.selection.by_comparison import in_units_of_residuals, verdict_by_comparison, with_remaining_noise
from motofmi.gap.selection.chi_square_conditions import (
    decisive,
    finds_a_law_outside,
    leaves_noise,
    unless_doubtful,
    unless_sufficient,
    unless_unclear,
)
from motofmi.gap.selection.narrower_friction import in_narrower_transition
from motofmi.gap.selection.noise_rounds import OnProgress, select_in_rounds, with_noise_of
from motofmi.gap.selection.result import Verdict
from motofmi.gap.validation.before_after import before_and_after

NOT_ADEQUATE = (
    "The noise follows from {}, and the best single effect is not consistent with it (reduced chi-square {:.3g}): the "
    "effects are compared on blocks of the residuals."
)
SOURCES = {"repeats": "the repeated excitation", "given": "the given standard deviations"}


@dataclass(frozen=True)
class _Singles:
    """The base and the validation runs in shorter segments, the fit with the least chi-square, and all fitted single
    effects."""

    base: Fit
    validation_runs: list[SampledRun]
    best: Fit
    candidates: list[Candidate]


@dataclass(frozen=True)
class Selection:
    """What the models are selected from: a fitted base, effects, and prepared validation runs.

    starts are the fits of base and effects by equation error, the least first; on_progress is called with an
    intermediate verdict after every stage.
    """

    base: Fit
    library: Sequence[type[Effect]]
    starts: Sequence[EquationErrorFit]
    validation_runs: Sequence[SampledRun]
    on_progress: OnProgress
    criteria: Criteria

    def verdict(self) -> Verdict:
        """The verdict by chi-square where some model leaves only noise, else by comparison."""
        found = self._single_effects()
        if (again := in_interpolation_of(found.best, self.base)) is not None:
            search = replace(self, base=again)
            return search._after_single_effects(search._single_effects())
        if (smooth := unless_held(self.base)) is not None:
            search = replace(self, base=smooth)
            others = search._single_effects()
            if search._left(others) < CLOSER * self._left(found):
                return search._after_single_effects(others)
        return self._after_single_effects(found)

    def _left(self, found: _Singles) -> float:
        """What the best single effect leaves of chi-square, in the noise of the base."""
        return self.base.chi2 * found.best.chi2 / found.base.chi2

    @property
    def noise_is_known(self) -> bool:
        return noise_is_known(self.base)

    def _after_single_effects(self, found: _Singles) -> Verdict:
        with running(Stage.NOISE):
            best, continued = found.best, None
            with suppress(InputError):
                continued = or_from_recorded_motion(lambda runs: fit(best.model, runs, best.x), self.base.runs)
            single, known = continued or found.best, [continued] if continued else []
            # The search by chi-square is over the longer segments, over which the best effect must be simulated.
            tried = continued is not None and leaves_noise(continued, self.validation_runs, self.criteria)
        simulated = continued is not None
        if tried:
            verdict = self._by_chi_square(known, continued)
            if decisive(verdict, single, simulated, self.criteria):
                return self._confirmed(verdict)
        scaled, compared = self._comparison(found)
        pairs = [m.fit for m in compared.clear_pairs()] if compared else []
        pairs = [pair for pair in pairs if self._pair_leaves_noise(pair)]
        if not tried and pairs:
            pair = fit_or_none(pairs[0].model, self.base.runs, pairs[0].x)
            known = [*([pair] if pair else []), *known]
            verdict = self._by_chi_square(known, pair)
            tried = True
            if decisive(verdict, single, simulated, self.criteria):
                return self._confirmed(verdict)
        if compared is not None:
            of_blocks = self._decided(scaled, compared)
            # What the search by chi-square withholds is not named by the comparison.
            if tried and of_blocks.verdict == "named" and finds_a_law_outside(verdict):
                return verdict
            return in_known_noise(of_blocks, self.base, single) if self.noise_is_known else of_blocks
        if not tried:
            verdict = self._by_chi_square(known)
        return self._confirmed(verdict)

    def _pair_leaves_noise(self, pair: Fit) -> bool:
        """Whether the residuals of a pair are noise, in the noise of the base's runs where that is known."""
        if self.noise_is_known:
            continued = fit_or_none(pair.model, self.base.runs, pair.x)
            return continued is not None and leaves_noise(continued, self.validation_runs, self.criteria)
        return leaves_noise(pair, self.validation_runs, self.criteria)

    def _by_chi_square(self, known: Sequence[Fit], consistent: Fit | None = None) -> Verdict:
        report = self.on_progress if self.noise_is_known else self._report_unknown
        return select_in_rounds(
            self.base, self.library, self.validation_runs, report, self.criteria, known, consistent
        )

    def _confirmed(self, verdict: Verdict) -> Verdict:
        """The verdict by chi-square, where nothing is against it."""
        if not self.noise_is_known:
            verdict = unless_unclear(unless_sufficient(in_narrower_transition(verdict, self.validation_runs)))
        return unless_doubtful(verdict, self.library, self.validation_runs, self.criteria)

    def _report_unknown(self, verdict: Verdict) -> None:
        """Noise that follows from the result is known at the end only: no name before."""
        conclude = verdict.conclude
        self.on_progress(replace(verdict.as_unknown(), conclude=conclude and (lambda: conclude().as_unknown())))

    def _single_effects(self) -> _Singles:
        """The single effects, fitted in shorter segments, with noise of the size of the residuals."""
        base = _without_known_noise(self.base) if self.noise_is_known else self.base
        shorter = fit(base.model, [in_shorter_segments(run) for run in base.runs], base.x)
        compared_runs = [in_shorter_segments(run) for run in with_noise_of(shorter.runs[0], self.validation_runs)]
        with running(Stage.SINGLE_EFFECTS):
            singles = single_effects(shorter, self.library, self.criteria, self.starts)
            best = min((c.fit for c in singles), key=lambda found: found.chi2, default=shorter)
            self.on_progress(undecided(shorter, compared_runs, self.criteria, singles))
        return _Singles(shorter, compared_runs, best, singles)

    def _comparison(self, found: _Singles) -> tuple[_Singles, Comparison | None]:
        """The single effects with the noise scaled to the residuals of the best, and their comparison."""
        base, singles, runs = in_units_of_residuals(found.best, found.base, found.candidates, found.validation_runs)
        scaled = _Singles(base, runs, found.best, singles)

        def report(known: Callable[[], Comparison]) -> None:
            verdict = undecided(base, runs, self.criteria, singles)
            self.on_progress(replace(verdict, conclude=lambda: self._decided(scaled, known())))

        return scaled, compare(base, singles, self.library, runs, self.criteria, report)

    def _decided(self, found: _Singles, compared: Comparison) -> Verdict:
        return verdict_by_comparison(compared, found.candidates, found.validation_runs, self.criteria)


def undecided(
    base: Fit, validation_runs: Sequence[SampledRun], criteria: Criteria, singles: Sequence[Candidate] = ()
) -> Verdict:
    """The verdict before any decision, `unknown`; concluded, it has the noise of the best fit and its misfit on
    validation runs."""
    candidates = ranked(singles)
    verdict = Verdict(
        "unknown", base, candidates[0].fit if candidates else base, candidates=candidates, criteria=criteria
    )

    def conclude() -> Verdict:
        own, best = with_remaining_noise(verdict.base, verdict.best)
        checked = with_noise_of(best.runs[0], validation_runs)
        return replace(verdict, base=own, best=best, validation_gap=before_and_after(own, best, checked, criteria))

    return replace(verdict, conclude=conclude)


def in_shorter_segments(run: SampledRun) -> SampledRun:
    """The run in segments half as long: the phase error of an incomplete model grows with the length of a segment."""
    longest = max(last - first for first, last in run.segments)
    return run.cut(max(longest // 2, SHORTEST_SEGMENT))


def _without_known_noise(base: Fit) -> Fit:
    """The fit of a base whose runs have noise of the size of its residuals in place of a known one."""
    runs = [run.with_densities(run.densities, "flexible_model") for run in base.runs]
    runs = equal_noise(runs, base)
    return fit(base.model, runs, base.x)


def in_known_noise(compared: Verdict, base: Fit, single: Fit) -> Verdict:
    """The verdict of a comparison, with its fits in the known noise of a base, by which the best single effect is not
    adequate. Each fitted run has its own noise, validation runs have that of the first one."""

    def known(runs: Sequence[SampledRun], noisy: Sequence[SampledRun]) -> list[SampledRun]:
        return [run.with_densities(n.densities, n.noise_source) for run, n in zip(runs, noisy, strict=True)]

    own, best = (
        replace(fit(found.model, known(found.runs, base.runs), found.x, iterations=0), sandwich=found.sandwich)
        for found in (compared.base, compared.best)
    )
    gap = compared.validation_gap
    if gap is not None:
        of_base, of_best = (misfit.fit for misfit in gap)
        checked = known(of_best.runs, base.runs[:1] * len(of_best.runs))
        gap = before_and_after(own, best, checked, compared.criteria, (of_base, of_best))
    comparison: Any = compared.comparison
    sentence = NOT_ADEQUATE.format(SOURCES[base.runs[0].noise_source], single.reduced)
    outcome = replace(comparison.outcome, sentences=[sentence, *comparison.outcome.sentences])
    return replace(compared, base=own, best=best, validation_gap=gap, comparison=replace(comparison, outcome=outcome))
