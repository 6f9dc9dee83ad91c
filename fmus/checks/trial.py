"""What a trial gets: an FMU of one kind, instances of it, and the problem that it reports.

A trial is a module of `fmus.checks.trials` with

    PLACE                      its order among the trials
    SEVERITY                   of a crash or an endless call in it: "error", or "warning" where the trial itself makes
                               calls that the standard forbids to importers
    KINDS                      of FMUs that it is for, where these are not model exchange and co-simulation
    applies(trial) -> bool     whether the FMU can be tried so
    run(trial)                 yields its problems

Each runs in a process of its own, with the limits of the check. A call that fails raises CallFailedError, which
becomes an error that names the call, its status and the FMU's message.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from fmus.checks.callbacks import Callbacks
from fmus.checks.calls import EndedError, FmiCall
from fmus.checks.fmi_library import FmiLibrary
from fmus.checks.instance import TINY, Instance
from fmus.checks.model import Model
from fmus.checks.problem import Problem
from fmus.checks.sections import section
from fmus.checks.simulation import Drive, Run, simulate, step_size, steps


@dataclass
class Trial:
    """One trial of an FMU unpacked in a folder, as one kind; seconds is its share of the time for a simulation."""

    name: str
    model: Model
    kind: str
    folder: Path
    library: FmiLibrary = field(init=False)
    seconds: float = 3.0
    instances: list[Instance] = field(default_factory=list)

    def instance(self, token: str | None = None, callbacks: Callbacks | None = None) -> Instance:
        """A new instance, freed at the end of the trial."""
        made = Instance(self.library, self.model, self.kind, self.folder, token, callbacks)
        self.instances.append(made)
        return made

    def initialised(self) -> Instance:
        made = self.instance()
        made.initialise()
        return made

    def simulate(self, instance: Instance, count: int | None = None, drive: Drive | None = None) -> Run:
        """A run of the default experiment, or of its first steps."""
        most = steps(self.model, self.kind)
        count = most if count is None else min(count, most)
        return simulate(instance, count, step_size(self.model, self.kind), self.seconds, drive)

    def steps(self, instance: Instance, count: int) -> Iterator[int]:
        """Make the first communication steps of the default experiment one by one, to the end that the FMU asks for."""
        step, stop = step_size(self.model, self.kind), instance.start
        stop += steps(self.model, self.kind) * step
        for done in range(count):
            if instance.time + step > stop + TINY * max(1.0, abs(stop)):
                return
            try:
                instance.do_step(step)
            except EndedError:
                return
            yield done

    def flag(self, two: str, three: str) -> bool:
        return self.model.flag(self.kind, two, three)

    def section(self, two: str, three: str) -> str:
        return section(self.model.version, two, three)

    def error(self, message: str, call: FmiCall | None = None, section: str = "") -> Problem:
        return self._problem("error", message, call, section)

    def warning(self, message: str, call: FmiCall | None = None, section: str = "") -> Problem:
        return self._problem("warning", message, call, section)

    def note(self, message: str, call: FmiCall | None = None, section: str = "") -> Problem:
        return self._problem("note", message, call, section)

    def _problem(self, severity: str, message: str, call: FmiCall | None, section: str) -> Problem:
        about = {**(call.about if call else {})}
        if section:
            about["section"] = section
        return Problem(self.name, severity, message, self.kind, **about)
