"""Computes the chunks of a study that are not complete, and survives the loss of workers."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from dataclasses import dataclass
from typing import Any

from fmus.support.errors import InputError
from fmus.support.progress import track
from motofmi.studies.engine import Engine, engine
from motofmi.studies.store import Store

AHEAD = 2  # chunks that wait for each worker: it never idles, and the queue does not grow with the study
LOSSES = 2  # losses of workers after which a chunk is computed in a worker of its own


@dataclass(frozen=True)
class StoredChunk:
    """The task of a study: compute the runs of one chunk and write them into the study's folder."""

    store: Store

    def __call__(self, chunk: int) -> None:
        self.store.reachable()
        runs = self.store.runs
        self.store.write(chunk, runs.compute(runs.grid.indices(chunk)))


def run_study(store: Store, description: dict[str, Any], noun: str, scheduler: str | None = None,
              workers: int | None = None,
              on_dashboard: Callable[[str], object] = lambda address: None) -> None:  # fmt: skip
    """Compute what the folder of a study lacks, with progress in chunks of that noun, and complete its table.

    Nothing is written where there is no scheduler.
    """
    with engine(StoredChunk(store), scheduler, workers) as found:
        store.begin(description)
        todo = store.incomplete()
        if todo:
            if found.dashboard:
                on_dashboard(found.dashboard)
            for _ in track(completed(found, store, todo), noun, len(todo)):
                pass
    store.finish()


def completed(found: Engine, store: Store, chunks: Sequence[int]) -> Iterator[int]:
    """The numbers of the chunks as they are completed.

    A chunk whose worker was lost is computed again. One that ends every worker is recorded as failed, with the reason.
    Raises InputError where the scheduler was lost, and what else a chunk raises.
    """
    waiting, losses = iter(chunks), dict.fromkeys(chunks, 0)
    again: list[int] = []
    pending: dict[Future, int] = {}
    while True:
        while len(pending) < (1 + AHEAD) * found.workers:
            chunk = again.pop() if again else next(waiting, None)
            if chunk is None:
                break
            pending[found.submit(chunk)] = chunk
        if not pending:
            return
        done, others = wait(pending, return_when=FIRST_COMPLETED)
        if any(future.cancelled() for future in done):  # Dask cancels what waits when its scheduler is lost
            raise InputError("the scheduler was lost; what is complete is kept: start the study again to go on")
        if any(isinstance(future.exception(), BrokenExecutor) for future in done):
            done |= wait(others).done  # all chunks of a broken pool fail
        lost: list[int] = []
        for future in done:
            chunk = pending.pop(future)
            error = future.exception()
            if error is None:
                yield chunk
            elif found.broken(error):
                lost.append(chunk)
            else:
                raise error
        yield from _retried(found, store, lost, losses, again)


def _retried(found: Engine, store: Store, lost: Sequence[int], losses: dict[int, int],
             again: list[int]) -> Iterator[int]:  # fmt: skip
    """Put lost chunks back; those that were lost too often are computed alone, and completed or recorded as failed."""
    for chunk in lost:
        losses[chunk] += 1
        if losses[chunk] < LOSSES:
            again.append(chunk)
            continue
        error = found.alone(chunk)
        if error is not None:
            store.write(chunk, store.runs.failed(store.runs.grid.indices(chunk), f"the worker process ended: {error}"))
        yield chunk
