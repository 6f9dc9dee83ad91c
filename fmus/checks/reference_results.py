"""Reference results in the archive (layered standard FMI-LS-REF), replayed on this machine.

The replay (`fmus.checks.replay.replayed`) runs in a process of its own, with the limits of the check.
"""

import json
import os
import sys
import tempfile

from fmus.checks.checked_fmu import CheckedFmu
from fmus.checks.problem import Problem
from fmus.export.reference_folder import FOLDER, MANIFEST, REPLAY
from fmus.support.sandbox import ONE_THREAD, run_limited

STAGE = "replay"
INSIDE = """from fmus.support.sandbox import enter_sandbox
enter_sandbox()
import sys
from fmus.checks.replay.replayed import inside
inside(sys.argv[1])
"""


def check(fmu: CheckedFmu) -> list[Problem]:
    """Problems of the reference results of an FMU for co-simulation; [] for an archive without any."""
    if not (fmu.folder / MANIFEST).is_file() or fmu.root.find("CoSimulation") is None:
        return []
    modules = os.pathsep.join(os.path.abspath(place) for place in sys.path)
    command = [sys.executable, "-P", "-c", INSIDE, str(fmu.folder)]
    with tempfile.TemporaryDirectory(prefix="replay-", ignore_cleanup_errors=True) as work:
        done = run_limited(command, fmu.limits, {**ONE_THREAD, "PYTHONPATH": modules, "TMPDIR": work}, cwd=work)
    lines = done.output.decode("utf-8", "replace").splitlines()
    found = [Problem(**json.loads(line)) for line in lines if line.startswith('{"check"')]
    if done.status != 0:
        how = (
            f"did not finish within {fmu.limits.time:g} s"
            if done.status is None
            else f"ended early: status {done.status}"
        )
        found.append(Problem(REPLAY, "error", f"the replay {how}", FOLDER))
    return found
