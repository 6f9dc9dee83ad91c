"""What could be recorded next of any component: the same excitation, larger or smaller."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from identification.gap.data.sampled import Sampled
from identification.gap.naming.fitting import Fit
from identification.gap.proposing.expected import Foresight, through
from identification.gap.proposing.next_test import Proposal


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


def scaled_runs(found: Fit) -> Sequence[Proposal]:
    """The first run again at twice and at half the excitation; none where the motion is imposed or nothing drives it."""
    run: Sampled = found.runs[0]
    if not run.test.inputs or run.test.imposed:
        return []
    return [ScaledRun(name, f"Repeat the run at {factor:g} times the excitation: {why}", {"factor": factor}, run.scaled(factor))
            for name, factor, why in (("larger_excitation", 2.0, "what grows faster than the motion stands out."),
                                      ("smaller_excitation", 0.5, "friction and play stand out."))]  # fmt: skip
