"""The commands by name: every module of `motofmi.cli.commands` is a command.

A command declares SUMMARY, one line for the listing, and PLACE, a number by which the listing is sorted. Both are read
from the source text, because importing a command loads the numerical libraries and takes longer than the listing.
"""

import ast
import pkgutil
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from motofmi.cli import commands as folder

USAGE = "usage: motofmi COMMAND [options]"
DESCRIPTION = ("Builds riders, motorcycles and steering dampers as FMUs; co-simulates, linearises and identifies them, "
               "and compares them with measured data.")  # fmt: skip
FURTHER_HELP = """\
motofmi help COMMAND       options and examples of a command
motofmi --version          version of this installation
motofmi completion bash    script that completes commands and options in the shell"""


@dataclass(frozen=True)
class Entry:
    """A command in the listing: name, one line of description, and the number by which the listing is sorted."""

    name: str
    summary: str
    place: float

    @property
    def module(self) -> str:
        """The full name of the command's module, for import."""
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


@cache
def _entry(path: Path, name: str) -> Entry:
    """The command that a source file declares; without PLACE it is listed last, without SUMMARY its line is empty."""
    tree = ast.parse((path / f"{name}.py").read_text("utf-8"))
    declared = {target.id: ast.literal_eval(node.value)
                for node in tree.body if isinstance(node, ast.Assign)
                for target in node.targets if isinstance(target, ast.Name)
                and target.id in ("SUMMARY", "PLACE")}  # fmt: skip
    return Entry(name, declared.get("SUMMARY", ""), declared.get("PLACE", float("inf")))


def overview() -> str:
    """The help text of `motofmi` itself: usage, the commands, further help."""
    entries = commands().values()
    width = max(len(entry.name) for entry in entries)
    lines = "\n".join(f"  {entry.name:{width}}  {entry.summary}" for entry in entries)
    return f"{USAGE}\n\n{DESCRIPTION}\n\ncommands:\n{lines}\n\n{FURTHER_HELP}"
