"""The stages of a search, in each of which the time budget may end.

Once the time is up, no further fit begins and those that run end where they are, so that a stage ends soon by itself.
What it found is not complete then, and decides nothing: at its end the stage raises TimeUpError, and the verdict is
that of what was known before (`motofmi.gap.selection.within_time`).
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import Enum

from fmus.support.deadline import current_deadline, time_is_up
from fmus.support.progress import stage as shown


@dataclass(frozen=True)
class _Stage:
    title: str
    undone: str  # what is missing where the time ended during it


class Stage(Enum):
    """The stages, in order."""

    BASE = _Stage("base", "the base is not fitted to the end, and no effect was fitted")
    SINGLE_EFFECTS = _Stage("single effects", "not every effect of the library was fitted, and no pair of effects")
    NOISE = _Stage(
        "noise of the best effect", "the effects were not compared on validation runs, and no pair was fitted"
    )
    COMPARISON = _Stage(
        "comparison on blocks", "the effects were not compared on validation runs, and no pair was fitted"
    )
    PAIRS = _Stage("pairs of effects", "pairs of effects were not compared")
    VALIDATION = _Stage("validation", "what validation runs reject was not replaced by another effect")
    OUTSIDE = _Stage("effects outside the library", "the result was not compared with effects outside the library")


class TimeUpError(Exception):
    """The time budget ended during a stage; the message is the limitation."""


@contextmanager
def running(stage: Stage) -> Iterator[None]:
    """A stage, whose progress is shown. Raises TimeUpError at its end where the time was up before."""
    with shown(stage.value.title):
        yield
    if time_is_up():
        raise TimeUpError(
            f"The time budget of {current_deadline().budget:g} s ended during the stage '{stage.value.title}': "
            f"{stage.value.undone}."
        )
