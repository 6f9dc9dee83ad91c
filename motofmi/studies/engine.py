"""Where the chunks of a study are computed: processes of this machine, or a Dask cluster, both as executors of
`concurrent.futures`.

The runs are pickled once: into a file that the local workers read, or scattered to the workers of the cluster.
"""

import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any, Protocol

import cloudpickle

from fmus.support.errors import InputError, MissingToolError
from fmus.support.parallel import pool, processes
from motofmi.version import __version__

Task = Callable[[int], Any]  # computes the chunk of that number


class Engine(Protocol):
    """workers: how many chunks are computed at the same time; dashboard: the address of a page that shows them."""

    workers: int
    dashboard: str

    def submit(self, chunk: int) -> Future: ...

    def broken(self, error: BaseException) -> bool:
        """Whether a chunk failed because its worker ended; the engine is then ready again."""

    def alone(self, chunk: int) -> BaseException | None:
        """Compute one chunk in a worker of its own; the error if that ended the worker."""


class LocalEngine:
    """Worker processes of this machine; those that are killed are replaced."""

    dashboard = ""

    def __init__(self, path: Path, workers: int):
        self.workers, self._path = workers, path
        self._open: Any = None
        self._executor: Executor | None = None

    def submit(self, chunk: int) -> Future:
        """The future of a chunk."""
        if self._executor is None:
            self._open = pool(self.workers)
            self._executor = self._open.__enter__()
        return self._executor.submit(_computed, self._path, chunk)

    def broken(self, error: BaseException) -> bool:
        """Whether the pool is broken; a new one starts with the next chunk."""
        if not isinstance(error, BrokenExecutor):
            return False
        self.close()
        return True

    def alone(self, chunk: int) -> BaseException | None:
        """One chunk in a pool of one worker."""
        with pool(1) as executor:
            try:
                executor.submit(_computed, self._path, chunk).result()
            except BrokenExecutor as error:
                return error
        return None

    def close(self, *error: Any) -> None:
        """End the workers."""
        if self._open is not None:
            self._open.__exit__(*(error or (None, None, None)))
        self._open = self._executor = None


class DaskEngine:
    """The workers of a Dask cluster. The scheduler computes the chunks of a lost worker again; a chunk that ends three
    workers is a failure."""

    def __init__(self, client: Any, payload: bytes):
        self._client, self._executor = client, client.get_executor(pure=False)
        self._payload = client.scatter(payload, broadcast=True)
        self.dashboard = client.dashboard_link
        self.workers = max(sum(client.nthreads().values()), 1)

    def submit(self, chunk: int) -> Future:
        """The future of a chunk."""
        return self._executor.submit(_computed, self._payload, chunk)

    def broken(self, error: BaseException) -> bool:
        """Whether the chunk ended its workers."""
        return type(error).__name__ == "KilledWorker"

    def alone(self, chunk: int) -> BaseException | None:
        """The scheduler has already tried the chunk on several workers."""
        return RuntimeError("the worker process ended on every attempt")


@contextmanager
def engine(task: Task, scheduler: str | None = None, workers: int | None = None) -> Iterator[Engine]:
    """The workers that compute a task's chunks: of this machine, or of the cluster with a scheduler at an address.

    Raises InputError where no scheduler listens there, MissingToolError without Dask.
    """
    payload = cloudpickle.dumps(task)
    if scheduler is None:
        with tempfile.TemporaryDirectory(prefix="motofmi_", ignore_cleanup_errors=True) as folder:
            path = Path(folder) / "task"
            path.write_bytes(payload)
            local = LocalEngine(path, workers or processes())
            try:
                yield local
            except BaseException as error:
                local.close(type(error), error, error.__traceback__)
                raise
            local.close()
        return
    with _client(scheduler) as client:
        yield DaskEngine(client, payload)


@contextmanager
def _client(address: str) -> Iterator[Any]:
    """A client of the scheduler, whose workers have the same version of this package."""
    try:
        from distributed import Client  # noqa: PLC0415 - of the extra
    except ImportError:
        raise MissingToolError("--scheduler needs Dask: pip install 'motofmi[scale]'") from None
    try:
        client = Client(address, timeout=5, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise InputError(f"no Dask scheduler at {address} ({' '.join(str(error).split())}); expected an address as in "
                         "tcp://host:8786, where `dask scheduler` runs") from None  # fmt: skip
    with client:
        versions = client.run(_version)
        if not versions:
            raise InputError(f"the scheduler at {address} has no workers: start `dask worker {address}`")
        others = {worker: found for worker, found in versions.items() if found != __version__}
        if others:
            raise InputError(f"workers have other versions of motofmi: {others}; expected {__version__} everywhere")
        yield client


def _version() -> str:
    return __version__


@lru_cache(maxsize=2)
def _task(given: bytes | Path) -> Task:
    return cloudpickle.loads(given if isinstance(given, bytes) else given.read_bytes())


def _computed(given: bytes | Path, chunk: int) -> int:
    """One chunk, in a worker; its number."""
    _task(given)(chunk)
    return chunk
