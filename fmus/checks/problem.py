"""A problem that a check has found."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Problem:
    """Which check found it, how bad it is (`error` or `warning`), what is wrong, and where."""

    check: str
    severity: str
    message: str
    where: str
