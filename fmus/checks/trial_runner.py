"""Runs the trials of one FMU: the process between the check and the FMU.

    python -m fmus.checks.trial_runner FOLDER WORK KIND,... NETWORK TIME MEMORY FILE_SIZE

prints one JSON line for each problem. Each trial runs in a process of its own, a copy of this one where the system has
`fork`, with the working folder WORK and its own time; whatever it leaves behind is ended before the next trial.
"""

import contextlib
import json
import os
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, replace
from pathlib import Path
from xml.etree import ElementTree as Xml

from fmus.checks.checked_fmu import FILE
from fmus.checks.current_call import CurrentCall
from fmus.checks.fmi_library import FmiLibrary, interface
from fmus.checks.host import host_folder, library_suffix
from fmus.checks.instance import CallFailedError, EndedError
from fmus.checks.model import Model
from fmus.checks.problem import Problem
from fmus.checks.sections import of_call, section
from fmus.checks.trial import Trial
from fmus.support.modules import modules_in
from fmus.support.sandbox import Limits, adopt_orphans, end_descendants, limit_resources, memory_in_use, signal_name

PROVOKED = 0.15  # share of the time for trials with calls that the standard forbids
MEMORY_POLL = 0.1  # s
TRIALS = sorted(modules_in("fmus.checks.trials"), key=lambda module: module.PLACE)
FATAL = ("load",)  # after an error of these no other trial of the kind is made
END = {"end": True}


def main(folder: str, work: str, kinds: str, time_limit: str, memory: str, file_size: str) -> None:
    limits = Limits(float(time_limit), int(memory), int(file_size))
    adopt_orphans()
    os.chdir(work)
    model = Model(Xml.parse(Path(folder) / FILE).getroot())
    interface(model.version)
    for kind in kinds.split(","):
        for module in TRIALS:
            name = module.__name__.rpartition(".")[2]
            found = list(_watched(name, module.SEVERITY, Path(folder), Path(work), kind, model, limits))
            for problem in found:
                print(json.dumps(asdict(problem)), flush=True)
            if name in FATAL and any(problem.severity == "error" for problem in found):
                break


def _watched(
    name: str, severity: str, folder: Path, work: Path, kind: str, model: Model, limits: Limits
) -> Iterator[Problem]:
    """The problems that a trial reports, and the one that ended it."""
    current, report = CurrentCall(work / "call"), work / "report"
    if severity == "warning":
        limits = replace(limits, time=PROVOKED * limits.time)
    current.clear()
    report.write_bytes(b"")
    poll, end = _started(name, folder, report, kind, model, current, limits)
    began = looked = time.monotonic()
    status, memory, wait = None, 0, 0.0005
    while (status := poll()) is None and (now := time.monotonic()) - began < limits.time and memory <= limits.memory:
        time.sleep(wait)
        wait = min(2 * wait, 0.02)
        if now - looked > MEMORY_POLL:
            memory, looked = memory_in_use(os.getpid()), now
    left = end_descendants()
    if status is None:
        end()
    lines = [json.loads(line) for line in report.read_bytes().splitlines() if line.endswith(b"}")]
    yield from (Problem(**line) for line in lines if line != END)
    call, log = current.read()
    about = {"call": call, "log": log, "section": of_call(call)}
    doing = f"{call}: " if call else ""
    if memory > limits.memory:
        yield Problem(name, severity, f"{doing}uses more than {limits.memory / 2**20:.0f} MiB of memory", kind, **about)
    elif status is None:
        yield Problem(name, severity, f"{doing}did not finish within {limits.time:g} s", kind, **about)
    elif END not in lines:
        yield Problem(name, severity, doing + _how(status), kind, status=_how(status), **about)
    elif left:
        yield Problem(name, "warning", f"leaves {left} process{'es' * (left > 1)} running after its instance was freed", kind,
                      section=section(model.version, "2.1.5", "2.3.1"))  # fmt: skip


def _how(status: int) -> str:
    if status < 0:
        return f"crashed with signal {-status} ({signal_name(-status)})"
    return f"ended its process with status {status}"


def _started(
    name: str, folder: Path, report: Path, kind: str, model: Model, current: CurrentCall, limits: Limits
) -> tuple[Callable[[], int | None], Callable[[], object]]:
    """Start a trial in a process; a function that returns its status once it has ended, and one that ends it."""
    if not hasattr(os, "fork"):
        import subprocess  # noqa: PLC0415 - on Windows

        code = "import sys; from fmus.checks.trial_runner import alone; alone(*sys.argv[1:])"
        child = subprocess.Popen([sys.executable, "-P", "-c", code, name, str(folder), str(report), kind])
        return child.poll, child.kill
    process = os.fork()
    if not process:
        limit_resources(limits)
        _perform(name, folder, report, kind, model, current)

    def poll() -> int | None:
        ended, status = os.waitpid(process, os.WNOHANG)
        return os.waitstatus_to_exitcode(status) if ended else None

    def end() -> None:
        with contextlib.suppress(ChildProcessError):
            os.waitpid(process, 0)

    return poll, end


def alone(name: str, folder: str, report: str, kind: str) -> None:
    """A trial in a process that was not copied from the runner."""
    model = Model(Xml.parse(Path(folder) / FILE).getroot())
    _perform(name, Path(folder), Path(report), kind, model, CurrentCall(Path(report).parent / "call"))


def _perform(name: str, folder: Path, report: Path, kind: str, model: Model, current: CurrentCall) -> None:
    """Make a trial and end the process. The FMU prints to nowhere."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    for descriptor in (0, 1, 2):
        os.dup2(nowhere, descriptor)
    with report.open("w") as reports:
        for problem in _problems(name, folder, kind, model, current):
            print(json.dumps(asdict(problem)), file=reports, flush=True)
        print(json.dumps(END), file=reports, flush=True)
    os._exit(0)


def _problems(name: str, folder: Path, kind: str, model: Model, current: CurrentCall) -> Iterator[Problem]:
    module = next(m for m in TRIALS if m.__name__.rpartition(".")[2] == name)
    trial = Trial(name, model, kind, folder)
    try:
        identifier = str(getattr(model.root.find(kind), "attrib", {}).get("modelIdentifier"))
        library = folder / "binaries" / host_folder(model.version) / (identifier + library_suffix())
        trial.library = FmiLibrary(model.version, library, current)
        if module.applies(trial):
            yield from module.run(trial)
            for instance in trial.instances:
                instance.close()
    except CallFailedError as failed:
        yield trial.error(failed.message, failed.call)
    except EndedError:
        yield trial.note("the FMU asks for the end of the simulation, so this trial was not completed")
    except OSError as error:
        yield trial.error(f"cannot be loaded: {str(error).removeprefix(f'cannot load library {library!s}: ')}".replace(f"{folder}/", ""),
                          section=trial.section("2.1.1", "2.2.2"))  # fmt: skip
    except Exception as error:  # a fault of the check is not the FMU's
        yield trial.note(f"the trial could not be made: {type(error).__name__}: {error}")


if __name__ == "__main__":
    main(*sys.argv[1:])
