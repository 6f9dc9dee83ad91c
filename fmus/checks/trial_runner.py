"""Runs the trials of one FMU: the process between the check and the FMU.

    main(FOLDER, WORK, "KIND,...", TIME, MEMORY, FILE_SIZE)

prints one JSON line for each problem. Each trial has a process and a time of its own and works in the folder WORK;
whatever it leaves behind is ended before the next trial.
"""

import json
import os
import time
from dataclasses import asdict, replace
from pathlib import Path
from xml.etree import ElementTree as Xml

from fmus.checks.checked_fmu import FILE
from fmus.checks.fmi_library import interface
from fmus.checks.model import Model
from fmus.checks.problem import Problem
from fmus.checks.sections import of_call, section
from fmus.checks.trial_process import TRIALS, Place, start
from fmus.support.sandbox import Limits, adopt_orphans, end_descendants, memory_in_use, signal_name

PROVOKED = 0.15  # share of the time for trials with calls that the standard forbids
EXCEEDED = 2  # trials that exceed a limit, after which the others of the kind would do as well
MEMORY_POLL = 0.1  # s
FATAL = "load"  # after an error of this trial no other one of the kind is made


def main(folder: str, work: str, kinds: str, time_limit: str, memory: str, file_size: str) -> None:
    limits = Limits(float(time_limit), int(memory), int(file_size))
    adopt_orphans()
    os.chdir(work)
    model = Model(Xml.parse(Path(folder) / FILE).getroot())
    interface(model.version)
    place = Place(Path(folder), Path(work))
    seen: list[tuple[str, str]] = []
    for kind in kinds.split(","):
        for problem in _trials(kind, place, model, limits):
            # What one trial has reported of a call, the others need not repeat.
            if not any(problem.where == where and problem.message.startswith(message) for message, where in seen):
                seen.append((problem.message, problem.where))
                print(json.dumps(asdict(problem)), flush=True)


def _trials(kind: str, place: Place, model: Model, limits: Limits) -> list[Problem]:
    found: list[Problem] = []
    exceeded = 0
    for name in TRIALS:
        problems, over = _watched(name, kind, place, model, limits)
        found += problems
        exceeded += over
        if exceeded >= EXCEEDED:
            message = f"the trials after this one were not made: {exceeded} have exceeded a limit"
            return [*found, Problem(name, "note", message, kind)]
        if name == FATAL and any(problem.severity == "error" for problem in problems):
            break
    return found


def _watched(name: str, kind: str, place: Place, model: Model, limits: Limits) -> tuple[list[Problem], bool]:
    """The problems that a trial reports, with the one that ended it, and whether it exceeded the time or the memory."""
    severity, current = TRIALS[name].SEVERITY, place.current()
    if severity == "warning":
        limits = replace(limits, time=min(limits.time, max(1.0, PROVOKED * limits.time)))
    current.clear()
    place.report.write_bytes(b"")
    process = start(name, kind, place, model, limits)
    began = looked = time.monotonic()
    memory, wait = 0, 0.0005
    while (
        (status := process.poll()) is None
        and (now := time.monotonic()) - began < limits.time
        and memory <= limits.memory
    ):
        time.sleep(wait)
        wait = min(2 * wait, 0.02)
        if now - looked > MEMORY_POLL:
            memory, looked = memory_in_use(os.getpid()), now
    left = end_descendants()
    if status is None:
        process.wait()
    found, ended = place.problems()
    if status is None or not ended:
        how = _limit(limits, memory) if status is None else _how(status)
        call, log = current.read()
        message = f"{call}: {how}" if call else how
        shown = _how(status) if status is not None else ""
        found.append(Problem(name, severity, message, kind, call, shown, log, of_call(call)))
    elif left:
        message = f"leaves {left} process{'es' * (left > 1)} running after its instance was freed"
        where = section(model.version, "2.1.5", "2.3.1")
        found.append(Problem(name, "warning", message, kind, section=where))
    return found, status is None


def _limit(limits: Limits, memory: int) -> str:
    if memory > limits.memory:
        return f"uses more than {limits.memory / 2**20:.0f} MiB of memory"
    return f"did not finish within {limits.time:g} s"


def _how(status: int) -> str:
    if status < 0:
        return f"crashed with signal {-status} ({signal_name(-status)})"
    return f"ended its process with status {status}"
