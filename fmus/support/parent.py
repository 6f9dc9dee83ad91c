"""A process that ends when the process that started it ends, also when that one is killed."""

import ctypes
import os
import signal
import sys
import threading
import time
from contextlib import suppress

import psutil

PR_SET_PDEATHSIG = 1  # linux/prctl.h
POLL = 0.2  # s


def end_with(parent: int) -> None:
    """End this process when its parent ends; at once if that has ended already.

    On Linux the system does so, when the thread that started this process ends; elsewhere a thread of this process.
    """
    if sys.platform != "linux":
        watch(parent)
        return
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    if os.getppid() != parent:
        os._exit(1)


def watch(parent: int) -> None:
    """End this process by a thread of its own when its parent ends."""
    threading.Thread(target=_end_after, args=(parent,), daemon=True).start()


def _end_after(parent: int) -> None:
    if os.name == "posix":  # an orphan has another parent at once, also while the killed process is a zombie
        while os.getppid() == parent:
            time.sleep(POLL)
    else:
        with suppress(psutil.NoSuchProcess):
            psutil.Process(parent).wait()
    os._exit(1)
