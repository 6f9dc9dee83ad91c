"""One instance of an FMU: FMI 2.0 and 3.0, model exchange and co-simulation under one set of names.

Calls follow the state machines of the standard (FMI 2.0.4, 3.2.3 and 4.2.4; FMI 3.0, 2.3, 3.2 and 4.2): after an error
only reset and free, after a fatal error nothing.
"""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fmus.checks.callbacks import Callbacks
from fmus.checks.calls import DISCARD, OK, WARNING, CallFailedError, Calls, EndedError, FmiCall
from fmus.checks.fmi_library import FmiLibrary
from fmus.checks.model import Model, Variable

ITERATIONS = 1000  # of events at one instant
RUNNING = ("event", "continuous", "step", "activation")  # phases that end with Terminate
TINY = 1e-9  # of a time: rounding
SavedState = tuple[Any, float, float]  # the FMU's handle, the time and that of the next event [s]


class Instance(Calls):
    """An instance, before initialisation. time is the time that it has reached [s], internal_time the one that it
    reported last; early whether its last step returned early."""

    def __init__(
        self, library: FmiLibrary, model: Model, kind: str, folder: Path, token: str | None = None,
        callbacks: Callbacks | None = None,
    ):  # fmt: skip
        super().__init__(library, model)
        self.kind, self.exchange = kind, kind == "ModelExchange"
        self.scheduled, self.callbacks = kind == "ScheduledExecution", callbacks or Callbacks()
        start = model.experiment("startTime")
        self.start = self.time = self.internal_time = start if math.isfinite(start) else 0.0
        self.early = False
        self.next_event = math.inf
        self.steps_end_in_events = model.flag(kind, "", "hasEventMode")
        self._instantiate(folder, model.token if token is None else token)

    def _instantiate(self, folder: Path, token: str | None) -> None:
        resources = folder.resolve() / "resources"
        texts = [self.ffi.new("char[]", text.encode()) for text in ("check", token or "")]
        if self.version == "2":
            name, place = "fmi2Instantiate", self.ffi.new("char[]", resources.as_uri().encode())
            kind = int(not self.exchange)
            arguments: tuple[Any, ...] = (texts[0], kind, texts[1], place, self.library.callbacks, 0, 1)
        else:
            name = f"fmi3Instantiate{self.kind}"
            place = self.ffi.new("char[]", f"{resources}/".encode()) if resources.is_dir() else self.ffi.NULL
            arguments = (texts[0], texts[1], place, False, True, *self._callbacks())
        self._keep = (*texts, place)
        self.handle = self.library(name, *arguments)
        if self.handle == self.ffi.NULL:
            self.last = FmiCall(name, "NULL", self._log())
            how = " with eventModeUsed = true, which hasEventMode permits" * self.steps_end_in_events
            raise CallFailedError(self.last, f"{name} returns no instance{how}")
        self.phase = "instantiated"

    def _callbacks(self) -> tuple[Any, ...]:
        """The arguments of an instance of FMI 3 that depend on its kind. Clocks require event mode."""
        mine, environment = self.callbacks, (self.ffi.NULL, self.library.logger)
        if self.exchange:
            return environment
        mine.attach(self, self.library.types[f"fmi3Instantiate{self.kind}"].args, self.scheduled)
        if self.scheduled:
            return (*environment, mine.clock_update, mine.lock, mine.unlock)
        variables = self.references(mine.intermediate) if mine.intermediate else self.ffi.NULL
        many = len(mine.intermediate)
        return (self.steps_end_in_events, mine.early_return, variables, many, *environment, mine.intermediate_update)

    # Life --------------------------------------------------------------------------------------------------

    def enter_initialisation(self) -> None:
        self.time = self.start
        if self.version == "2":
            self.call("SetupExperiment", 0, 0.0, self.start, 0, 0.0)
            self.call("EnterInitializationMode")
        else:
            self.call("EnterInitializationMode", False, 0.0, self.start, False, 0.0)
        self.phase = "initialisation"

    def exit_initialisation(self) -> None:
        """To continuous-time or step mode, through the events of the start; to clock activation mode."""
        self.call("ExitInitializationMode")
        if self.scheduled:
            self.phase = "activation"
        elif self.exchange or self.steps_end_in_events:
            self.phase = "event"
            self.settle()
        else:
            self.phase = "step"

    def initialise(self) -> None:
        self.enter_initialisation()
        self.exit_initialisation()

    def settle(self) -> None:
        """Event iteration, then continuous-time or step mode. Raises EndedError where the FMU asks for the end."""
        self.iterate()
        self.leave_event()

    def leave_event(self) -> None:
        self.call("EnterContinuousTimeMode" if self.exchange else "EnterStepMode")
        self.phase = "continuous" if self.exchange else "step"

    def enter_event(self) -> None:
        self.call("EnterEventMode")
        self.phase = "event"

    def iterate(self) -> None:
        """Event iteration, which stays in event mode. Raises EndedError where the FMU asks for the end."""
        for _ in range(ITERATIONS):
            again, ends = self._update()
            if ends:
                raise EndedError
            if not again:
                break
        else:
            raise CallFailedError(
                self.last, f"{self.last.name} asks for new discrete states {ITERATIONS} times at {self.time:g} s"
            )

    def _update(self) -> tuple[bool, bool]:
        if self.version == "2":
            info = self.ffi.new(self.library.types["fmi2NewDiscreteStates"].args[1])
            self.call("NewDiscreteStates", info)
            self.next_event = info.nextEventTime if info.nextEventTimeDefined else math.inf
            return bool(info.newDiscreteStatesNeeded), bool(info.terminateSimulation)
        flags, time = self.ffi.new("bool[5]"), self.ffi.new("double *")
        self.call("UpdateDiscreteStates", *(flags + i for i in range(5)), time)
        self.next_event = time[0] if flags[4] else math.inf
        return bool(flags[0]), bool(flags[1])

    def event(self) -> None:
        self.enter_event()
        self.settle()

    def reset(self) -> None:
        """From any state but the fatal one; a simulation that runs is terminated first."""
        if self.phase in RUNNING:
            self.call("Terminate")
        self.call("Reset")
        self.phase, self.next_event = "instantiated", math.inf

    def terminate(self) -> None:
        self.call("Terminate")
        self.phase = "terminated"

    def abandon(self) -> None:
        """Free the instance without ending its simulation, which every state but the fatal one permits."""
        if self.phase not in ("fatal", "none"):
            self.phase = "none"
            self.library(f"{self.prefix}FreeInstance", self.handle)

    def close(self) -> None:
        """End and free the instance as its state permits."""
        if self.phase in RUNNING:
            self.terminate()
        self.abandon()

    # Continuous states -------------------------------------------------------------------------------------

    @property
    def order(self) -> int:
        return sum(self.model.size(v) for v in self.model.states)

    def states(self) -> np.ndarray:
        return self.filled("GetContinuousStates", self.order, "continuous states")

    def rates(self) -> np.ndarray:
        name = "GetDerivatives" if self.version == "2" else "GetContinuousStateDerivatives"
        return self.filled(name, self.order, "derivatives")

    def nominals(self) -> np.ndarray:
        return self.filled("GetNominalsOfContinuousStates", self.order, "nominals of continuous states")

    def indicators(self) -> np.ndarray:
        return self.filled("GetEventIndicators", self.model.event_indicators, "event indicators")

    def set_states(self, states: np.ndarray) -> None:
        if len(states):
            self.call(
                "SetContinuousStates", self.ffi.from_buffer("double[]", np.ascontiguousarray(states)), len(states)
            )

    def set_time(self, time: float) -> None:
        self.call("SetTime", time)
        self.time = time

    def completed_step(self) -> bool:
        """Whether the FMU asks for an event. Raises EndedError where it asks for the end."""
        if self.version == "2":
            enter, ends = self.ffi.new("int *"), self.ffi.new("int *")
            self.call("CompletedIntegratorStep", 1, enter, ends)
        else:
            enter, ends = self.ffi.new("bool *"), self.ffi.new("bool *")
            self.call("CompletedIntegratorStep", True, enter, ends)
        if ends[0]:
            raise EndedError
        return bool(enter[0])

    # Steps -------------------------------------------------------------------------------------------------

    def do_step(self, step: float) -> None:
        """One communication step. Raises CallFailedError, EndedError where the FMU ends the simulation."""
        if self.version == "2":
            status = self.attempt("DoStep", self.time, step, 0)
            if status == DISCARD:
                self._discarded2()
            if status not in (OK, WARNING):
                raise CallFailedError(
                    self.last,
                    f"{self.last.name} returns {self.last.status} for a step from {self.time:g} s over {step:g} s",
                )
            self.time = self.internal_time = self.time + step
            return
        flags, last = self.ffi.new("bool[3]"), self.ffi.new("double *", self.time + step)
        status = self.attempt("DoStep", self.time, step, False, flags, flags + 1, flags + 2, last)
        if status not in (OK, WARNING):
            raise CallFailedError(
                self.last,
                f"{self.last.name} returns {self.last.status} for a step from {self.time:g} s over {step:g} s",
            )
        self._reached(step, flags[0], flags[1], flags[2], last[0])

    def _reached(self, step: float, event: bool, ends: bool, early: bool, reached: float) -> None:
        """What a step of FMI 3 reports (4.2.1). Without an early return its own time may differ from the point."""
        before = self.time
        what = f"after a step from {before:g} s over {step:g} s"
        if early and not self.callbacks.early_return:
            raise CallFailedError(self.last, f"{self.last.name} returns early, which was not allowed, {what}")
        if event and not self.steps_end_in_events:
            raise CallFailedError(self.last, f"{self.last.name} asks for event mode, which was not agreed, {what}")
        end, slack = before + step, TINY * max(1.0, abs(before) + step)
        valid = before - slack <= reached <= end + slack if early else reached >= self.start - slack
        if not (math.isfinite(reached) and valid):
            raise CallFailedError(self.last, f"{self.last.name} reports the last successful time {reached:g} s {what}")
        early = early and reached < end - slack
        self.time, self.internal_time, self.early = (reached if early else end), reached, early
        if ends:
            raise EndedError
        if event:
            self.event()

    def _discarded2(self) -> None:
        """A discarded step with the status `terminated` is an end that the FMU asks for (FMI 2.0.4, 4.2.3)."""
        said, ends = self.last, self.ffi.new("int *")
        if self.library.has("fmi2GetBooleanStatus") and self.attempt("GetBooleanStatus", 3, ends) == OK and ends[0]:
            raise EndedError
        self.last = said

    # State -------------------------------------------------------------------------------------------------

    @property
    def _state_word(self) -> str:
        return "FMUstate" if self.version == "2" else "FMUState"

    def save(self) -> SavedState:
        place = self.ffi.new("void **")
        self.call(f"Get{self._state_word}", place)
        if place[0] == self.ffi.NULL:
            raise CallFailedError(self.last, f"{self.last.name} gives no state")
        return place, self.time, self.next_event

    def restore(self, saved: SavedState) -> None:
        self.call(f"Set{self._state_word}", saved[0][0])
        self.time, self.next_event = saved[1], saved[2]
        self.internal_time = self.time

    def free_state(self, saved: SavedState) -> None:
        self.call(f"Free{self._state_word}", saved[0])

    def to_bytes(self, saved: SavedState) -> bytes:
        size = self.ffi.new("size_t *")
        self.call(f"Serialized{self._state_word}Size", saved[0][0], size)
        data = np.zeros(size[0], np.uint8)
        self.call(f"Serialize{self._state_word}", saved[0][0], self._bytes(data), size[0])
        return data.tobytes()

    def from_bytes(self, data: bytes, saved: SavedState) -> SavedState:
        place = self.ffi.new("void **")
        word = "DeSerialize" if self.version == "2" else "Deserialize"
        self.call(f"{word}{self._state_word}", self._bytes(np.frombuffer(data, np.uint8)), len(data), place)
        return place, saved[1], saved[2]

    def _bytes(self, data: np.ndarray) -> Any:
        return self.ffi.from_buffer("char[]" if self.version == "2" else "uint8_t[]", data)

    # Derivatives -------------------------------------------------------------------------------------------

    def directional(self, unknowns: Sequence[Variable], known: Variable, seed: np.ndarray) -> np.ndarray:
        """Derivatives of the unknowns' elements in the direction of the seed of one known variable."""
        result = np.full(sum(self.model.size(v) for v in unknowns), np.nan)
        double = "double[]"
        self.call("GetDirectionalDerivative", self.references(unknowns), len(unknowns), self.references([known]), 1,
                  self.ffi.from_buffer(double, seed), *self.count(len(seed)), self.ffi.from_buffer(double, result),
                  *self.count(len(result)))  # fmt: skip
        return result

    def adjoint(self, unknowns: Sequence[Variable], knowns: Sequence[Variable], seed: np.ndarray) -> np.ndarray:
        """Seed (n unknowns) times the Jacobian: (n knowns,)."""
        result = np.full(sum(self.model.size(v) for v in knowns), np.nan)
        double = "double[]"
        self.call(
            "GetAdjointDerivative", self.references(unknowns), len(unknowns), self.references(knowns), len(knowns),
            self.ffi.from_buffer(double, seed), len(seed), self.ffi.from_buffer(double, result), len(result),
        )  # fmt: skip
        return result
