"""A command that runs code of others, in a process with limits: its result comes back as JSON.

What the limits are, and what they cannot prevent: docs/check.md.
"""

import argparse
import importlib
import json
import os
import pickle
import sys
import tempfile
from pathlib import Path
from typing import Any

from fmus.support.errors import InputError, MissingToolError, SimulationError
from fmus.support.files import files_written, note_written, write_text
from fmus.support.plain_json import to_json
from fmus.support.sandbox import Limits, Outcome, limit_resources, run_limited, signal_name

LIMITS = Limits(time=3600.0)
ERRORS = {error.__name__: error for error in (InputError, MissingToolError, SimulationError)}
# The network is left before anything else is imported, while the process has one thread.
INSIDE = """from fmus.support.sandbox import enter_sandbox
enter_sandbox()
from motofmi.cli.sandboxed import inside
inside()
"""


def run_sandboxed(command: str, arguments: argparse.Namespace, limits: Limits = LIMITS) -> dict[str, Any]:
    """The result of `run(arguments)` of a command's module.

    Raises the errors that the command raises, and SimulationError when the process exceeds a limit or crashes.
    """
    with tempfile.TemporaryDirectory(prefix="sandbox-") as folder:
        task, answer = Path(folder) / "task", Path(folder) / "answer.json"
        task.write_bytes(pickle.dumps((command, arguments, limits)))
        words = [sys.executable, "-P", "-c", INSIDE, str(task), str(answer)]
        modules = os.pathsep.join(map(os.path.abspath, sys.path))
        outcome = run_limited(words, limits, {"PYTHONPATH": modules}, show_errors=True)
        if outcome.status != 0 or not answer.is_file():
            raise SimulationError(f"the sandboxed process {_reason(outcome, limits)}; the FMU cannot be used in it")
        found = json.loads(answer.read_text("utf-8"))
    if "error" in found:
        raise ERRORS[found["error"]](found["message"])
    for path in found["files"]:
        note_written(path)
    return dict(found["result"])


def inside() -> None:
    """The other side: computes the result of the task in the file argv[1] and writes it to argv[2]."""
    command, arguments, limits = pickle.loads(Path(sys.argv[1]).read_bytes())
    limit_resources(limits)
    try:
        with files_written() as written:
            result = importlib.import_module(command).run(arguments)
        found = {"result": result, "files": [str(path) for path in written]}
    except tuple(ERRORS.values()) as error:
        found = {"error": type(error).__name__, "message": str(error)}
    write_text(Path(sys.argv[2]), to_json(found))


def _reason(outcome: Outcome, limits: Limits) -> str:
    if outcome.memory is not None:
        return f"used more than {limits.memory / 2**20:.0f} MiB of memory"
    if outcome.status is None:
        return f"did not finish within {limits.time:g} s"
    if outcome.status < 0:
        return f"crashed with signal {-outcome.status} ({signal_name(-outcome.status)})"
    return f"ended with status {outcome.status}"
