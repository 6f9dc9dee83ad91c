"""Runs studies by name, keeps their results, and renders the numbers and tables of the pages that show them."""

import argparse
import datetime
import importlib
import json
import os
import pkgutil
import platform
import sys
from pathlib import Path
from typing import Any

import benchmarks
from benchmarks._pages import render
from benchmarks._recordings import DATA
from fmus.support.progress import track

RESULTS = Path(__file__).parent / "results.json"


def studies() -> list[str]:
    """The names of all studies."""
    return sorted(m.name for m in pkgutil.iter_modules(benchmarks.__path__) if not m.name.startswith("_"))


def machine() -> dict[str, Any]:
    """What the numbers depend on besides the code."""
    model = next((line.split(":")[1].strip() for line in Path("/proc/cpuinfo").read_text().splitlines()
                  if line.startswith("model name")), platform.processor()) if Path("/proc/cpuinfo").exists() else platform.processor()  # fmt: skip
    return {
        "processor": model,
        "cores": os.cpu_count(),
        "system": platform.system(),
        "python": platform.python_version(),
    }


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument(
        "names", nargs="*", metavar="NAME", help=f"studies to run (default: all): {', '.join(studies())}"
    )
    parser.add_argument("--json", metavar="FILE", help="write these results there as well; - for standard output")
    parser.add_argument("--render", action="store_true", help="run no study, only render the numbers and tables of docs/")
    parser.add_argument(
        "--data", metavar="DIR", help=f"folder of recordings of others (default: environment variable {DATA})"
    )
    arguments = parser.parse_args()
    for name in arguments.names:
        if name not in studies():
            parser.error(f"unknown study {name!r} (valid: {', '.join(studies())})")
    if arguments.data:
        os.environ[DATA] = arguments.data
    if arguments.render:
        print(*render(json.loads(RESULTS.read_text())), sep="\n")
        return
    measured = {}
    for name in arguments.names or studies():
        print(f"{name} ...", file=sys.stderr)
        result = importlib.import_module(f"benchmarks.{name}").run(track)
        measured[name] = {"date": datetime.date.today().isoformat(), "machine": machine(), **result}
        if set(result) == {"skipped"}:  # no data: the results of an earlier run stay
            continue
        kept = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
        kept[name] = measured[name]
        RESULTS.write_text(json.dumps(kept, indent=1) + "\n")
        render(kept)
    text = json.dumps(measured, indent=1)
    if arguments.json and arguments.json != "-":
        Path(arguments.json).write_text(text + "\n")
    else:
        print(text)


if __name__ == "__main__":
    main()
