"""Progress for whoever waits longer than a second: on stderr, silent when that is not a terminal."""

from collections.abc import Iterable, Iterator
from typing import TypeVar

from rich.console import Console
from rich.progress import track as _track

T = TypeVar("T")


def track(iterable: Iterable[T], description: str, total: float | None = None) -> Iterator[T]:
    """The items of an iterable, with a bar that shows how many have been taken."""
    console = Console(stderr=True)
    yield from _track(iterable, description, total, console=console, transient=True, disable=not console.is_terminal)
