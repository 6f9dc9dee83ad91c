"""The entry point of the command: `motofmi` and `python -m motofmi`."""

import os
import sys
from importlib import import_module
from typing import Any

INVALID, INTERRUPTED, BROKEN_PIPE = 2, 130, 141  # the last two as shells give them: 128 + SIGINT, 128 + SIGPIPE


def main() -> int:
    """Run the command line; the exit status."""
    # Matrices are small here: threads inside one multiplication wait for each other longer than it takes.
    # NumPy reads this once, when it is first imported.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("MPLBACKEND", "Agg")  # figures go to files: no window system is needed
    for stream in (sys.stdout, sys.stderr):
        _replace_unknown_characters(stream)
    status = 0
    try:
        status = int(import_module("motofmi.cli.main").main())
        sys.stdout.flush()
        return status
    except KeyboardInterrupt:
        print("motofmi: interrupted; written: nothing", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        _drop_output()
        return BROKEN_PIPE
    except OSError as error:
        _drop_output()
        if not status:  # else the command has reported it
            print(f"motofmi: {error.filename or 'standard output'}: {error.strerror}", file=sys.stderr)
        return status or INVALID


def _replace_unknown_characters(stream: Any) -> None:
    """Characters that a stream cannot encode are shown by their number, as \\xfc."""
    unicode = (getattr(stream, "encoding", None) or "").lower().replace("-", "") == "utf8"
    if hasattr(stream, "reconfigure") and stream.errors in ("strict", "surrogateescape")[: 2 - unicode]:
        stream.reconfigure(errors="backslashreplace")


def _drop_output() -> None:
    """Python writes what is left of standard output once more when it ends: to nowhere."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    raise SystemExit(main())
