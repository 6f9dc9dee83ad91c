"""The call that an FMU is in, and its last message, in a file that outlives a crash of the process."""

import mmap
from pathlib import Path

CALL, SIZE = 80, 1024  # bytes of the call's name, of the whole file


class CurrentCall:
    """Written by the process of the trial, read by the process that watches it."""

    def __init__(self, path: Path):
        if not path.is_file():
            path.write_bytes(bytes(SIZE))
        with path.open("r+b") as file:
            self._memory = mmap.mmap(file.fileno(), SIZE)

    def clear(self) -> None:
        self._memory[:] = bytes(SIZE)

    def enter(self, call: str) -> None:
        self._memory[:CALL] = call.encode()[:CALL].ljust(CALL, b"\0")

    def leave(self) -> None:
        self._memory[0] = 0

    def log(self, message: str) -> None:
        room = SIZE - CALL
        self._memory[CALL:] = message.encode()[:room].ljust(room, b"\0")

    def read(self) -> tuple[str, str]:
        """The name of the call, empty outside calls, and the last message."""
        data = bytes(self._memory)
        call, message = (part.partition(b"\0")[0].decode("utf-8", "replace") for part in (data[:CALL], data[CALL:]))
        return call, message
