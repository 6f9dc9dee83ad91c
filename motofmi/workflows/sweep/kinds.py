"""The kinds of run that a study can have."""

from motofmi.workflows.sweep.modes_runs import ModesRuns
from motofmi.workflows.sweep.system_runs import SystemRuns

KINDS: dict[str, type[SystemRuns]] = {"modes": ModesRuns}
