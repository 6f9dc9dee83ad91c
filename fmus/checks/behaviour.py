"""The behaviour of an FMU in short trial runs, in a separate process, because an FMU may crash or hang.

    python -m fmus.checks.behaviour FOLDER TYPE

runs the unpacked FMU as `CoSimulation` or `ModelExchange` and prints one JSON line before each trial and for each
problem, so that the caller knows which trial a crash belongs to.
"""

import contextlib
import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

import fmpy
import numpy as np
from fmpy.model_description import ModelDescription

from fmus.checks.checked_fmu import TIME_LIMIT, CheckedFmu
from fmus.checks.problem import Problem
from fmus.checks.subject import Subject

try:
    import resource
except ImportError:  # on Windows
    resource = None  # type: ignore[assignment]

STAGE = "run"
KINDS = ("CoSimulation", "ModelExchange")
MEMORY = 8 * 2**30
STEPS = 20


def check(fmu: CheckedFmu) -> list[Problem]:
    """Problems of the FMU when it runs, as each kind that its description has."""
    return [p for kind in KINDS if fmu.root.find(kind) is not None for p in run_as(kind, fmu.folder, fmu.time_limit)]


def run_as(kind: str, folder: Path, time_limit: float = TIME_LIMIT) -> list[Problem]:
    """Problems of the FMU unpacked in a folder when it runs as one kind, also when it crashes or hangs."""
    output, status = _run_apart(
        [sys.executable, "-P", "-m", "fmus.checks.behaviour", str(folder), kind], folder, time_limit
    )
    found, trial = [], "load"
    for line in output.decode("utf-8", "replace").splitlines():
        said = json.loads(line)
        if "trial" in said:
            trial = said["trial"]
        else:
            found.append(Problem(**said))
    if status is None:
        found.append(Problem(trial, "error", f"did not finish within {time_limit:g} s", kind))
    elif trial != "end":
        how = f"crashed with signal {-status}" if status < 0 else f"ended its process with status {status}"
        found.append(Problem(trial, "error", how, kind))
    return found


def _run_apart(command: list[str], folder: Path, time_limit: float) -> tuple[bytes, int | None]:
    """What the command writes, and its status: None when it had to be ended. Processes that it has started end with it.

    Modules are imported from where this process imports them, never from the FMU's folder.
    """
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(os.path.abspath(place) for place in sys.path)}
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, cwd=folder, env=environment, start_new_session=True
    ) as child:
        try:
            output, status = child.communicate(timeout=time_limit)[0], child.returncode
        except subprocess.TimeoutExpired as error:
            output, status = error.stdout or b"", None
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(child.pid, signal.SIGKILL) if hasattr(os, "killpg") else child.kill()
    return output[: output.rfind(b"\n") + 1], status


def trials(description: ModelDescription, folder: str, kind: str) -> Iterator[Problem | str]:
    """The name of each trial, then its problems."""
    subject = Subject(description, folder, kind)
    step = float(description.defaultExperiment.stepSize or 1e-3) if description.defaultExperiment else 1e-3
    can = description.coSimulation if kind == "CoSimulation" else description.modelExchange
    lenient = bool(can.needsExecutionTool)
    yield "load"
    subject.open()
    yield "run"
    first = subject.trajectory(STEPS, step)
    if not np.all(np.isfinite(first)):
        yield Problem("run", "error", "an output is not finite in a short run from the start values", kind)
    subject.reset()
    if subject.trajectory(STEPS, step).tobytes() != first.tobytes():
        yield Problem("reproducible", "error", "a second run after reset gives other numbers", kind)
    if can.canGetAndSetFMUstate:
        yield "state"
        yield from _state(subject, step, bool(can.canSerializeFMUstate))
    if can.providesDirectionalDerivative:
        yield "derivatives"
        yield from _derivatives(subject)
    yield "misuse"
    yield from _misuse(subject, step, lenient)
    subject.close()
    yield "end"


def _state(subject: Subject, step: float, serialises: bool) -> Iterator[Problem]:
    state = subject.save()
    first = subject.trajectory(3, step).tobytes()
    subject.restore(state)
    if subject.trajectory(3, step).tobytes() != first:
        yield Problem(
            "state", "error", "steps after a restored state differ from those after the saved one", subject.kind
        )
    if serialises:
        data = subject.to_bytes(state)
        again = subject.from_bytes(data)
        if subject.to_bytes(again) != data:
            yield Problem(
                "state", "error", "a state written to bytes, read and written again gives other bytes", subject.kind
            )
        subject.restore(again)
        if subject.trajectory(3, step).tobytes() != first:
            yield Problem(
                "state",
                "error",
                "steps after a state read from bytes differ from those after the saved one",
                subject.kind,
            )
        subject.free(again)
    subject.free(state)


def _derivatives(subject: Subject) -> Iterator[Problem]:
    """Directional derivatives against central differences, away from zero where kinks are common."""
    subject.scatter()
    for known in subject.knowns:
        given = subject.get([known])[0]
        change = 1e-4 * max(1.0, abs(given))
        exact = np.array(subject.directional(known))
        ends = []
        for sign in (1, -1):
            subject.put(known, given + sign * change)
            ends.append(subject.get(subject.unknowns))
        subject.put(known, given)
        difference = (ends[0] - ends[1]) / (2 * change)
        # The differences carry the roundings of the values, divided by the change, and the curvature.
        allowed = 1e-3 * np.abs(difference) + 1e-10 * np.abs(ends[0]) / change + 1e-6
        for unknown in np.flatnonzero(np.abs(exact - difference) > allowed):
            names = subject.name(subject.unknowns[unknown]), subject.name(known)
            yield Problem(
                "derivatives",
                "error",
                f"d {names[0]} / d {names[1]} is {exact[unknown]:g}, differences give {difference[unknown]:g}",
                subject.kind,
            )


def _misuse(subject: Subject, step: float, lenient: bool) -> Iterator[Problem]:
    """Calls that an FMU should refuse without a crash; only warnings for FMUs that need an execution tool."""
    for what, was_refused, must in subject.wrong_calls(step):
        subject.recover()
        if not was_refused:
            yield Problem("misuse", "error" if must and not lenient else "warning", f"accepts {what}", subject.kind)


def main(folder: str, kind: str) -> None:
    """Reports through a copy of the standard output; the FMU itself prints to nowhere and has its share of memory."""
    if resource is not None:
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    with os.fdopen(os.dup(1), "w") as reports, open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), 1)
        description = fmpy.read_model_description(folder, validate=False)
        for said in trials(description, folder, kind):
            print(json.dumps(asdict(said) if isinstance(said, Problem) else {"trial": said}), file=reports, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
