"""A problem that a check has found."""

from dataclasses import dataclass

SEVERITIES = ("error", "warning", "note")


@dataclass(frozen=True)
class Problem:
    """Which check found it, its severity, what is wrong and where.

    error      violates the standard, or fails in use
    warning    permitted by the standard, but harmful
    note       what could not be checked, or what a user may want to know

    Where an FMI call shows the problem: its name, the status that it returned and what the FMU logged. section is the
    section of the standard that the FMU violates.
    """

    check: str
    severity: str
    message: str
    where: str
    call: str = ""
    status: str = ""
    log: str = ""
    section: str = ""
