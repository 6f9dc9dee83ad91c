"""A deadline for computations that can end early with what they have by then.

    with deadline(60.0):
        while not time_is_up():
            ...

It holds for all that is called in its context, in worker processes too: iterations ask `time_is_up()` and end where
they are. Without a deadline the time is never up. An inner deadline replaces the outer one.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from math import inf
from time import monotonic


@dataclass(frozen=True)
class Deadline:
    """The end of a time budget [s], on the monotonic clock, which all processes of a machine share."""

    budget: float = inf
    end: float = inf

    @property
    def left(self) -> float:
        """The time that is left [s]; negative once it is up."""
        return self.end - monotonic()


_NONE = Deadline()
_CURRENT: ContextVar[Deadline] = ContextVar("deadline", default=_NONE)


@contextmanager
def deadline(seconds: float) -> Iterator[None]:
    """A deadline so many seconds after the context is entered."""
    with current(Deadline(seconds, monotonic() + seconds)):
        yield


@contextmanager
def current(made: Deadline) -> Iterator[None]:
    """A deadline of another context or process holds here."""
    token = _CURRENT.set(made)
    try:
        yield
    finally:
        _CURRENT.reset(token)


def current_deadline() -> Deadline:
    """The deadline that holds here."""
    return _CURRENT.get()


def time_is_up() -> bool:
    """Whether the deadline that holds here has passed."""
    return _CURRENT.get().left <= 0
