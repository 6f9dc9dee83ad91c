"""List of the shipped components, riders, motorcycles, dampers, mechanisms and effects."""

import argparse
from typing import Any

from motofmi.cli.screen import Screen
from motofmi.workflows.listing import catalogue

SUMMARY = "components, riders, motorcycles, dampers, mechanisms and effects, with parameters and sources"
PLACE = 20
UNITS: dict[str, str] = {}
HELP = """Lists the components, riders, motorcycles, dampers, mechanisms and effects, with the source of each. The JSON
also has every parameter with symbol, unit, value and bounds, under the name that --set expects.

  motofmi list
  motofmi list --json catalogue.json
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    del parser


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    del arguments
    return catalogue().to_dict()


def show(result: dict[str, Any], screen: Screen) -> None:
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


def _described(entry: dict[str, Any]) -> str:
    return entry["description"] + (f" (assumed: {', '.join(entry['assumed'])})" if entry.get("assumed") else "")
