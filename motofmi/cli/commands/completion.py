"""Completion of commands, options, files and component names in the shell."""

import argparse
from itertools import chain
from typing import Any

import shtab

from motofmi.cli.listing import DESCRIPTION, commands
from motofmi.cli.parser import Parser, fill
from motofmi.cli.run import imported
from motofmi.cli.screen import Screen
from motofmi.workflows import components

SUMMARY = "script that completes commands and options in the shell"
PLACE = 900
UNITS: dict[str, str] = {}
HELP = """Prints a script that completes commands, options, file names and the names of vehicles and devices in the
shell. Save its output as shown and start a new shell.

  motofmi completion bash > ~/.local/share/bash-completion/completions/motofmi
  motofmi completion zsh > ~/.zfunc/_motofmi          # with fpath=(~/.zfunc $fpath) before compinit in .zshrc
"""
SHELLS = ("bash", "zsh")
# Metavar of an option -> completion by file or folder names
FILES = {"FILE": shtab.FILE, "FILE.csv": shtab.FILE, "FILE.toml": shtab.FILE, "FILE.html": shtab.FILE,
         "FILE.json": shtab.FILE, "FMU": shtab.FILE, "PATH": shtab.FILE, "DIR": shtab.DIRECTORY}  # fmt: skip


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("shell", choices=SHELLS, help="the shell: %(choices)s")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    return {"shell": arguments.shell, "script": script(arguments.shell)}


def script(shell: str) -> str:
    """The completion script for a shell, one of SHELLS."""
    shipped = {kind: library.names() for kind, library in components.LIBRARIES.items()}
    known = {
        "vehicle": shipped["motorcycle"],
        "device": [*shipped["rider"], *shipped["damper"]],
        "names": [*chain(*shipped.values())],
    }
    parser = Parser(prog="motofmi", description=DESCRIPTION)
    entries = parser.add_subparsers(dest="command")
    for entry in commands().values():
        command = fill(entries.add_parser(entry.name, help=entry.summary), imported(entry.module))
        command.description = entry.summary
        for action in command._actions:
            if action.dest in known:
                choices = {"bash": f"_motofmi_{action.dest}", "zsh": f"({' '.join(known[action.dest])})"}
                action.complete = choices  # type: ignore[attr-defined]
            elif action.metavar in FILES:
                action.complete = FILES[str(action.metavar)]  # type: ignore[attr-defined]
    functions = "\n".join(
        f'_motofmi_{what}() {{ compgen -W "{" ".join(words)}" -- "$1"; }}' for what, words in known.items()
    )
    return shtab.complete(parser, shell, preamble=functions if shell == "bash" else "")


def show(result: dict[str, Any], screen: Screen) -> None:
    screen.out(result["script"], end="\n", highlight=False)
