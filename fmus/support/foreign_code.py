"""Notices that code of others ends this process, as an FMU that calls `exit`.

Python code does not notice it: the C library ends the process with the status that the code gave, which may be 0. A
handler of the C library reports it instead, where handlers can be removed again: with glibc and on macOS. `_exit` calls
no handler.
"""

import ctypes
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress

Report = Callable[[Sequence[str]], str]  # the message, of the names of the foreign code that was entered

_watched: list["_Exit"] = []  # the contexts that last, the innermost at the end


@contextmanager
def exits_reported(report: Report) -> Iterator[None]:
    """While the context lasts, foreign code that ends the process causes a message on standard error and status 1."""
    _watched.append(_Exit(report))
    try:
        yield
    finally:
        _watched.pop().remove()


def entered(name: str) -> None:
    """Note that foreign code is about to be called, before its library is loaded."""
    if _watched:
        _watched[-1].note(name)


class _Exit:
    """The handler of one context. It is installed when foreign code is first entered."""

    def __init__(self, report: Report):
        self._report, self._names, self._installed = report, dict[str, None](), False
        self._handler = ctypes.CFUNCTYPE(None, ctypes.c_void_p)(self._ended)
        self._key = ctypes.create_string_buffer(1)  # its address identifies the handler

    def note(self, name: str) -> None:
        self._names[name] = None
        if not self._installed and _has_handlers():
            self._installed = _c("__cxa_atexit")(self._handler, None, self._key) == 0

    def remove(self) -> None:
        """The C library removes a handler by calling it."""
        if self._installed:
            self._installed = False
            _c("__cxa_finalize")(self._key)

    def _ended(self, _: object) -> None:
        if not self._installed:
            return
        for stream, text in ((sys.stdout, ""), (sys.stderr, f"{self._report(list(self._names))}\n")):
            with suppress(OSError, ValueError):
                stream.write(text)
                stream.flush()
        os._exit(1)


def _c(name: str) -> Callable[..., int]:
    """A function of the C library."""
    return getattr(ctypes.CDLL(None), name)  # type: ignore[no-any-return]


def _has_handlers() -> bool:
    return sys.platform == "darwin" or "CS_GNU_LIBC_VERSION" in getattr(os, "confstr_names", {})
