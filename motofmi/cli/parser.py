"""The parser of a command's options."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn

from fmus.support.errors import InputError, unknown
from motofmi.cli.outputs import STANDARD_OUTPUT, output_file


class Parser(argparse.ArgumentParser):
    """Raises InputError where argparse would print its usage, and proposes the option that was meant."""

    def error(self, message: str) -> NoReturn:
        raise InputError(message)

    def options(self, words: Sequence[str]) -> argparse.Namespace:
        """The options that the words give. Raises InputError for a word that the command does not take."""
        options, rest = self.parse_known_args(words)
        if rest and rest[0].startswith("-"):
            raise unknown(
                "option",
                rest[0].partition("=")[0],
                (word for action in self._actions for word in action.option_strings),
            )
        if rest:
            raise InputError(
                f"unexpected {rest[0]!r}; motofmi help {self.prog.split()[-1]} shows what the command takes"
            )
        return options


def _json_file(text: str) -> Path:
    return STANDARD_OUTPUT if text == str(STANDARD_OUTPUT) else output_file()(text)


def fill(parser: Parser, command: Any) -> Parser:
    """The parser with a command's options and those that every command has."""
    parser.description = command.HELP
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    command.add_arguments(parser)
    parser.add_argument(
        "--json",
        metavar="FILE",
        type=_json_file,
        help="also write the result as JSON; - for standard output, and nothing else there",
    )
    return parser
