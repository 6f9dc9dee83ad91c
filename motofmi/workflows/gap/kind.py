"""The interface of a kind of experiment: from the recordings to the contents of the report."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar

from fmus.declaration.component import Component
from motofmi.gap.selection.model_selection import Verdict
from motofmi.reports.gap_report import Pictures
from motofmi.reports.report import Section, Table
from motofmi.workflows.gap.fitted_model import FittedModel
from motofmi.workflows.gap.given import Given


class Kind(ABC):
    """One kind of experiment.

    An instance has read and prepared the recordings: faults in what was given are raised (InputError) when it is made,
    before anything is fitted.
    """

    title: ClassVar[str]  # of the report
    place: ClassVar[str] = "axis"  # what the second column of the table of places is

    @classmethod
    @abstractmethod
    def suits(cls, given: Given) -> bool:
        """Whether what was given is of this kind."""

    @abstractmethod
    def __init__(self, given: Given) -> None:
        """Read and prepare the recordings."""

    @abstractmethod
    def verdict(self, so_far: Callable[[Verdict], None]) -> Verdict:
        """Fit the base and the candidates; so_far is called with what is known after every stage."""

    @abstractmethod
    def contents(self, verdict: Verdict) -> dict[str, Any]:
        """What `verdict.json` holds of a verdict, also of one before the end."""

    @abstractmethod
    def limitations(self, verdict: Verdict, contents: dict[str, Any]) -> list[str]:
        """What the data leave open, besides the limitations in the contents."""

    @abstractmethod
    def model(self, verdict: Verdict) -> FittedModel:
        """The fitted model with the effects that were found."""

    def found_device(self, verdict: Verdict) -> FittedModel | None:
        """The device among the effects that were found, by itself; None where there is none."""
        del verdict
        return None

    @abstractmethod
    def pictures(self, verdict: Verdict) -> Pictures:
        """The figures of the report."""

    def next_experiment(self, verdict: Verdict) -> dict[str, Any] | None:
        """The experiment that would settle the verdict, None where none is needed or known."""
        del verdict
        return None

    def modes(self, verdict: Verdict, model: Component) -> dict[str, Any] | None:
        """The modes before and after, None where nothing changes them."""
        del verdict, model
        return None

    def modes_section(self, contents: dict[str, Any]) -> Section | None:
        """The section of the report on the modes."""
        del contents
        return None

    def fitted_parameters(self, verdict: Verdict) -> list[Table]:
        """Tables of fitted parameters beside those of the effects."""
        del verdict
        return []
