"""How much memory this process may still take: the smallest of what the machine, its container and the user allow."""

import os
from pathlib import Path

try:
    import resource
except ImportError:  # Windows has no such limits
    resource = None  # type: ignore[assignment]


def available_memory() -> float:
    """Bytes that can still be allocated; infinite where nothing is known."""
    left = [float("inf")]
    if hasattr(os, "sysconf") and "SC_AVPHYS_PAGES" in os.sysconf_names:
        left.append(os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    group, used = Path("/sys/fs/cgroup/memory.max"), Path("/sys/fs/cgroup/memory.current")
    if group.exists() and used.exists() and (limit := group.read_text().strip()) != "max":
        left.append(float(limit) - float(used.read_text()))
    pages = Path("/proc/self/statm")
    if resource is not None and pages.exists():
        total, _, _, _, _, data, _ = (int(n) * resource.getpagesize() for n in pages.read_text().split())
        for kind, taken in ((resource.RLIMIT_AS, total), (resource.RLIMIT_DATA, data)):
            allowed = resource.getrlimit(kind)[0]
            if allowed != resource.RLIM_INFINITY:
                left.append(allowed - taken)
    return max(0.0, min(left))
