"""The archive before it is unpacked (see `fmus.support.untrusted_archive`)."""

from fmus.checks.checked_fmu import CheckedFmu
from fmus.checks.problem import Problem
from fmus.support.untrusted_archive import faults

STAGE = "archive"
SECTION = "FMI 2.0.4, 2.3; FMI 3.0, 2.5.1"  # the version is not known yet


def check(fmu: CheckedFmu) -> list[Problem]:
    """Problems of the archive; errors forbid unpacking."""
    return [
        Problem("archive", "warning" if f.harmless else "error", f.message, f.where, section=SECTION)
        for f in faults(fmu.path)
    ]
