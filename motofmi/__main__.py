"""The entry point of the command: `motofmi` and `python -m motofmi`."""

import os
import sys
from importlib import import_module

INTERRUPTED, BROKEN_PIPE = 130, 141  # as shells give them: 128 + SIGINT, 128 + SIGPIPE


def main() -> int:
    """Run the command line; the exit status."""
    # Matrices are small here: threads inside one multiplication wait for each other longer than it takes.
    # NumPy reads this once, when it is first imported.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("MPLBACKEND", "Agg")  # figures go to files: no window system is needed
    try:
        status = int(import_module("motofmi.cli.main").main())
        sys.stdout.flush()
        return status
    except KeyboardInterrupt:
        print("motofmi: interrupted; written: nothing", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        # Python flushes standard output once more when it ends.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE


if __name__ == "__main__":
    raise SystemExit(main())
