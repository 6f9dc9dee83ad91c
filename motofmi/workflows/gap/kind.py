"""The interface of a kind of experiment: reading, verdict, fitted model and report."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar

from fmus.declaration.component import Component
from motofmi.gap.selection.result import Verdict
from motofmi.reports.gap_report import Pictures
from motofmi.reports.report import Section, Table
from motofmi.workflows.gap.fitted_model import FittedModel
from motofmi.workflows.gap.given import Given


class Kind(ABC):
    """One kind of experiment.

    Constructing it reads and prepares the recordings and raises InputError for arguments or recordings that cannot be
    used, before anything is fitted.
    """

    given: Given
    title: ClassVar[str]  # of the report
    place: ClassVar[str] = "axis"  # heading of the second column in the report's table of where the base deviates

    @classmethod
    @abstractmethod
    def suits(cls, given: Given) -> bool:
        """Whether the arguments describe an experiment of this kind."""

    @abstractmethod
    def __init__(self, given: Given) -> None:
        """Read and prepare the recordings."""

    @abstractmethod
    def verdict(self, on_progress: Callable[[Verdict], None]) -> Verdict:
        """Fit the base and the candidates and select a model; on_progress is called with the state after every
        stage."""

    @abstractmethod
    def contents(self, verdict: Verdict) -> dict[str, Any]:
        """The contents of `verdict.json` for a verdict, final or intermediate."""

    @abstractmethod
    def limitations(self, verdict: Verdict, contents: dict[str, Any]) -> list[str]:
        """Limitations of the verdict, in sentences, besides those in the contents."""

    @abstractmethod
    def model(self, verdict: Verdict) -> FittedModel:
        """The fitted model with the effects found."""

    def found_device(self, verdict: Verdict) -> FittedModel | None:
        """The device among the effects found, as a model of its own, or None."""
        del verdict
        return None

    @abstractmethod
    def pictures(self, verdict: Verdict) -> Pictures:
        """The figures of the report."""

    def next_experiment(self, verdict: Verdict) -> dict[str, Any] | None:
        """The experiment that would distinguish the remaining candidates; None if none is needed or known."""
        del verdict
        return None

    def modes(self, verdict: Verdict, model: Component) -> dict[str, Any] | None:
        """The modes without and with the effects found, or None."""
        del verdict, model
        return None

    def modes_section(self, contents: dict[str, Any]) -> Section | None:
        """The section of the report on the modes, or None."""
        del contents
        return None

    def fitted_parameters(self, verdict: Verdict) -> list[Table]:
        """Tables of fitted parameters besides those of the effects."""
        del verdict
        return []
