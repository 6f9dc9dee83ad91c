"""The callbacks of FMI 3 that an FMU calls within a communication step (FMI 3.0, 4.2.1) or while a model partition is
computed (5.2.1).

An exception cannot leave a callback: it is kept, and raised by `settle` once the FMU has returned.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from fmus.checks.calls import Calls
from fmus.checks.fmi_library import PLAIN
from fmus.checks.model import Variable

UPDATE = "void(void *, double, _Bool, _Bool, _Bool, _Bool, _Bool *, double *)"


@dataclass(frozen=True)
class Update:
    """The arguments of an intermediate update."""

    time: float
    settable: bool
    readable: bool
    finished: bool
    can_return: bool


class Callbacks:
    """What an importer offers to one instance.

    intermediate are the variables that it sets and gets in updates; on_update is called in each, and returns whether
    to ask for an early return; on_clock is called when an output clock ticks or an interval becomes known. Without
    on_update there are no intermediate updates.
    """

    def __init__(
        self,
        intermediate: Sequence[Variable] = (),
        early_return: bool = False,
        on_update: Callable[[Update], bool] | None = None,
        on_clock: Callable[[], None] | None = None,
    ):
        self.intermediate, self.early_return = intermediate, early_return
        self.intermediate_update: Any = PLAIN.NULL
        self.clock_update: Any = PLAIN.NULL
        self.lock: Any = PLAIN.NULL
        self.unlock: Any = PLAIN.NULL
        self.locked = 0  # locks of preemption that have not been undone
        self._on_update, self._on_clock = on_update, on_clock
        self._failed: Exception | None = None
        self._keep: list[Any] = []

    def attach(self, fmu: Calls, arguments: Sequence[Any], scheduled: bool) -> None:
        """Make the functions for an instance, from the types of the arguments of its instantiation."""

        def made(signature: str, function: Callable[..., None], kind: Any) -> Any:
            self._keep.append(PLAIN.callback(signature, function))
            return PLAIN.cast(kind, self._keep[-1])

        def update(_: Any, time: float, settable: bool, readable: bool, finished: bool, can_return: bool,
                   requested: Any, until: Any) -> None:  # fmt: skip
            given = Update(time, settable, readable, finished, can_return)
            wanted = self._kept(fmu, lambda: bool(self._on_update and self._on_update(given)))
            requested[0], until[0] = bool(wanted), time

        def clock(_: Any) -> None:
            self._kept(fmu, self._on_clock or (lambda: None))

        def preemption(change: int) -> Callable[[], None]:
            return lambda: setattr(self, "locked", self.locked + change)

        if scheduled:
            self.clock_update = made("void(void *)", clock, arguments[-3])
            self.lock, self.unlock = (made("void(void)", preemption(c), arguments[-k]) for c, k in ((1, 2), (-1, 1)))
        elif self._on_update:
            self.intermediate_update = made(UPDATE, update, arguments[-1])

    def _kept(self, fmu: Calls, action: Callable[[], Any]) -> Any:
        """What an action returns; its first exception is kept. The FMU is in its own call again afterwards."""
        call = fmu.library.current.read()[0]
        try:
            return action() if self._failed is None else None
        except Exception as failed:
            self._failed = failed
            return None
        finally:
            fmu.library.current.enter(call)

    def settle(self) -> None:
        """Raise what a callback has raised."""
        if self._failed is not None:
            raise self._failed
