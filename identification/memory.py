"""How much memory this process may still take: the smallest of what the machine, its container and the user allow."""

from pathlib import Path

try:
    import resource
except ImportError:  # Windows has no such limits
    resource = None  # type: ignore[assignment]

GROUP = Path("/sys/fs/cgroup")  # of a container, control groups version 2


def available_memory() -> float:
    """Bytes that can still be allocated; infinite where nothing is known."""
    return max(0.0, min(_of_the_machine(), _of_the_container(), _of_the_user()))


def _of_the_machine() -> float:
    return 1024 * _entry(Path("/proc/meminfo"), "MemAvailable:")


def _of_the_container() -> float:
    limit, used = GROUP / "memory.max", GROUP / "memory.current"
    if not (limit.exists() and used.exists()) or limit.read_text().strip() == "max":
        return float("inf")
    files = _entry(GROUP / "memory.stat", "inactive_file")  # the cache of files makes room when asked
    return float(limit.read_text()) - float(used.read_text()) + (files if files < float("inf") else 0.0)


def _of_the_user() -> float:
    pages = Path("/proc/self/statm")
    if resource is None or not pages.exists():
        return float("inf")
    total, _, _, _, _, data, _ = (int(n) * resource.getpagesize() for n in pages.read_text().split())
    limits = [(resource.getrlimit(resource.RLIMIT_AS)[0], total), (resource.getrlimit(resource.RLIMIT_DATA)[0], data)]
    return min((limit - taken for limit, taken in limits if limit != resource.RLIM_INFINITY), default=float("inf"))


def _entry(path: Path, name: str) -> float:
    """The number behind a name in a file of such lines; infinite where there is none."""
    if path.exists():
        for line in path.read_text().splitlines():
            if line.split()[0] == name:
                return float(line.split()[1])
    return float("inf")
