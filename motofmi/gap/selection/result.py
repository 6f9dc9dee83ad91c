"""The result of model selection."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

from motofmi.gap.comparison.compare import Comparison
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import Candidate
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.validation.before_after import ValidationGap


@dataclass
class Verdict:
    """The result of model selection.

    `best` is the selected fit; candidates are all single effects, the best first. `conclude` is a function that
    completes an intermediate verdict where the search ends early; `ended` is then the sentence on what was not done
    because of a time budget or an interrupt.
    """

    verdict: str  # none, named, tied or unknown
    base: Fit
    best: Fit
    effects: list[Candidate] = field(default_factory=list)
    tied: list[Candidate] = field(default_factory=list)
    candidates: list[Candidate] = field(default_factory=list)
    unspecified_form: bool = False
    rejected: list[str] = field(default_factory=list)  # families that fit well, but that validation runs reject
    # "family.form by form", where validation runs reject the form
    replaced_forms: list[str] = field(default_factory=list)
    withheld: str = ""  # the sentence on a rule by which nothing is named
    outside_library: Candidate | None = None  # an effect outside the library that explains more than any inside
    validation_gap: ValidationGap = None  # misfit on validation runs before and after
    criteria: Criteria = Criteria()
    comparison: Comparison | None = None  # where the verdict is that of a comparison on blocks
    conclude: Callable[[], "Verdict"] | None = None
    ended: str = ""
    interrupted: bool = False

    def __repr__(self) -> str:
        verdict = f"{self.verdict}: {self.names}" if self.names else self.verdict
        return f"Verdict({verdict}, reduced chi-square {self.base.reduced:.3g} -> {self.best.reduced:.3g})"

    @property
    def names(self) -> str:
        """The names of the effects that are named or tied, as in a sentence; empty where nothing is."""
        return " and ".join(c.family for c in self.effects) or " or ".join(c.family for c in self.tied)

    def as_unknown(self, withheld: str = "") -> "Verdict":
        """The same fits with the verdict `unknown`, and the sentence on the rule by which nothing is named."""
        return replace(self, verdict="unknown", effects=[], tied=[], unspecified_form=False,
                       withheld=withheld or self.withheld)  # fmt: skip
