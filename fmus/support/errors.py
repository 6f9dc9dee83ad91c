"""Errors that a user can act on: what was given, what was expected, the valid choices."""

from collections.abc import Iterable
from difflib import get_close_matches


class InputError(ValueError):
    """Something that was given is wrong. Its message is one line; the command line exits with status 2."""


class MissingToolError(RuntimeError):
    """A tool outside Python is missing (a C compiler, say). Its message says how to get it."""


class SimulationError(RuntimeError):
    """A simulation cannot go on. Its message is one line: where, when and what to change; the exit status is 1."""


def unknown(kind: str, given: object, valid: Iterable[str]) -> InputError:
    """The error for a name that does not exist: names the kind, the nearest name and all valid ones."""
    names = sorted(valid)
    near = get_close_matches(str(given), names, n=1)
    hint = f", did you mean {near[0]!r}?" if near else ""
    return InputError(f"unknown {kind} {str(given)!r}{hint} (valid: {', '.join(names) or 'none'})")
