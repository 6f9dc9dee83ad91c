"""The kinds of run that a study can have."""

from motofmi.workflows.sweep.cosimulation_runs import CosimulationRuns
from motofmi.workflows.sweep.frf_runs import FrfRuns
from motofmi.workflows.sweep.linear_runs import LinearRuns
from motofmi.workflows.sweep.modes_runs import ModesRuns
from motofmi.workflows.sweep.system_runs import SystemRuns

KINDS: dict[str, type[SystemRuns]] = {
    "modes": ModesRuns,
    "frf": FrfRuns,
    "cosimulation": CosimulationRuns,
    "linear_systems": LinearRuns,
}
