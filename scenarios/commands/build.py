"""FMUs from components."""

import argparse
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from fmus.build import build_all
from fmus.errors import InputError
from fmus.progress import track
from scenarios import names

HELP = """Makes FMUs: every rider, motorcycle and damper, or those that are named.

  motofmi build
  motofmi build rider:mean_2011 sharp_1971 damper:7.5 --out fmus
  motofmi build mine.toml --fmi 3
  motofmi build rider:mean_2011 --backend python
  motofmi build --platforms all            (needs: pip install motofmi[platforms])
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("names", nargs="*", metavar="NAME", help="kind:NAME, damper:VALUE, a NAME that is unique, or a .toml (default: all)")
    parser.add_argument("--fmi", default="2", help="version of the standard: 2 (default) or 3")
    parser.add_argument("--backend", default="compiled", help="compiled (default) or python")
    parser.add_argument("--platforms", default="host", help="host (default), all, or a comma list")
    parser.add_argument("--out", default=".", type=Path, metavar="DIR", help="where to (default: the current folder)")
    parser.add_argument("--set", dest="settings", action="append", default=[], metavar="NAME=VALUE", help="change a parameter, of a single NAME")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    if arguments.fmi not in ("2", "3"):
        raise InputError(f"--fmi {arguments.fmi!r} is not a version that can be built (valid: 2, 3)")
    components = [names.component(spec) for spec in arguments.names or names.every_name()]
    if arguments.settings:
        if len(components) != 1:
            raise InputError(f"--set goes with a single NAME, not with {len(components)}")
        components = [components[0].with_values(**names.assignments(arguments.settings))]
    built = [built for component in track(components, "building", len(components))
             for built in build_all(component, arguments.out, int(arguments.fmi), arguments.backend, arguments.platforms)]  # fmt: skip
    return {"fmus": [{"name": b.name, "path": str(b.path), "sha256": b.sha256, "platforms": list(b.platforms)} for b in built]}


def show(result: dict[str, Any], console: Console) -> None:
    table = Table(box=None)
    for heading in ("FMU", "platforms", "sha256"):
        table.add_column(heading)
    for fmu in result["fmus"]:
        table.add_row(fmu["path"], " ".join(fmu["platforms"]), fmu["sha256"][:16])
    console.print(table)
