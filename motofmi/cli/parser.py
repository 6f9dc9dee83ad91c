"""The parser of a command's options."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn

from fmus.support.errors import InputError, unknown
from motofmi.cli.outputs import STANDARD_OUTPUT, output_file


class Parser(argparse.ArgumentParser):
    """Raises InputError where argparse prints its usage and exits; the message proposes the nearest valid option."""

    def error(self, message: str) -> NoReturn:
        raise InputError(message)

    def options(self, words: Sequence[str]) -> argparse.Namespace:
        """The options in the words of a command line. Raises InputError for a word that the command does not accept."""
        options, rest = self.parse_known_args(words)
        if rest and rest[0].startswith("-"):
            raise unknown(
                "option",
                rest[0].partition("=")[0],
                (word for action in self._actions for word in action.option_strings),
            )
        if rest:
            raise InputError(
                f"unexpected {rest[0]!r}; motofmi help {self.prog.split()[-1]} shows the arguments of the command"
            )
        return options


def _json_file(text: str) -> Path:
    return STANDARD_OUTPUT if text == str(STANDARD_OUTPUT) else output_file()(text)


def fill(parser: Parser, command: Any) -> Parser:
    """The parser with a command's own options and with `--json`, which every command has."""
    parser.description = command.HELP
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    command.add_arguments(parser)
    parser.add_argument(
        "--json",
        metavar="FILE",
        type=_json_file,
        help="also write the result as JSON; - prints only the JSON, to standard output",
    )
    return parser
