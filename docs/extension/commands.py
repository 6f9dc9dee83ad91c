"""Every command with its options, from its parser."""

import argparse
from importlib import import_module

from extension.tables import table
from motofmi.cli.listing import commands
from motofmi.cli.parser import Parser, fill


def page() -> str:
    return "# Commands\n\n" + "\n".join(_section(name) for name in commands())


def _section(name: str) -> str:
    command = import_module(f"motofmi.cli.commands.{name}")
    parser = fill(Parser(prog=f"motofmi {name}", add_help=False), command)
    rows = [(_words(action), _help(parser, action)) for action in parser._actions if action.help != argparse.SUPPRESS]
    return f"## motofmi {name}\n\n```text\n{command.HELP.strip()}\n```\n\n{table(('argument', 'meaning'), rows)}"


def _words(action: argparse.Action) -> str:
    shown = action.metavar or (action.dest.upper() if action.nargs != 0 else "")
    value = " ".join(shown) if isinstance(shown, tuple) else shown
    return f"`{' '.join([', '.join(action.option_strings), value]).strip()}`"


def _help(parser: argparse.ArgumentParser, action: argparse.Action) -> str:
    return parser._get_formatter()._expand_help(action) if action.help else ""
