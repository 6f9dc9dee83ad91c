"""The tour's wall time, step by step, with an empty cache."""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter


def run(progress) -> dict:
    """Seconds of the whole command and of every step."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "motofmi", "tour", "--out", str(Path(folder) / "out"), "--json", "-"]
        start = perf_counter()
        for _ in progress(range(1), "the tour"):
            done = subprocess.run(
                command, env={**os.environ, "MOTOFMI_CACHE": folder}, capture_output=True, text=True, check=True
            )
        seconds = perf_counter() - start
    return {"seconds": seconds, "steps": {step["name"]: step["seconds"] for step in json.loads(done.stdout)["steps"]}}
