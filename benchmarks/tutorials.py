"""How long a tutorial takes: the words of its page at 200 a minute, and the processor time of what it shows.

The code is run as a reader runs it, in its order, in an empty folder; the notebooks likewise.
"""

import json
import os
import re
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "docs" / "tutorials"
WORDS_PER_MINUTE = 200
BLOCK = re.compile(r"^```(\{code-cell\}|sh)\n(?::[^\n]*\n)*(.*?)^```", re.MULTILINE | re.DOTALL)
HEAD = re.compile(r"\A---\n.*?\n---\n", re.DOTALL)


def pages() -> list[Path]:
    """The tutorials and notebooks."""
    found = [*FOLDER.glob("*.md"), *(FOLDER / "notebooks").glob("*.ipynb")]
    return sorted(path for path in found if path.stem != "index")


def run(progress: Callable) -> dict:
    """For each page its words, its minutes of reading, and the processor seconds of its code."""
    return {path.stem: _measured(path) for path in progress(pages(), "tutorials")}


def content(path: Path) -> tuple[str, list[str]]:
    """The text of a page with its code, as it is read, and the cells to run."""
    if path.suffix == ".ipynb":
        cells = json.loads(path.read_text("utf-8"))["cells"]
        text = "\n".join("".join(cell["source"]) for cell in cells)
        return text, ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    text = HEAD.sub("", path.read_text("utf-8"))
    return text, [f"%%bash\nset -eu\n{code}" if kind == "sh" else code for kind, code in BLOCK.findall(text)]


def _measured(path: Path) -> dict:
    text, cells = content(path)
    words = len(re.findall(r"\w+(?:[.'/-]\w+)*", text))
    return {"words": words, "reading_minutes": words / WORDS_PER_MINUTE, "running_seconds": _run_time(cells)}


def _run_time(cells: list[str]) -> float:
    """Processor time [s] of the cells, with the start of Python. Raises RuntimeError where one fails."""
    empty = {"cell_type": "code", "metadata": {}, "outputs": [], "execution_count": None}
    code = [{**empty, "source": cell} for cell in ("%matplotlib agg", *cells)]
    with tempfile.TemporaryDirectory() as folder:
        book = Path(folder) / "followed.ipynb"
        book.write_text(json.dumps({"cells": code, "metadata": {}, "nbformat": 4, "nbformat_minor": 5}))
        bare = {**os.environ, "PYTHONPATH": str(ROOT), "IPYTHONDIR": folder, "MOTOFMI_CACHE": f"{folder}/cache"}
        began = _processor_time()
        done = subprocess.run([sys.executable, "-m", "IPython", "--colors=NoColor", str(book)], cwd=folder, env=bare,
                              capture_output=True, text=True, check=False)  # fmt: skip
        seconds = _processor_time() - began
    if done.returncode or "Traceback" in done.stdout + done.stderr:
        raise RuntimeError(f"a tutorial fails: {(done.stdout + done.stderr)[-2000:]}")
    return seconds


def _processor_time() -> float:
    """Of the processes that have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
