"""Independent pieces of work on all processors, forked, so that each finds there what it needs; one by one elsewhere.

The answers are the same either way. As many processes work as OMP_NUM_THREADS allows, or as there are processors.
"""

import multiprocessing
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from typing import Any, TypeVar

from fmus.progress import track

T = TypeVar("T")
_WORK: list[tuple[Callable[[Any], Any], Sequence[Any]]] = []  # what a forked process inherits


def spread(function: Callable[[Any], T], items: Sequence[Any], description: str) -> list[T]:
    """function(item) of every item, in order. Only answers travel between processes: they must be plain data."""
    count = min(processes(), len(items))
    if count < 2:
        return [function(item) for item in track(items, description)]
    with _begun(function, items, count) as answers:
        return [a.result() for a in track(answers, description)]


@contextmanager
def aside(function: Callable[[], T]) -> Iterator[Callable[[], T]]:
    """What asks for the answer of function(), which a process of its own works out meanwhile; the answer must be plain data."""
    if processes() < 2:
        yield function
        return
    with _begun(lambda work: work(), [function], 1) as (answer,):
        yield answer.result


@contextmanager
def _begun(function: Callable[[Any], T], items: Sequence[Any], count: int) -> Iterator[list[Future]]:
    """The answers to come from so many processes, which end with the context."""
    _WORK.append((function, items))
    pool = ProcessPoolExecutor(count, multiprocessing.get_context("fork"), initializer=_follow_the_parent)
    try:
        with warnings.catch_warnings():
            # The threads that Python warns of are those of the linear algebra, which survives a fork, and those that wait for other processes.
            warnings.simplefilter("ignore", DeprecationWarning)
            answers = _submitted(pool, len(items))
        yield answers
    finally:
        pool.shutdown(cancel_futures=True)  # after an interrupt, what was not begun is not waited for
        _WORK.pop()


def processes() -> int:
    """How many processes may work at the same time."""
    if not sys.platform.startswith("linux") or multiprocessing.current_process().name != "MainProcess":
        return 1
    allowed = os.environ.get("OMP_NUM_THREADS", "")
    return min(len(os.sched_getaffinity(0)), int(allowed) if allowed.isdigit() else sys.maxsize)


def _submitted(pool: ProcessPoolExecutor, count: int) -> list[Future]:
    """What will be answered, in order. An interrupt waits until the workers run: a pool that is half started cannot be closed."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        return [pool.submit(_answer, i) for i in range(count)]
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})


def _answer(index: int) -> Any:
    function, items = _WORK[-1]
    return function(items[index])


def _follow_the_parent() -> None:
    """Interrupts are the parent's to answer; where it is killed, its workers end too."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(multiprocessing.parent_process(),), daemon=True).start()


def _end_with(parent: Any) -> None:
    parent.join()
    os._exit(1)
