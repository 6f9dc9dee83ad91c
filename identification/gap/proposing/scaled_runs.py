"""What could be recorded next of any component: the same excitation, larger or smaller."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from fmus.errors import InputError
from identification.gap.data.sampled import Sampled
from identification.gap.naming.fitted import Fit
from identification.gap.naming.fitting import fit
from identification.gap.proposing.expected import Foresight, through
from identification.gap.proposing.next_test import ENOUGH, Proposal

PATIENCE = 60  # iterations: what bends one effect into another leads along a narrow valley


@dataclass
class ScaledRun:
    """The excitation of a run that was made, times a factor."""

    experiment: str
    sentence: str
    settings: dict[str, float]
    run: Sampled

    def foresee(self, rival: Fit) -> Foresight:
        """What a fitted model would give."""
        return through(rival, replace(self.run, guess={}))

    def left(self, truth: Fit, rival: Fit) -> float:
        """The delta chi-square of a rival that is fitted again, to its own runs and to what the truth would give in this one.

        Where it is beyond ENOUGH for sure, the fit ends on its way, and it is what was left there.
        """
        try:
            answer, _ = truth.model.reduced(replace(self.run, guess={}), truth.shared)
            told = replace(self.run, data=answer * self.run.deviation, guess={})
            again = fit(rival.model, [*rival.runs, told], rival.x, iterations=PATIENCE, beat=rival.chi2 + ENOUGH)
            return max(again.chi2 - rival.chi2, 0.0)
        except InputError:  # it cannot be simulated so far from what was fitted
            return 0.0


def scaled_runs(found: Fit) -> Sequence[Proposal]:
    """The first run again at twice and at half the excitation; none where nothing drives it."""
    run: Sampled = found.runs[0]
    if not run.test.inputs:
        return []
    excitation = "imposed motion" if run.test.imposed else "excitation"
    return [ScaledRun(name, f"Repeat the run at {factor:g} times the {excitation}: {why}", {"factor": factor}, run.scaled(factor))
            for name, factor, why in (("larger_excitation", 2.0, "what grows faster than the motion stands out."),
                                      ("smaller_excitation", 0.5, "friction and play stand out."))]  # fmt: skip
