"""Which effect is named in recordings of real machines, how accurate its value is, and how long it takes.

    python -m benchmarks.gap_recordings --data measured --out rows.json
    python -m benchmarks --render                             # the tables of docs/ from what is kept

Every recording of `benchmarks/_recordings.py` is given to the command `motofmi gap`, in both ways where there are two
(force in, displacement imposed). The seconds are those of the whole command, with model, FMU and report; the processor
seconds are summed over its processes. The table of docs/gap.md is `table` of what is kept in results.json.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks._recordings import DATA, SOURCES, Source, folder_of_data, missing
from fmus.support.progress import track

INTERVAL = 1.96  # standard errors of a 95 % interval


def run(
    progress: Callable[..., Iterable] = track,
    data: str | Path | None = None,
    sources: Sequence[str] = tuple(SOURCES),
    out: str | Path | None = None,
) -> dict[str, Any]:
    """The row of every recording that is there, and the reasons for those that are skipped.

    Rows that the file `out` holds already are not measured again.
    """
    folder = folder_of_data(data)
    skipped = {name: reason for name in sources if (reason := missing(folder, SOURCES[name]))}
    rows = json.loads(Path(out).read_text()) if out and Path(out).exists() else {}
    for name in progress([name for name in sources if name not in skipped and name not in rows], "recordings"):
        assert folder is not None
        rows[name] = found_in(SOURCES[name], folder)
        if out:
            Path(out).write_text(json.dumps(rows, indent=1))
    rows = {name: rows[name] for name in SOURCES if name in rows}
    seconds = sorted(row["cpu_seconds"] / 2 for row in rows.values())
    return {
        "recordings": rows,
        "right": sum(row["right"] for row in rows.values()),
        "median_cpu_seconds_over_two": seconds[len(seconds) // 2] if seconds else None,
        "skipped": skipped,
    }


def found_in(source: Source, folder: Path) -> dict[str, Any]:
    """What the command says of a recording."""
    with tempfile.TemporaryDirectory() as made:
        arguments = source.command(folder, Path(made))
        begun, used = time.perf_counter(), _processor_seconds()
        done = subprocess.run(
            [sys.executable, "-m", "motofmi", "gap", *arguments, "--out", str(Path(made) / "gap")],
            capture_output=True, text=True,
        )  # fmt: skip
        seconds, cpu = time.perf_counter() - begun, _processor_seconds() - used
        if done.returncode:
            return _base(source) | {"verdict": "refused", "right": False, "effects": [],
                                    "why": done.stderr.strip().splitlines()[-1:], "seconds": seconds, "cpu_seconds": cpu}  # fmt: skip
        said = json.loads((Path(made) / "gap" / "verdict.json").read_text())
    return row(source, said) | {"seconds": seconds, "cpu_seconds": cpu}


def row(source: Source, said: Mapping[str, Any]) -> dict[str, Any]:
    """The verdict beside what is published."""
    effects = [{"name": e["name"], "form": e["form"], "parameters": e["parameters"]} for e in said["effects"]]
    named = [e["name"] for e in effects]
    found = {
        "verdict": said["verdict"], "complete": said["complete"], "effects": effects, "tied": said["tied"],
        "right": named[: len(source.known)] != [] and source.known <= set(named),
        "beside": sorted(set(named) - source.known), "explained": said["explained"], "remainder": said["remainder"],
        "closest": said.get("closest"),
    } | _base(source)  # fmt: skip
    if source.published and (value := _parameter(effects, source.published.parameter)):
        reach = INTERVAL * value["standard_error"]
        low, high = value["value"] - reach, value["value"] + reach
        found["value"] = value | {"low": low, "high": high, "published": str(source.published),
                                  "within": low <= source.published.high and high >= source.published.low}  # fmt: skip
    return found


def _base(source: Source) -> dict[str, str]:
    return {"component": Path(source.component).name or "matrices", "impose": source.impose}


def _parameter(effects: Sequence[Mapping[str, Any]], name: str) -> dict[str, Any] | None:
    family, parameter = name.split(".")
    return next((e["parameters"][parameter] for e in effects if e["name"] == family and parameter in e["parameters"]), None)


def _processor_seconds() -> float:
    """The processor time [s] of child processes that have ended."""
    used = os.times()
    return used.children_user + used.children_system


def table(results: Mapping[str, Any]) -> str:
    """The table of docs/gap.md."""
    lines = ["| recording | base | verdict | value, 95 % interval (published) | closable misfit closed | left of the motion | CPU s |",
             "|---|---|---|---|---|---|---|"]  # fmt: skip
    for name, row in results["recordings"].items():
        base = f"`{row['component'].split(':')[-1]}`" if row["component"] != "matrices" else "its matrices"
        lines.append(f"| {name} | {base} | {_verdict(row)} | {_value(row.get('value'))} | {_share(row.get('explained'))} "
                     f"| {_left(row.get('remainder'))} | {row['cpu_seconds']:.0f} |")  # fmt: skip
    return "\n".join(lines)


def _verdict(row: Mapping[str, Any]) -> str:
    if row["effects"]:
        return " and ".join(f"`{e['name']}` ({e['form']})" for e in row["effects"])
    if row.get("tied"):
        return f"{row['verdict']}: {', '.join(f'`{name}`' for name in row['tied'])}"
    nearest = (row.get("remainder") or {}).get("nearest")
    return row["verdict"] + (f", nearest `{nearest}`" if nearest else "")


def _value(value: Mapping[str, Any] | None) -> str:
    if value is None:
        return ""
    unit = "" if value["unit"] == "1" else f" {value['unit']}"
    return f"{value['value']:.4g} [{value['low']:.4g}, {value['high']:.4g}]{unit} ({value['published']})"


def _share(share: Mapping[str, float] | None) -> str:
    return f"{share['share']:.1%} [{share['low']:.1%}, {share['high']:.1%}]".replace("%", " %") if share else ""


def _left(remainder: Mapping[str, Any] | None) -> str:
    return f"{remainder['share']:.1%}".replace("%", " %") if remainder and remainder["share"] is not None else ""


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.gap_recordings", description=__doc__)
    parser.add_argument("--data", metavar="DIR", help=f"folder of recordings (default: environment variable {DATA})")
    parser.add_argument("--only", nargs="+", metavar="NAME", default=tuple(SOURCES), choices=tuple(SOURCES))
    parser.add_argument("--out", metavar="FILE", help="keep each row there, and take up a run again from it")
    arguments = parser.parse_args()
    results = run(track, arguments.data, arguments.only, arguments.out)
    print(table(results))
    print(json.dumps(results, indent=1))


if __name__ == "__main__":
    main()
