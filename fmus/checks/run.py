"""The FMU in short trial runs, apart from this process: an FMU may crash, hang, or start processes of its own.

See `fmus.checks.trials` for the trials and `fmus.checks.trial_runner` for the process that makes them.
"""

import json
import os
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

from fmus.checks.checked_fmu import CheckedFmu
from fmus.checks.problem import Problem
from fmus.support.sandbox import ONE_THREAD, Limits, run_limited

STAGE = "run"
TRIALS = 40  # an upper bound of the trials of a kind, for the time of them all


def check(fmu: CheckedFmu) -> list[Problem]:
    """Problems of the FMU when it runs, as each kind that its description has."""
    found = []
    if "ScheduledExecution" in fmu.model.kinds:
        found.append(
            Problem(
                "run",
                "note",
                "scheduled execution is run without preemption, which needs the importer's own tasks",
                "ScheduledExecution",
                section=fmu.section("", "5.1.2"),
            )
        )
    kinds = fmu.model.kinds
    return found + (run_as(kinds, fmu.folder, fmu.limits, _needs_network(fmu)) if kinds else [])


def _needs_network(fmu: CheckedFmu) -> bool:
    """An FMU that needs another tool may reach it over the network."""
    return any(fmu.model.flag(kind, "needsExecutionTool", "needsExecutionTool") for kind in fmu.model.kinds)


def run_as(kinds: list[str], folder: Path, limits: Limits, network: bool = False) -> list[Problem]:
    """Problems of the FMU unpacked in a folder when it runs as these kinds, also when it crashes or hangs.

    Modules are imported from where this process imports them, never from the FMU's folder.
    """
    with tempfile.TemporaryDirectory(prefix="trials-", ignore_cleanup_errors=True) as work:
        code = f"from fmus.support.sandbox import enter_sandbox; enter_sandbox(network={network}); "
        code += "import sys; from fmus.checks.trial_runner import main; main(*sys.argv[1:])"
        command = [sys.executable, "-P", "-c", code, str(folder), work, ",".join(kinds)]
        command += [str(limits.time), str(limits.memory), str(limits.file_size)]
        environment = {
            **ONE_THREAD,
            "PYTHONPATH": os.pathsep.join(os.path.abspath(place) for place in sys.path),
            "TMPDIR": work,
        }
        whole = replace(limits, time=(limits.time + 5) * TRIALS * len(kinds), memory=2 * limits.memory)
        done = run_limited(command, whole, environment, cwd=work)
    lines = done.output[: done.output.rfind(b"\n") + 1].decode("utf-8", "replace").splitlines()
    found = [Problem(**json.loads(line)) for line in lines]
    if done.status != 0:
        how = "ended the process that watches it" if done.status is not None else "did not finish within its limits"
        found.append(Problem("run", "error", how, ", ".join(kinds)))
    return found
