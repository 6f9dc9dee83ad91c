"""Errors that a user can act on: each message says what was given, what was expected and which choices are valid."""

from collections.abc import Iterable
from difflib import get_close_matches


class InputError(ValueError):
    """Invalid input. The message is one line; the command line exits with status 2.

        >>> try:
        ...     mf.rider("mean_2012")
        ... except mf.InputError as error:
        ...     print(str(error)[:54])
        unknown rider 'mean_2012', did you mean 'mean_2011'? (
    """


class NotApplicableError(InputError):
    """An effect does not apply to a component: it lacks what the effect needs, or has variables of these names."""


class MissingToolError(RuntimeError):
    """A tool outside Python is missing, such as a C compiler. The message says how to install it."""


class SimulationError(RuntimeError):
    """A simulation cannot continue. The message says where, when and what to change; the exit status is 1."""


class StepTooLongError(SimulationError):
    """A step failed, and a shorter one may not: an FMU has discarded it, or an iteration did not converge."""


class EndRequestedError(SimulationError):
    """An FMU has asked for the end of the simulation, at `time` [s]."""

    def __init__(self, name: str, time: float):
        super().__init__(f"{name} asked for the end of the simulation at {time:g} s")
        self.time = time


def unknown(
    kind: str, given: object, valid: Iterable[str], error: type[InputError] = InputError
) -> InputError:
    """The error for a name that does not exist. It gives the kind, the most similar name, which may be given without
    the kind before its colon, and all valid names.

        raise unknown("mode", "weve", MODES)     # unknown mode 'weve', did you mean 'weave'? (valid: capsize, ...)
    """
    names = sorted(valid)
    whole = {n.rpartition(":")[2]: n for n in names} | {n: n for n in names}
    near = get_close_matches(str(given), whole, n=1)
    hint = f", did you mean {whole[near[0]]!r}?" if near else ""
    return error(f"unknown {kind} {str(given)!r}{hint} (valid: {', '.join(names) or 'none'})")
