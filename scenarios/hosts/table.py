"""What a host's run found, as lines on the screen."""

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
