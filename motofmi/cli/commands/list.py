"""List of the shipped components, riders, motorcycles, dampers, mechanisms and effects."""

import argparse
from typing import Any

from motofmi.cli.screen import Screen
from motofmi.workflows.listing import catalogue

SUMMARY = "components, riders, motorcycles, dampers, mechanisms and effects, with parameters and sources"
PLACE = 20
UNITS: dict[str, str] = {}
HELP = """Lists the components, riders, motorcycles, dampers, mechanisms and effects, with the source of each. With a
name, and in the JSON, every parameter follows with symbol, unit, value and bounds, under the name that --set expects.

  motofmi list
  motofmi list sharp_1971
  motofmi list --json catalogue.json
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", nargs="?", metavar="NAME", help="show this one alone, with its parameters")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    every = catalogue()
    return (every.named(arguments.name) if arguments.name else every).to_dict()


def show(result: dict[str, Any], screen: Screen) -> None:
    entries = [entry for found in result.values() for entry in found]
    if len({entry["name"] for entry in entries}) == 1:
        for entry in entries:
            _show_entry(entry, screen)
        return
    for kind in ("components", "riders", "motorcycles", "dampers", "mechanisms"):
        screen.print(f"{kind}:")
        screen.table(
            ("name", "description", "source"), [(e["name"], _described(e), e.get("source", "")) for e in result[kind]]
        )
        screen.print()
    screen.print("effects:")
    screen.table(
        ("name", "form", "description", "source"),
        [(e["name"], e["form"], e["description"], e["source"]) for e in result["effects"]],
    )


def _show_entry(entry: dict[str, Any], screen: Screen) -> None:
    """One entry with its parameters."""
    screen.print(f"{entry['name']}{', ' + entry['form'] if entry.get('form') else ''}: {entry['description']}")
    if entry.get("source"):
        screen.print(f"source: {entry['source']}")
    screen.table(
        ("parameter", "symbol", "value", "unit", "min", "max", "description"),
        [(name, row["symbol"], f"{row['value']:.6g}", row["unit"], f"{row['min']:g}", f"{row['max']:g}",
          row["description"] + (f" (assumed: {row['assumed']})" if row.get("assumed") else ""))
         for name, row in entry["parameters"].items()],
    )  # fmt: skip
    screen.print()


def _described(entry: dict[str, Any]) -> str:
    return entry["description"] + (f" (assumed: {', '.join(entry['assumed'])})" if entry.get("assumed") else "")
