"""FMI 3, scheduled execution: model partitions one after another, in the order of time and priority.

Preemption is not tried: it needs tasks of a real-time system. Each partition is activated by the ticks of its clock;
the output clocks that tick and the intervals of countdown clocks are asked for in the callback of clock updates, the
variables of a clock are read after the partition.
"""

import heapq
import math
from collections.abc import Iterator
from dataclasses import dataclass, field

from fmus.checks.callbacks import Callbacks
from fmus.checks.clocked import (
    CHANGED,
    PERIODIC,
    Timing,
    clocks,
    interval,
    judged,
    read,
    ticking,
    timings,
    variability,
)  # fmt: skip
from fmus.checks.instance import Instance
from fmus.checks.model import Variable, whole
from fmus.checks.problem import Problem
from fmus.checks.trial import Trial

PLACE, SEVERITY = 2, "error"
KINDS = ("ScheduledExecution",)
ACTIVATIONS = 100


def applies(trial: Trial) -> bool:
    return any(v.type == "Clock" and v.causality == "input" for v in trial.model.variables)


@dataclass
class Schedule:
    """The activations that are due, by time, priority and place; the last one of each place, the output clocks that
    have ticked since the last reading, and the problems met in callbacks."""

    due: list[tuple[float, int, int]] = field(default_factory=list)
    last: dict[int, float] = field(default_factory=dict)
    ticking: list[Variable] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)
    now: float = 0.0

    def add(self, time: float, clock: Variable, inputs: list[Variable]) -> None:
        if math.isfinite(time):
            priority = whole(clock.element.get("priority")) or 0
            heapq.heappush(self.due, (time, priority, inputs.index(clock)))


def run(trial: Trial) -> Iterator[Problem]:
    inputs = [v for v in trial.model.variables if v.type == "Clock" and v.causality == "input"]
    plan = Schedule()

    def updated() -> None:
        plan.ticking += ticking(fmu, trial.model)
        for clock in (c for c in inputs if variability(c) == "countdown"):
            found = interval(fmu, clock)
            plan.problems += judged(trial, fmu, clock, found)
            if found.qualifier == CHANGED:
                plan.add(plan.now + found.seconds, clock, inputs)

    fmu = trial.instance(callbacks=Callbacks(on_clock=updated))
    fmu.enter_initialisation()
    times, problems = timings(trial, fmu)
    yield from problems
    fmu.exit_initialisation()
    for clock in clocks(trial.model, "input"):
        plan.add(fmu.start + (times[clock.name].first if clock.name in times else 0.0), clock, inputs)
    stop = trial.model.experiment("stopTime")
    for _ in range(ACTIVATIONS):
        if not plan.due or (math.isfinite(stop) and plan.due[0][0] > stop):
            return
        yield from _activated(trial, fmu, plan, inputs, times)


def _activated(
    trial: Trial, fmu: Instance, plan: Schedule, inputs: list[Variable], times: dict[str, Timing]
) -> Iterator[Problem]:
    """The next partition: once for a clock and a time (5.2.1)."""
    plan.now, _, place = heapq.heappop(plan.due)
    clock = inputs[place]
    if plan.now <= plan.last.get(place, -math.inf):
        return
    plan.last[place] = fmu.time = plan.now
    fmu.call("ActivateModelPartition", clock.reference, plan.now)
    fmu.callbacks.settle()
    if fmu.callbacks.locked:
        message = f"the partition of {clock.name} ends with preemption locked {fmu.callbacks.locked} times"
        yield trial.error(message, fmu.last, trial.section("", "5.1.2"))
    if variability(clock) == "changing":
        found = interval(fmu, clock)
        plan.problems += judged(trial, fmu, clock, found)
        plan.add(plan.now + found.seconds, clock, inputs)
    elif variability(clock) in PERIODIC:
        plan.add(plan.now + times[clock.name].period, clock, inputs)
    yield from plan.problems
    read(fmu, trial.model, [clock, *plan.ticking])
    plan.problems.clear()
    plan.ticking.clear()
