"""One trial in the process of its own: what runs there, and how it is started.

The process is a copy of the runner where the system has `fork`, else a new one. It writes its problems to a file,
because an FMU may print, and ends with a line that says so.
"""

import contextlib
import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from xml.etree import ElementTree as Xml

from fmus.checks.calls import CallFailedError, EndedError
from fmus.checks.checked_fmu import FILE
from fmus.checks.current_call import CurrentCall
from fmus.checks.fmi_library import FmiLibrary
from fmus.checks.host import host_folder, library_suffix
from fmus.checks.model import Model
from fmus.checks.problem import Problem
from fmus.checks.trial import Trial
from fmus.support.modules import modules_in
from fmus.support.parent import end_with
from fmus.support.sandbox import Limits, limit_resources

TRIALS = {m.__name__.rpartition(".")[2]: m for m in sorted(modules_in("fmus.checks.trials"), key=lambda m: m.PLACE)}
KINDS = ("ModelExchange", "CoSimulation")  # of FMUs that a trial is for, where it names no others
END = {"end": True}
ALONE = "import sys; from fmus.checks.trial_process import alone; alone(*sys.argv[1:])"


@dataclass
class Place:
    """Where a trial takes place: the unpacked FMU, and the working folder of its process."""

    folder: Path
    work: Path

    @property
    def report(self) -> Path:
        return self.work / "report"

    def current(self) -> CurrentCall:
        return CurrentCall(self.work / "call")

    def problems(self) -> tuple[list[Problem], bool]:
        """The problems that were written, and whether the trial came to its end."""
        lines = [json.loads(line) for line in self.report.read_bytes().splitlines() if line.endswith(b"}")]
        return [Problem(**line) for line in lines if line != END], END in lines


@dataclass
class Started:
    """A process: poll gives its status once it has ended; wait collects it after it was killed."""

    poll: Callable[[], int | None]
    wait: Callable[[], object]


def start(name: str, kind: str, place: Place, model: Model, limits: Limits) -> Started:
    """Start a trial."""
    if not hasattr(os, "fork"):
        child = subprocess.Popen([sys.executable, "-P", "-c", ALONE, name, kind, str(place.folder), str(place.work)])
        return Started(child.poll, child.kill)
    runner = os.getpid()
    process = os.fork()
    if not process:
        end_with(runner)
        limit_resources(limits)
        _perform(name, kind, place, model)

    def poll() -> int | None:
        ended, status = os.waitpid(process, os.WNOHANG)
        return os.waitstatus_to_exitcode(status) if ended else None

    def wait() -> None:
        with contextlib.suppress(ChildProcessError):
            os.waitpid(process, 0)

    return Started(poll, wait)


def alone(name: str, kind: str, folder: str, work: str) -> None:
    """A trial in a process that is no copy of the runner."""
    end_with(os.getppid())
    model = Model(Xml.parse(Path(folder) / FILE).getroot())
    _perform(name, kind, Place(Path(folder), Path(work)), model)


def _perform(name: str, kind: str, place: Place, model: Model) -> None:
    """Make a trial and end the process. The FMU prints to nowhere."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    for descriptor in (0, 1, 2):
        os.dup2(nowhere, descriptor)
    with place.report.open("w") as reports:
        for problem in problems_of(name, kind, place, model):
            print(json.dumps(asdict(problem)), file=reports, flush=True)
        print(json.dumps(END), file=reports, flush=True)
    os._exit(0)


def problems_of(name: str, kind: str, place: Place, model: Model) -> Iterator[Problem]:
    """The problems of a trial in this process."""
    module, trial = TRIALS[name], Trial(name, model, kind, place.folder)
    try:
        identifier = str(getattr(model.root.find(kind), "attrib", {}).get("modelIdentifier"))
        library = place.folder / "binaries" / host_folder(model.version) / (identifier + library_suffix())
        trial.library = FmiLibrary(model.version, library, place.current())
        if kind in getattr(module, "KINDS", KINDS) and module.applies(trial):
            yield from module.run(trial)
            for instance in trial.instances:
                instance.close()
    except CallFailedError as failed:
        yield trial.error(failed.message, failed.call)
    except EndedError:
        yield trial.note("the FMU asks for the end of the simulation, so that this trial was not completed")
    except OSError as error:
        reason = str(error).replace(f"cannot load library '{library}': ", "").replace(f"{place.folder}/", "")
        reason = reason.partition(".  Additionally, ")[0]  # that cffi has not found a library of this name elsewhere
        yield trial.error(f"cannot be loaded: {reason}", section=trial.section("2.1.1", "2.2.2"))
    except Exception as error:  # a fault of the check is not the FMU's
        yield trial.note(f"the trial could not be made: {type(error).__name__}: {error}")
