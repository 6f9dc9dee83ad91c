"""The entry point of the command line: prints help and version itself and passes everything else to a command.

This module imports nothing slow. A command's module, and with it the numerical libraries, is imported when the command
is called or when its own help is requested.
"""

import sys
from collections.abc import Sequence
from importlib import import_module

from motofmi.cli.listing import overview


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command line and return the exit status: 0, 1 for failure, 2 for invalid input, 130 when interrupted."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    first = words[0] if words else "help"
    if first in ("-V", "--version"):
        print(f"motofmi {import_module('motofmi.version').__version__}")
        return 0
    if first in ("help", "-h", "--help"):
        if len(words) < 2:
            print(overview())
            return 0
        words = [words[1], "--help"]
    return int(import_module("motofmi.cli.run").run(words))


if __name__ == "__main__":
    raise SystemExit(main())
