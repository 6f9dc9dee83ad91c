"""Limits for a process that runs code of others: time, memory, file size, no network, no process left behind.

What the system does not offer is left out: resource limits exist on Linux and macOS, network namespaces and the
adoption of orphans on Linux. Files of the user remain readable and writable: this is no protection against malice.
"""

import contextlib
import ctypes
import os
import secrets
import signal
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import psutil

from fmus.support.parent import end_with

try:
    import fcntl
    import resource
except ImportError:  # on Windows
    fcntl = resource = None  # type: ignore[assignment]

# An environment variable that processes inherit, by which they are found again: the process that started the first of
# them, and a random word.
MARK = "MOTOFMI_SANDBOX"
CLONE_NEWUSER, CLONE_NEWNET, PR_SET_CHILD_SUBREAPER = 0x10000000, 0x40000000, 36  # linux/sched.h, linux/prctl.h
SIOCGIFFLAGS, SIOCSIFFLAGS, IFF_UP = 0x8913, 0x8914, 1  # linux/sockios.h, linux/if.h
POLL = 0.5  # s, between two looks at the memory in use
ONE_THREAD = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL")}  # namespaces need a single thread


@dataclass(frozen=True)
class Limits:
    """Wall-clock time [s], memory in use [bytes] and size of a written file [bytes].

    The processor time is limited to the time on every core; the address space, which programs reserve without use,
    to eight times the memory.
    """

    time: float = 60.0
    memory: int = 4 * 2**30
    file_size: int = 2**30


def enter_sandbox(network: bool = False) -> None:
    """The first call in a process of `run_limited`, while it has one thread: it leaves the network, and ends with the
    process that started it."""
    if not network:
        leave_network()
    end_with(int(os.environ[MARK].partition("-")[0]))


def limit_resources(limits: Limits) -> None:
    """Apply the limits that the system itself keeps to this process and those that it starts."""
    if resource is None:
        return
    signal.signal(signal.SIGXFSZ, signal.SIG_DFL)  # Python ignores it: a write would fail without end
    seconds = int(limits.time * (os.cpu_count() or 1)) + 1
    for name, value in (("AS", 8 * limits.memory), ("CPU", seconds), ("FSIZE", limits.file_size), ("CORE", 0)):
        with contextlib.suppress(ValueError, OSError):  # above the hard limit of this process
            resource.setrlimit(getattr(resource, f"RLIMIT_{name}"), (value, value))


def adopt_orphans() -> None:
    """On Linux: processes whose parent has ended become children of this process, whatever their session."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def leave_network() -> bool:
    """On Linux, where the system permits it: no network but a loopback of its own. For a process with one thread."""
    if sys.platform != "linux":
        return False
    user, group = os.getuid(), os.getgid()
    if ctypes.CDLL(None).unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0:
        return False
    with contextlib.suppress(OSError):
        for name, text in (("setgroups", "deny"), ("uid_map", f"{user} {user} 1"), ("gid_map", f"{group} {group} 1")):
            with open(f"/proc/self/{name}", "w") as file:
                file.write(text)
    with contextlib.suppress(OSError), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as link:
        request = struct.pack("16sh", b"lo", 0)
        flags = struct.unpack("16sh", fcntl.ioctl(link, SIOCGIFFLAGS, request))[1]
        fcntl.ioctl(link, SIOCSIFFLAGS, struct.pack("16sh", b"lo", flags | IFF_UP))
    return True


def end_descendants(process: psutil.Process | None = None) -> int:
    """End everything that a process (default: this one) has started; how many processes that were."""
    ended: set[int] = set()
    if process is None and _childless():
        return 0
    with contextlib.suppress(psutil.Error):
        parent = process or psutil.Process()
        while found := [child for child in parent.children(recursive=True) if child.status() != psutil.STATUS_ZOMBIE]:
            _end(found)
            ended.update(child.pid for child in found)
    _childless()
    return len(ended)


def memory_in_use(pid: int) -> int:
    """Memory [bytes] that a process and its descendants do not share with others."""
    total = 0
    with contextlib.suppress(psutil.Error):
        parent = psutil.Process(pid)
        for process in (parent, *parent.children(recursive=True)):
            with contextlib.suppress(psutil.Error):
                total += process.memory_full_info().uss
    return total


@dataclass(frozen=True)
class Outcome:
    """The output of a process, and its status; status is None when the process exceeded the time, and a memory that
    was exceeded [bytes] is given instead."""

    output: bytes
    status: int | None
    memory: int | None = None


def run_limited(
    command: Sequence[str],
    limits: Limits,
    environment: Mapping[str, str] | None = None,
    cwd: str | None = None,
    show_errors: bool = False,
) -> Outcome:
    """Run a command until it ends or exceeds a limit. Whatever it has started ends with it, also in other sessions.

    Its standard error is shown or dropped.
    """
    mark = f"{os.getpid()}-{secrets.token_hex(8)}"
    variables = {**os.environ, **(environment or {}), MARK: mark}
    errors = None if show_errors else subprocess.DEVNULL
    pipe = subprocess.PIPE
    with subprocess.Popen(
        command, stdout=pipe, stderr=errors, cwd=cwd, env=variables, start_new_session=True
    ) as child:
        began, written, memory, ended = time.monotonic(), None, None, False
        try:
            while not ended and memory is None and (left := began + limits.time - time.monotonic()) > 0:
                try:
                    written = child.communicate(timeout=min(left, POLL))[0]
                    ended = True
                except subprocess.TimeoutExpired:
                    ended = child.poll() is not None  # what it has started may hold its output open
                if not ended and (used := memory_in_use(child.pid)) > limits.memory:
                    memory = used
        finally:
            _end_all(child, mark)
            if written is None:
                written = child.communicate()[0]
    return Outcome(written or b"", child.returncode if ended else None, memory)


def _end_all(child: subprocess.Popen[bytes], mark: str) -> None:
    with contextlib.suppress(psutil.Error):
        end_descendants(psutil.Process(child.pid))
    if child.poll() is None:
        child.kill()
    for _ in range(10):  # a process may start another one while it is ended
        found = [process for process in psutil.process_iter() if process.pid != os.getpid() and _marked(process, mark)]
        if not found:
            return
        _end(found)


def _marked(process: psutil.Process, mark: str) -> bool:
    try:
        return process.status() != psutil.STATUS_ZOMBIE and process.environ().get(MARK) == mark
    except (psutil.Error, OSError, UnicodeError):
        return False


def _end(processes: Sequence[psutil.Process]) -> None:
    """Stop all before the first is ended, so that none starts a successor."""
    for word in ("suspend", "kill"):
        for process in processes:
            with contextlib.suppress(psutil.Error, OSError):
                getattr(process, word)()
    psutil.wait_procs(list(processes), timeout=2)


def _childless() -> bool:
    """Whether this process has no child, adopted ones too; ended ones are collected."""
    if os.name == "nt":
        return False
    try:
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass
    except ChildProcessError:
        return True
    return False


def signal_name(number: int) -> str:
    """`SIGSEGV` of 11; the number where the signal has no name."""
    try:
        return signal.Signals(number).name
    except ValueError:
        return str(number)
