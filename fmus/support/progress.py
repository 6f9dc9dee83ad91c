"""Progress of work that takes longer than a second, on stderr: a bar in a terminal, elsewhere a line now and then.

Work consists of stages and of items that are tracked; both may contain others, and all share one display.

    with stage("single effects"):
        for effect in track(effects, "fitting"):     # single effects: fitting: 12 of 46 (26 %) after 25 s, 70 s left
"""

import sys
from collections.abc import Callable, Iterable, Iterator, Sized
from contextlib import contextmanager
from dataclasses import dataclass, field
from threading import Event, Thread
from time import monotonic
from typing import TypeVar

from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn

from fmus.support.deadline import Deadline, current_deadline

T = TypeVar("T")

SECONDS = 10.0  # between two lines, and before the first one: a log of an hour has at most 360 of them
REFRESHED = 0.1  # s between two states of a bar


@dataclass(eq=False)
class _Part:
    """A part of the work: a stage, or items, of which some are finished."""

    description: str
    counted: bool
    total: float | None = None
    finished: int = 0
    began: float = field(default_factory=monotonic)
    deadline: Deadline = field(default_factory=current_deadline)

    def text(self) -> str:
        """How many items are finished, after which time, and the time that the others take at the same rate, at most
        what a deadline leaves."""
        after = monotonic() - self.began
        share = f" of {self.total:g} ({100 * self.finished / self.total:.0f} %)" if self.total else ""
        said = f"{self.finished}{share} after {after:.0f} s" if self.counted else f"after {after:.0f} s"
        if not self.total or not self.finished:
            return said
        left = min((self.total - self.finished) * after / self.finished, self.deadline.left)
        return f"{said}, about {max(left, 0.0):.0f} s left"


_PARTS: list[_Part] = []  # of the display that is open, the innermost last; a worker process inherits it and is silent


def track(iterable: Iterable[T], description: str, total: float | None = None) -> Iterator[T]:
    """The items of an iterable; how many have been finished is shown on stderr.

    A line in a log reads `building: 12 of 30 (40 %) after 25 s, about 38 s left`, without a length of the iterable
    `building: 12 after 25 s`.
    """
    part = _Part(description, True, len(iterable) if total is None and isinstance(iterable, Sized) else total)
    with _shown(part):
        for item in iterable:
            yield item
            part.finished += 1


@contextmanager
def stage(description: str) -> Iterator[None]:
    """A stage of some work; items that are tracked within are shown under its name.

    In a log a stage that took longer than SECONDS says when it ends.
    """
    part = _Part(description, False)
    with _shown(part):
        yield
        if monotonic() - part.began > SECONDS and not _on_terminal():
            _write(f"{_line(part)}, ended")


def say(sentence: str) -> None:
    """Write a sentence on the work that runs; nothing outside a stage."""
    if _PARTS:
        _write(f"{_names()}: {sentence}")


@contextmanager
def _shown(part: _Part) -> Iterator[None]:
    """The part is the innermost one; the first opens the display."""
    _PARTS.append(part)
    try:
        if len(_PARTS) > 1:
            yield
            return
        with _bar() if _on_terminal() else _every(SECONDS, lambda: _write(_line(_PARTS[-1]))):
            yield
    finally:
        _PARTS.remove(part)


@contextmanager
def _bar() -> Iterator[None]:
    """A bar for the innermost part, which is gone at the end."""
    columns = SpinnerColumn(), TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[text]}")
    with Progress(*columns, console=Console(stderr=True), transient=True, auto_refresh=False) as bar:
        task = bar.add_task(_names(), total=None, text="")

        def refresh() -> None:
            if _PARTS:
                part = _PARTS[-1]
                bar.update(task, description=_names(), total=part.total, completed=part.finished, text=part.text())
                bar.refresh()

        refresh()
        with _every(REFRESHED, refresh):
            yield


@contextmanager
def _every(seconds: float, do: Callable[[], None]) -> Iterator[None]:
    """Call a function now and then, from a thread of its own: a single item may take minutes."""
    end = Event()

    def repeat() -> None:
        while not end.wait(seconds):
            do()

    thread = Thread(target=repeat, daemon=True)
    thread.start()
    try:
        yield
    finally:
        end.set()
        thread.join()


def _on_terminal() -> bool:
    return Console(stderr=True).is_terminal


def _names() -> str:
    return ": ".join(part.description for part in list(_PARTS))


def _line(part: _Part) -> str:
    return f"{_names()}{':' if part.counted else ''} {part.text()}"


def _write(line: str) -> None:
    print(line, file=sys.stderr, flush=True)
