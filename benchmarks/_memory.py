"""The peak memory of a benchmark."""

import resource
import sys
from pathlib import Path

STATUS = Path("/proc/self/status")
UNIT = 1.0 if sys.platform == "darwin" else 1024.0  # B, in which getrusage(2) counts


def peak_memory() -> float:
    """The largest resident memory [MB] of this process or of one that it has awaited.

    On Linux ru_maxrss of a started program begins with the peak of the process that started it; VmHWM of proc(5) is
    that of the program alone.
    """
    own, awaited = (resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    if STATUS.exists():
        (own,) = (int(line.split()[1]) for line in STATUS.read_text().splitlines() if line.startswith("VmHWM"))
    return max(own, awaited) * UNIT / 1e6
