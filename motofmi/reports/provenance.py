"""What a report says of its own making: version, date, command line, inputs with their SHA-256, files written."""

import hashlib
import shlex
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

from motofmi.version import __version__


@dataclass(frozen=True)
class Command:
    """A command line in words, the files written so far, and those that it writes after its reports."""

    words: Sequence[str]
    written: Sequence[Path] = ()
    later: Sequence[Path] = ()


_COMMAND: ContextVar[Command | None] = ContextVar("command", default=None)


@dataclass(frozen=True)
class Made:
    """How a report was made: inputs are pairs of path and SHA-256."""

    version: str
    date: str
    command: str
    inputs: list[tuple[str, str]] = field(default_factory=list)


@contextmanager
def command_line(command: Command) -> Iterator[None]:
    """Within the context, reports name this command line and the files that it writes."""
    before = _COMMAND.set(command)
    try:
        yield
    finally:
        _COMMAND.reset(before)


def made(inputs: Sequence[str | Path]) -> Made:
    """The making of a report from these files now. A file that no longer exists has no SHA-256."""
    command = _COMMAND.get()
    date = datetime.now().astimezone().strftime("%Y-%m-%d %H:%M:%S %Z").strip()
    hashed = [(str(path), sha256(path)) for path in dict.fromkeys(map(Path, inputs))]
    return Made(
        __version__, date, " ".join([command.words[0], shlex.join(command.words[1:])]) if command else "", hashed
    )


def also_written(files: Sequence[tuple[str | Path, str]]) -> list[tuple[str | Path, str]]:
    """The files with their descriptions, and besides them those of the command that runs."""
    command = _COMMAND.get()
    others = [] if command is None else [*command.written, *command.later]
    named = {Path(path).absolute() for path, _ in files}
    return [*files, *((path, "") for path in dict.fromkeys(Path(p).absolute() for p in others) if path not in named)]


def sha256(path: str | Path) -> str:
    """The SHA-256 of a file in hexadecimal; "not available" where it cannot be read."""
    try:
        with open(path, "rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return "not available"
