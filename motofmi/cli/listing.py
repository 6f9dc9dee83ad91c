"""The commands by name: every module of `motofmi.cli.commands` is one.

A command declares SUMMARY, one line for the listing, and PLACE, a number by which the listing is sorted. Both are read
from the source text: importing a command loads the numerical libraries, which takes longer than showing the listing.
"""

import ast
import pkgutil
from dataclasses import dataclass
from pathlib import Path

from motofmi.cli import commands as folder

USAGE = "usage: motofmi COMMAND [options]"
LEAD = "Riders, motorcycles and steering dampers as FMUs: built, co-simulated, linearised, identified and compared with data."
CLOSING = """\
motofmi help COMMAND       options and examples of a command
motofmi --version          version of this installation
motofmi completion bash    completion of commands and options in the shell"""


@dataclass(frozen=True)
class Entry:
    """A command in the listing."""

    name: str
    summary: str
    place: float

    @property
    def module(self) -> str:
        """The name under which the command's module is imported."""
        return f"{folder.__name__}.{self.name}"


def commands() -> dict[str, Entry]:
    """Every command by its name, in the order of the listing."""
    found = [
        _entry(Path(path), info.name)
        for path in folder.__path__
        for info in pkgutil.iter_modules([path])
        if not info.ispkg
    ]
    return {entry.name: entry for entry in sorted(found, key=lambda entry: (entry.place, entry.name))}


def _entry(path: Path, name: str) -> Entry:
    """What a command's source declares; without a PLACE it stands last, without a SUMMARY its line is empty."""
    tree = ast.parse((path / f"{name}.py").read_text("utf-8"))
    declared = {target.id: ast.literal_eval(node.value)
                for node in tree.body if isinstance(node, ast.Assign)
                for target in node.targets if isinstance(target, ast.Name) and target.id in ("SUMMARY", "PLACE")}  # fmt: skip
    return Entry(name, declared.get("SUMMARY", ""), declared.get("PLACE", float("inf")))


def overview() -> str:
    """The help of `motofmi` itself."""
    entries = commands().values()
    width = max(len(entry.name) for entry in entries)
    lines = "\n".join(f"  {entry.name:{width}}  {entry.summary}" for entry in entries)
    return f"{USAGE}\n\n{LEAD}\n\ncommands:\n{lines}\n\n{CLOSING}"
