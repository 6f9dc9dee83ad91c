"""Runs a command, shows its result, and reports errors as one line.

A command is a module of `motofmi.cli.commands` with

    SUMMARY, PLACE              its line in the listing, and the number by which the listing is sorted
    HELP                        what the command computes, with examples
    UNITS                       unit of each number in the result by name, the key `units` of the JSON; optional
    add_arguments(parser)       adds the options of the command
    run(arguments) -> dict      computes the result, under the keys of its JSON
    show(result, screen)        prints the result; optional
    exit_status(result) -> int  the exit status, if it is not always 0; optional
"""

import gc
import importlib
import re
import sys
import warnings
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from fmus.support.errors import InputError, MissingToolError, SimulationError, unknown
from fmus.support.files import files_written
from fmus.support.foreign_code import exits_reported
from motofmi.cli import outputs
from motofmi.cli.listing import commands
from motofmi.cli.parser import Parser, fill
from motofmi.reports.provenance import Command, command_line

INTERRUPTED = 130  # exit status of an interrupted command in shells: 128 + SIGINT


def run(words: Sequence[str]) -> int:
    """Run the command that the first word names, with the other words as its options. Returns the exit status."""
    with files_written() as written, warnings.catch_warnings():
        warnings.showwarning = _shown_for(f"motofmi {words[0]}")
        return _run(words, written)


def _run(words: Sequence[str], written: Sequence[Path]) -> int:
    program = "motofmi"
    try:
        command = command_named(words[0])
        program = f"motofmi {words[0]}"
        options = fill(Parser(prog=program), command).options(_with_negative_values(words[1:]))
        with (command_line(Command([program, *words[1:]], written, _later(options))),
              exits_reported(partial(_ended, program, hasattr(options, "sandbox")))):  # fmt: skip
            result = command.run(options)
        outputs.present(command, _with_units(command, result), options.json, written)
        return command.exit_status(result) if hasattr(command, "exit_status") else 0
    except SystemExit as stop:  # argparse has shown the help
        return int(stop.code or 0)
    except (InputError, MissingToolError) as error:
        return _report_error(program, str(error), 2)
    except SimulationError as error:
        return _report_error(program, str(error), 1)
    except BrokenPipeError:
        raise
    except OSError as error:
        named = f"{error.filename}: " if error.filename else ""
        return _report_error(program, f"{named}{error.strerror or error}", 2)
    except KeyboardInterrupt:
        left = outputs.described([path for path in written if path.exists()])
        return _report_error(program, f"interrupted; written: {', '.join(left) or 'nothing'}",
                         INTERRUPTED)


def _ended(program: str, has_sandbox: bool, fmus: Sequence[str]) -> str:
    """The message when one of the FMUs that were called has ended the process."""
    fmu = fmus[0] if len(fmus) == 1 else f"one of the FMUs {', '.join(fmus)}"
    advice = "run it with --sandbox" if has_sandbox else "it cannot be used; motofmi check shows the call"
    return f"{program}: {fmu} ended the process of motofmi: {advice}"


def _later(options: Any) -> list[Path]:
    """The files that are written after the command has run."""
    return [] if options.json in (None, outputs.STANDARD_OUTPUT) else [options.json]


def command_named(name: str) -> Any:
    """The module of a command. Raises InputError for an unknown name, with the nearest and all valid names."""
    if name not in commands():
        raise unknown("command", name, commands())
    return imported(commands()[name].module)


def imported(name: str) -> Any:
    """A module, imported without garbage collection: an import frees few objects, and collection takes a fifth of
    it."""
    if name not in sys.modules:
        gc.disable()
        try:
            importlib.import_module(name)
        finally:
            gc.freeze()
            gc.enable()
    return sys.modules[name]


def _with_negative_values(words: Sequence[str]) -> list[str]:
    """The words with `--speed -3` as `--speed=-3`, because argparse reads a word that starts with a minus as an
    option."""
    joined: list[str] = []
    for word in words:
        if joined and joined[-1].startswith("--") and "=" not in joined[-1] and re.match(r"-[\d.]", word):
            joined[-1] += f"={word}"
        else:
            joined.append(word)
    return joined


def _with_units(command: Any, result: dict[str, Any]) -> dict[str, Any]:
    """The result with the key `units`: the units that the command declares and those in the result itself."""
    return {**result, "units": {**getattr(command, "UNITS", {}), **result.get("units", {})}}


def _shown_for(program: str) -> Any:
    """The function that prints a warning as one line."""

    def shown(message: Warning | str, *_: Any, **__: Any) -> None:
        print(f"{program}: warning: {' '.join(str(message).split())}", file=sys.stderr)

    return shown


def _report_error(program: str, message: str, status: int) -> int:
    print(f"{program}: {' '.join(message.split())}", file=sys.stderr)
    return status
