"""Progress of work that takes longer than a second, on stderr: a bar in a terminal, elsewhere a line now and then."""

import sys
from collections.abc import Iterable, Iterator, Sized
from contextlib import contextmanager
from threading import Event, Thread
from time import monotonic
from typing import TypeVar

from rich.console import Console
from rich.progress import track as _track

T = TypeVar("T")

SECONDS = 10.0  # between two lines, and before the first one: a log of an hour has at most 360 of them


def track(iterable: Iterable[T], description: str, total: float | None = None) -> Iterator[T]:
    """The items of an iterable; how many have been finished is shown on stderr.

    A line in a log reads `building: 12 of 30 (40 %) after 25 s`, without a length of the iterable
    `building: 12 after 25 s`.
    """
    console = Console(stderr=True)
    if console.is_terminal:
        yield from _track(iterable, description, total, console=console, transient=True)
        return
    finished = [0]
    with _lines(description, finished, len(iterable) if total is None and isinstance(iterable, Sized) else total):
        for item in iterable:
            yield item
            finished[0] += 1


@contextmanager
def _lines(description: str, finished: list[int], total: float | None) -> Iterator[None]:
    """Write a line every SECONDS, from a thread of its own: a single item may take minutes."""
    began, end = monotonic(), Event()

    def write() -> None:
        while not end.wait(SECONDS):
            share = f" of {total:g} ({100 * finished[0] / total:.0f} %)" if total else ""
            print(f"{description}: {finished[0]}{share} after {monotonic() - began:.0f} s", file=sys.stderr, flush=True)

    Thread(target=write, daemon=True).start()
    try:
        yield
    finally:
        end.set()
