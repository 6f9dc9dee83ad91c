"""Tasks in workers: forked ones, and fresh interpreters as on macOS and Windows."""

import os
import subprocess
import sys
import time
import warnings

import pytest

from fmus.support import parallel
from fmus.support.errors import InputError

METHODS = [
    pytest.param("fork", marks=pytest.mark.skipif(sys.platform != "linux", reason="workers are forked on Linux alone")),
    pytest.param("loky", marks=pytest.mark.slow),
]


@pytest.fixture(params=METHODS)
def two_workers(request, monkeypatch):
    """The start method, with as many workers as there would be on two processors."""
    monkeypatch.setenv("MOTOFMI_START_METHOD", request.param)
    monkeypatch.setattr(parallel.loky, "cpu_count", lambda: 2)
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    return request.param


def test_results_come_in_order_and_errors_are_raised(two_workers):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        results = parallel.parallel_map(lambda i: (i**2, os.getpid()), range(20), "squares")
    assert [square for square, _ in results] == [i**2 for i in range(20)]
    assert os.getpid() not in {process for _, process in results}
    with pytest.raises(ZeroDivisionError):
        parallel.parallel_map(lambda i: 1 / i, range(3), "reciprocals")
    assert parallel.parallel_map(abs, [-1, -2], "after an error") == [1, 2]
    assert not parallel._TASKS


def test_workers_have_the_current_folder_and_one_thread_each(two_workers, monkeypatch, tmp_path):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")  # as the command sets it
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        monkeypatch.chdir(tmp_path / name)
        found = parallel.parallel_map(lambda _: (os.getcwd(), os.environ["OPENBLAS_NUM_THREADS"]), range(2), "folders")
        assert set(found) == {(str(tmp_path / name), "1")}


def test_a_worker_starts_no_workers(two_workers):
    def own(_):
        return {os.getpid(), *parallel.parallel_map(lambda i: os.getpid(), range(2), "inner")}

    assert [len(each) for each in parallel.parallel_map(own, range(2), "outer")] == [1, 1]


def test_a_result_from_the_background_is_there_when_it_is_asked_for(two_workers):
    with parallel.in_background(os.getpid) as first, parallel.in_background(lambda: 1 / 0) as failing:
        between = parallel.parallel_map(lambda i: -i, range(4), "between")
        assert first() != os.getpid()
        with pytest.raises(ZeroDivisionError):
            failing()
    assert between == [0, -1, -2, -3]


def test_tasks_in_turn_are_those_that_are_asked_for(two_workers, tmp_path):
    def of(number):
        def task():
            (tmp_path / str(number)).touch()
            return number, os.getpid()

        return task

    results = list(parallel.in_turn([of(number) for number in range(3)]))
    assert [number for number, _ in results] == [0, 1, 2]
    own = os.getpid()
    assert [process == own for _, process in results] == [True, False, True]
    some = parallel.in_turn([of(3), lambda: time.sleep(600), of(5)])
    assert next(some)[0] == 3
    some.close()  # returns without the end of the task under way
    assert not (tmp_path / "5").exists()


STOPPED_WHILE_IT_WRITES = """
import os, pathlib, time
from fmus.support import parallel

parallel.loky.cpu_count = lambda: 2
mark = pathlib.Path(os.environ["MARK"])

class Large:
    def __reduce__(self):
        mark.touch()
        return bytes, (bytes(50_000_000),)

for delay in range(40):
    mark.unlink(missing_ok=True)
    def first():
        while not mark.exists():
            time.sleep(1e-3)
        time.sleep(4e-3 * delay)
    results = parallel.in_turn([first, Large])
    next(results)
    results.close()
print("ended")
"""


@pytest.mark.skipif(sys.platform != "linux", reason="workers are forked on Linux alone")
def test_a_task_that_is_stopped_while_it_writes_its_result_is_not_waited_for(tmp_path):
    """The task is stopped 40 times, 0 to 156 ms after the pickling of 50 MB has begun: in some, while it is written."""
    environment = {**os.environ, "MOTOFMI_START_METHOD": "fork", "MARK": str(tmp_path / "mark")}
    environment.pop("OMP_NUM_THREADS", None)
    command = [sys.executable, "-c", STOPPED_WHILE_IT_WRITES]
    made = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120)
    assert made.stdout == "ended\n", made.stderr


def test_one_processor_computes_in_this_process(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    assert parallel.processes() == 1
    with parallel.in_background(os.getpid) as here:
        assert here() == os.getpid() == parallel.parallel_map(lambda _: os.getpid(), [0, 1], "here")[0]
    done = []
    assert next(parallel.in_turn([lambda: done.append("first"), lambda: done.append("second")])) is None
    assert done == ["first"]


def test_an_unknown_start_method_is_refused(monkeypatch):
    monkeypatch.setenv("MOTOFMI_START_METHOD", "forks")
    with pytest.raises(InputError, match="fork"):
        parallel.start_method()
