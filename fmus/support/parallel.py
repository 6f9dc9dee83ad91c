"""Independent tasks on all processors. Results are the same as one after the other.

On Linux workers are forked for each call and inherit the function and its items. On other platforms they are those of
loky: fresh interpreters that stay for later calls, and read the pickled function and items from a file. The environment
variable MOTOFMI_START_METHOD (fork or loky) chooses one of the two; docs/decisions/processes.md holds the measurements.
The number of workers is the number of available processors, at most OMP_NUM_THREADS.

    squares = parallel_map(lambda x: x**2, [1, 2, 3], "squares")
"""

import itertools
import multiprocessing
import os
import signal
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import cloudpickle
import loky

from fmus.support.deadline import Deadline, current, current_deadline
from fmus.support.errors import unknown
from fmus.support.parent import watch
from fmus.support.progress import track

T = TypeVar("T")
START_METHODS = ("fork", "loky")
IDLE = 60.0  # s after which an unused worker ends; a new one takes about 2 s to import what it needs
ONE_THREAD = dict.fromkeys(
    ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"), "1"
)
_TASKS: dict[
    str, tuple[Callable[[Any], Any], Sequence[Any], Deadline]
] = {}  # by key: the open ones, or in a fresh worker the last one
_numbers = itertools.count()


def parallel_map(
    function: Callable[[Any], T], items: Sequence[Any], description: str, workers: int | None = None
) -> list[T]:
    """function(item) of every item, in order, by so many workers (default: `processes`).

    Results are pickled; for fresh workers the function and the items, too. Raises what the function raises.
    """
    count = min(workers or processes(), len(items))
    if count < 2:
        return [function(item) for item in track(items, description)]
    with _submitted(function, items, count) as results:
        return [result.result() for result in track(results, description)]


@contextmanager
def in_background(function: Callable[[], T]) -> Iterator[Callable[[], T]]:
    """Compute function() in a worker while the context lasts; the function that the context yields waits for the
    result.

    Without a second processor the result is computed when it is asked for.
    """
    if processes() < 2:
        yield function
        return
    with _submitted(lambda task: task(), [function], 1) as (result,):
        yield result.result


def in_turn(tasks: Sequence[Callable[[], T]]) -> Iterator[T]:
    """The results of tasks in order, every second one computed while the one before it is.

    A caller that ends early, as a search that needs no further start, stops the task that is under way.
    """
    for first, second in itertools.zip_longest(tasks[::2], tasks[1::2]):
        if second is None:
            yield first()
        else:
            with in_background(second) as result:
                yield first()
                yield result()


@contextmanager
def pool(count: int) -> Iterator[Executor]:
    """An executor of so many worker processes, which take functions of modules.

    After an error in the context the workers end at once.
    """
    method = start_method()
    executor: Executor
    if method == "fork":
        executor = _pool(count, method)
    else:
        executor = loky.ProcessPoolExecutor(count, initializer=_follow, initargs=(os.getpid(),), env=ONE_THREAD)
    try:
        with _complete_start():
            executor.submit(os.getpid)  # the first task starts the workers
            _close_own_end_of_results(executor)
        yield executor
    except BaseException:
        _stop(executor)
        raise
    else:
        executor.shutdown()


def processes() -> int:
    """The number of workers; 1 within a worker."""
    if multiprocessing.current_process().name != "MainProcess":
        return 1
    allowed = os.environ.get("OMP_NUM_THREADS", "")
    return min(loky.cpu_count(), int(allowed) if allowed.isdigit() else sys.maxsize)


def start_method() -> str:
    """How workers start: fork or loky. Raises InputError where MOTOFMI_START_METHOD is neither."""
    name = os.environ.get("MOTOFMI_START_METHOD") or ("fork" if sys.platform == "linux" else "loky")
    if name not in START_METHODS:
        raise unknown("MOTOFMI_START_METHOD", name, START_METHODS)
    return name


@contextmanager
def _submitted(function: Callable[[Any], T], items: Sequence[Any], count: int) -> Iterator[list[Future]]:
    """The future results. No task runs after the context, which an interrupt ends at once."""
    method = start_method()
    with _task(function, items, method) as key:
        pool = _pool(count, method)
        results: list[Future] = []
        try:
            with _complete_start():
                results += [pool.submit(_run, key, os.getcwd(), index) for index in range(len(items))]
                _close_own_end_of_results(pool)
            yield results
        except Exception:
            for result in results:
                result.cancel()
            raise
        except BaseException:
            _stop(pool)
            results.clear()
            raise
        finally:
            wait(results)
            if method == "fork":
                pool.shutdown()


@contextmanager
def _task(function: Callable[[Any], T], items: Sequence[Any], method: str) -> Iterator[str]:
    """The key under which workers find a function and its items: inherited, or the path of a file."""
    if method == "fork":
        key = f"task {next(_numbers)}"
        _TASKS[key] = function, items, current_deadline()
        try:
            yield key
        finally:
            del _TASKS[key]
        return
    with tempfile.TemporaryDirectory(prefix="motofmi_", ignore_cleanup_errors=True) as folder:
        path = Path(folder) / "task"
        path.write_bytes(cloudpickle.dumps((function, items, current_deadline())))
        yield str(path)


def _pool(count: int, method: str) -> Executor:
    """Forked workers for one call, or those that stay."""
    if method == "fork":
        return ProcessPoolExecutor(count, multiprocessing.get_context("fork"), _follow, (os.getpid(),))
    return loky.get_reusable_executor(
        max(count, processes()), "loky", IDLE, initializer=_follow, initargs=(os.getpid(),), env=ONE_THREAD
    )


def _close_own_end_of_results(pool: Executor) -> None:
    """Close this process's writing end of the pipe of results, once all forked workers have started.

    Reading then ends with the last worker. While the end is open here, the pool waits without limit for the rest of a
    result whose worker was terminated within writing it.
    """
    if isinstance(pool, ProcessPoolExecutor):  # no public method closes the end
        pool._result_queue._writer.close()  # type: ignore[attr-defined]


def _stop(pool: Executor) -> None:
    """No task is started any more, and the workers end at once."""
    if isinstance(pool, loky.ProcessPoolExecutor):
        pool.shutdown(kill_workers=True)
        return
    for worker in list(getattr(pool, "_processes", {}).values()):  # a public method comes with Python 3.14
        worker.terminate()
    pool.shutdown(cancel_futures=True)


@contextmanager
def _complete_start() -> Iterator[None]:
    """An interrupt waits until all workers run and ignore it: a pool that is half started cannot be closed."""
    masks = hasattr(signal, "pthread_sigmask")
    if masks:
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        with warnings.catch_warnings():
            # Python warns of threads in a process that forks: those of the linear algebra survive it, the others wait
            # for workers.
            warnings.simplefilter("ignore", DeprecationWarning)
            yield
    finally:
        if masks:
            signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})


def _run(key: str, folder: str, index: int) -> Any:
    """One item of a task, in a worker."""
    if key not in _TASKS:
        os.chdir(folder)
        _TASKS.clear()
        _TASKS[key] = cloudpickle.loads(Path(key).read_bytes())
    function, items, deadline = _TASKS[key]
    with current(deadline):
        return function(items[index])


def _follow(parent: int) -> None:
    """Interrupts are handled by the parent process; where that is killed, its workers end, too."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    watch(parent)
