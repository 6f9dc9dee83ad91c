"""The results of a host, printed as lines."""

import sys
from collections.abc import Callable
from dataclasses import asdict, is_dataclass
from typing import Any


def show(found: dict[str, Any], indent: str = "") -> None:
    """Print numbers by name; names of names indented."""
    for name, value in found.items():
        if is_dataclass(value) and not isinstance(value, type):
            value = asdict(value)
        if isinstance(value, dict):
            print(f"{indent}{name}")
            show(value, indent + "  ")
        else:
            print(f"{indent}{name:<24}{value:.8g}")


def main(run: Callable[[], dict[str, Any]]) -> None:
    """Run a host and show what it found, or say in one line which package is missing; the exit status is then 1."""
    try:
        show(run())
    except ModuleNotFoundError as error:
        sys.exit(f"{error.name} is not installed: pip install '.[hosts]', or see docs/hosts.md")
