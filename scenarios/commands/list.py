"""What ships: components, riders, motorcycles, dampers and effects, with parameters and sources."""

import argparse
import inspect
from typing import Any

from rich.console import Console
from rich.table import Table

from fmus.component import Component
from fmus.library import Library
from scenarios import names

HELP = """Components, riders, motorcycles, dampers, mechanisms and effects. With --json every parameter comes with its symbol,
unit, value and bounds: these are the words that --set takes.

  motofmi list
  motofmi list --json -
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    del parser


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    del arguments
    return {
        "components": [_class(c) for c in names.COMPONENTS.values()],
        **{f"{kind}s": [_instance(library, name) for name in library.names()] for kind, library in names.LIBRARIES.items()},
        "effects": names.effects(),
    }


def _class(component: type[Component]) -> dict[str, Any]:
    doc = (inspect.getdoc(component) or "").splitlines()[0]
    return {"name": component.__name__, "description": doc, "parameters": _parameters(component()),
            "inputs": list(component().inputs), "outputs": list(component().outputs), "states": list(component().states)}  # fmt: skip


def _parameters(component: Component) -> dict[str, Any]:
    return {
        name: {"value": component.values[name], "unit": row.unit, "symbol": row.symbol, "min": row.min, "max": row.max,
               "description": row.description, "assumed": component.assumed.get(name)}
        for name, row in component.rows("parameter").items()
    }  # fmt: skip


def _instance(library: Library, name: str) -> dict[str, Any]:
    component, contents = library.load(name), library.contents(name)
    return {"name": name, "component": component.title, "description": contents.get("description", ""),
            "source": component.source, "assumed": component.assumed, "parameters": _parameters(component)}  # fmt: skip


def show(result: dict[str, Any], console: Console) -> None:
    for kind in ("components", "riders", "motorcycles", "dampers", "mechanisms", "effects"):
        table = Table(title=kind, box=None, title_justify="left", title_style="bold", show_header=False)
        for entry in result[kind]:
            text = entry.get("description", "")
            text += f" (assumed: {', '.join(entry['assumed'])})" if entry.get("assumed") else ""
            table.add_row(entry["name"], text, entry.get("source", ""))
        console.print(table, "")
