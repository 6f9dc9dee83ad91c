"""The command line: finds the command, runs it, shows its result, and turns errors into one line.

A command is a module of `scenarios.commands` with HELP, add_arguments(parser), run(arguments) -> dict, and
show(result, console) for the screen; exit_status(result) where that is not always 0. Its module is imported only when
it is called.
"""

import argparse
import gc
import importlib
import json
import re
import sys
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from rich.console import Console

from fmus.errors import InputError, MissingToolError, SimulationError
from fmus.files import write_beside

COMMANDS = {
    "tour": "the main job on real input: build, co-simulate, swap, compare with the papers, report",
    "list": "components, riders, motorcycles, dampers, mechanisms and effects, with their parameters and sources",
    "build": "make FMUs",
    "check": "check FMUs, also other people's",
    "modes": "eigenvalues and named modes over speed",
    "device": "transfer functions of a rider or damper at the handlebar",
    "cosimulate": "run the FMUs of a vehicle and a device together",
    "frf": "frequency response functions from recordings",
    "identify": "a rider's parameters from recordings",
    "gap": "where a model misses measured data, and which physical effect is missing",
}


class _Parser(argparse.ArgumentParser):
    """Errors in one line, exit status 2."""

    def error(self, message: str) -> NoReturn:
        _complain(self.prog, message)
        raise SystemExit(2)


def main(arguments: list[str] | None = None) -> int:
    """Run one command; the exit status is 0, 2 for bad input, 1 for failure."""
    words = sys.argv[1:] if arguments is None else arguments
    name = next((w for w in words if not w.startswith("-")), None)
    if name not in COMMANDS or words[0] != name:
        return _top_level(words)
    try:
        command = _imported(f"scenarios.commands.{name}")
        parser = _Parser(prog=f"motofmi {name}", description=command.HELP, formatter_class=argparse.RawDescriptionHelpFormatter)
        command.add_arguments(parser)
        parser.add_argument("--json", metavar="FILE", help="also write the result as JSON; - for standard output, and nothing else there")
        options = parser.parse_args(_with_negative_values(words[1:]))
        result = command.run(options)
        _present(command, result, options.json)
        return command.exit_status(result) if hasattr(command, "exit_status") else 0
    except (InputError, MissingToolError) as error:
        _complain(f"motofmi {name}", str(error))
        return 2
    except SimulationError as error:
        _complain(f"motofmi {name}", str(error))
        return 1
    except OSError as error:
        _complain(f"motofmi {name}", f"{error.filename or ''}: {error.strerror or error}")
        return 2
    except KeyboardInterrupt:
        _complain(f"motofmi {name}", "interrupted")
        return 1


def _imported(name: str) -> Any:
    """A command's module. Hardly anything that comes with it is ever garbage, and looking for that takes a fifth of the time."""
    if name not in sys.modules:
        gc.disable()
        try:
            importlib.import_module(name)
        finally:
            gc.freeze()
            gc.enable()
    return sys.modules[name]


def _with_negative_values(words: list[str]) -> list[str]:
    """`--speed -3` as `--speed=-3`: argparse takes a word that starts with a minus for an option."""
    joined: list[str] = []
    for word in words:
        if joined and joined[-1].startswith("--") and "=" not in joined[-1] and re.match(r"-[\d.]", word):
            joined[-1] += f"={word}"
        else:
            joined.append(word)
    return joined


def _top_level(words: list[str]) -> int:
    listing = "\n".join(f"  {name:12}{summary}" for name, summary in COMMANDS.items())
    parser = _Parser(prog="motofmi", description="Riders, motorcycles and steering dampers as FMUs.", epilog=f"commands:\n{listing}\n\n"
                     "motofmi COMMAND --help shows a command's options with examples.",
                     formatter_class=argparse.RawDescriptionHelpFormatter, usage="motofmi COMMAND [options]")  # fmt: skip
    parser.add_argument("command", choices=COMMANDS, metavar="COMMAND", help="see below")
    parser.parse_args([w for w in words if w in ("-h", "--help")] or words[:1])
    return 0


def _present(command: Any, result: dict[str, Any], json_file: str | None) -> None:
    if json_file == "-":
        print(to_json(result))
        return
    if json_file:
        write_text(Path(json_file), to_json(result) + "\n")
    if hasattr(command, "show"):
        command.show(result, Console(highlight=False))


def to_json(result: Any) -> str:
    """The result as JSON: complex numbers as [re, im], what is not a finite number as null."""
    return json.dumps(_plain(result), indent=1, allow_nan=False)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [_plain(v) for v in value]
    if isinstance(value, (complex, np.complexfloating)):
        return [_plain(value.real), _plain(value.imag)] if np.isfinite(value) else None
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, (float, np.floating)):
        return float(value) if np.isfinite(value) else None
    return str(value) if isinstance(value, Path) else value


def write_text(path: Path, text: str) -> None:
    """Write a text file, whole or not at all. Raises InputError when the place cannot be written."""
    try:
        write_beside(path, lambda beside: beside.write_text(text, "utf-8"))
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror}; choose another place") from None


def _complain(who: str, message: str) -> None:
    print(f"{who}: {' '.join(message.split())}", file=sys.stderr)


if __name__ == "__main__":
    raise SystemExit(main())
