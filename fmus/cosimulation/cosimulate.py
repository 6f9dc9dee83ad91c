"""Units run together: set inputs, read outputs, step; rows out, power watched, a clear stop when it does not hold.

    from fmus.cosimulation import cosimulate
    from fmus.importer import FmuUnit

    units = {"vehicle": FmuUnit("motorcycle_sharp_1971.fmu", values={"speed": 30.0, "steer_rate": 0.5}),
             "device": FmuUnit("rider_mean_2011.fmu")}
    run = cosimulate(units, step=0.001, duration=5.0, out="run.csv")
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np

from fmus.bonds import Bond, bonds
from fmus.coupling import COUPLINGS, Coupling, Network, Unit
from fmus.coupling import coupling as named_coupling
from fmus.errors import InputError, SimulationError
from fmus.master import CompiledMaster, InterpretedMaster, Master, master
from fmus.ports import WORKS_ON
from fmus.prediction import Prediction, linear_network, longest_step, predict
from fmus.profiles import Profile
from fmus.progress import track
from fmus.results import Rows
from fmus.step_control import SEGMENT, StepControl
from fmus.wiring import join as by_names

LARGEST = 1e9  # a signal that exceeds this many times the largest start value, or 1, has diverged
TOLERANCE = 1e-5  # of a mode's frequency; ten times that of its damping ratio


@dataclass(frozen=True)
class Run:
    """What a run did.

    step [s] is the first one, steps how many there were, shortest and longest [s] the extremes. rows (n, columns) is empty when they went to `path`. predicted is None when nothing can be told of a unit.
    """

    step: float
    coupling: str
    columns: tuple[str, ...]
    rows: np.ndarray
    path: Path | None
    steps_per_second: float
    predicted: Prediction | None
    bonds: list[Bond]
    steps: int
    shortest: float
    longest: float

    @property
    def power_residual(self) -> float:
        """The largest residual power at any bond [W]."""
        return max((bond.power for bond in self.bonds), default=0.0)

    def __getitem__(self, column: str) -> np.ndarray:
        """A column (n,) of the rows by its name without the unit."""
        return self.rows[:, [c.partition(" [")[0] for c in self.columns].index(column)]


def cosimulate(units: Mapping[str, Unit], step: float | str, duration: float, coupling: str | None = None, *,
               wiring: Mapping[str, Sequence[str]] | None = None, profile: Profile | None = None, out: str | Path | None = None,
               tolerance: float = TOLERANCE, compiled: bool = True) -> Run:  # fmt: skip
    """Run units together from time 0 to `duration` [s]; equal names meet where no wiring is given.

    coupling names one of `fmus.coupling.COUPLINGS`; without it the cheapest is taken whose modes are within
    `tolerance`. step [s] is made a little smaller where it does not divide the duration; "auto" is the longest that is
    within the tolerance, and follows the run (`fmus.step_control`). profile gives inputs over time. compiled=False
    keeps the loop in Python. Raises InputError for what cannot be run, SimulationError when the coupling diverges.
    """
    wiring = join(units) if wiring is None else wiring
    network = Network(units, wiring)
    linear = _linear(units, wiring)
    follows = step == "auto"
    if isinstance(step, str):
        step = _automatic(step, linear, coupling, tolerance)
    step, count = steps(min(step, duration) if follows else step, duration)
    chosen, predicted = choose(network, linear, step, coupling, tolerance)
    profile = profile or Profile.constant(network)
    columns = ["time [s]", *(f"{name} [{_unit(network, name)}]" for name in network.outputs)]
    rows, watched = Rows(columns, out, count + 1), bonds(network, WORKS_ON)
    network.external[:] = profile.at(np.zeros(2))
    outputs = network.read(np.zeros(len(network.outputs)))
    rows.write(np.concatenate([[0.0], outputs])[None])
    control = StepControl(chosen, units, wiring, watched, step, tolerance)
    loop = _prepared(network, chosen, step, outputs, compiled)
    began = perf_counter()
    try:
        if follows:
            count = _segments(network, control, loop, duration, profile, rows, watched)
        else:
            _loop(loop, profile, 0.0, step, count, rows, watched)
    finally:
        rows.close()
    rate = count / (perf_counter() - began)
    return Run(step, chosen.name, rows.columns, rows.kept, rows.path, rate, predicted, watched, count, control.smallest, control.largest)


def _automatic(word: str, linear: Network | None, coupling: str | None, tolerance: float) -> float:
    """The step [s] with which an automatic one begins."""
    if word != "auto":
        raise InputError(f"step {word!r} is neither a number of seconds nor auto")
    if linear is None:
        raise InputError("step auto needs units that can be linearised; give the step in seconds")
    return longest_step(linear, coupling, tolerance)


def _prepared(network: Network, chosen: Coupling, step: float, outputs: np.ndarray, compiled: bool) -> Master:
    """The loop with a step [s], from where `outputs` (ny,) were read."""
    running = chosen.prepare(network, step)
    running.start(outputs)
    loop = master(network, running) if compiled else InterpretedMaster(network, running)
    loop.begin(outputs)
    return loop


def _segments(network: Network, control: StepControl, loop: Master, duration: float, profile: Profile, rows: Rows, watched: list[Bond]) -> int:
    """Steps whose length is decided anew after every segment; how many they were."""
    time, made, compiled = 0.0, 0, isinstance(loop, CompiledMaster)
    while duration - time > 1e-9 * duration:
        step, left = steps(min(control.step, duration - time), duration - time)
        if step != loop.running.step:  # at the end, a little shorter so as to divide what is left
            if left > SEGMENT:
                step = control.step
            network.external[:] = profile.at(np.full(2, time))
            loop = _prepared(network, control.chosen, step, network.read(loop.outputs.copy()), compiled)
        count = min(left, SEGMENT)
        _loop(loop, profile, time, step, count, rows, watched)
        time, made = time + count * step, made + count
        control.decide()
    return made


def _loop(loop: Master, profile: Profile, begin: float, step: float, count: int, rows: Rows, watched: list[Bond]) -> None:
    """Steps from a time [s], in chunks: rows written and flushed, power counted, divergence looked for."""
    chunk = min(loop.chunk, count)
    block, told = np.zeros((chunk, len(rows.columns))), np.zeros((chunk, len(profile.constant_values)))
    limit = LARGEST * max(1.0, step * count, begin, float(np.abs(loop.outputs).max(initial=0.0)))
    chunks = range(0, count, chunk)
    for first in track(chunks, "co-simulation", len(chunks)) if len(chunks) > 1 else chunks:
        size, failure = min(chunk, count - first), ""
        times = begin + (first + np.arange(size + 1)) * step
        try:
            loop.steps(profile.at(times), block[:size, 1:], told[:size])
        except SimulationError as error:
            failure = str(error)
        done = loop.done
        block[:done, 0] = times[1 : done + 1]
        if not (block[:done].max(initial=0.0) <= limit and block[:done].min(initial=0.0) >= -limit):
            wild = ~(np.abs(block[:done, 1:]).max(axis=1) <= limit)
            done, failure = int(wild.argmax()) + 1, "the signals have grown beyond all bounds"
        rows.write(block[:done])
        for bond in watched:
            bond.add(block[:done, 1:], told[:done], step)
        if failure:
            raise SimulationError(_diagnosis(failure, watched, begin + (first + done) * step, step))


def _diagnosis(failure: str, watched: list[Bond], time: float, step: float) -> str:
    worst = max(watched, key=lambda bond: abs(bond.energy), default=None)
    bond = f" at {worst.name} ({worst.energy:.3g} J made by the coupling, {worst.exchanged:.3g} J exchanged)" if worst else ""
    return f"stopped at {time:.6g} s{bond}: {failure}; take a smaller step than {step:g} s or a coupling of higher order"


def steps(step: float, duration: float) -> tuple[float, int]:
    """The step [s] that divides the duration, at most as large as the one given, and how many there are."""
    if not (np.isfinite(step) and step > 0):
        raise InputError(f"step = {step:g} s: a step must be positive and finite, as in 0.001")
    if not (np.isfinite(duration) and duration > 0):
        raise InputError(f"duration = {duration:g} s: a duration must be positive and finite, as in 5")
    if step > duration:
        raise InputError(f"step = {step:g} s is longer than the duration of {duration:g} s")
    count = int(np.ceil(duration / step * (1 - 1e-9)))
    return duration / count, count


def join(units: Mapping[str, Unit]) -> dict[str, list[str]]:
    """The wiring in which equal names meet; several torques on one input add up.

    Raises InputError for an input with two writers that is neither torque nor force.
    """
    return by_names(units, lambda _, name: name in WORKS_ON)


def _unit(network: Network, name: str) -> str:
    unit, _, variable = name.partition(".")
    return network.units[unit].unit_of(variable)


def _linear(units: Mapping[str, Unit], wiring: Mapping[str, Sequence[str]]) -> Network | None:
    """The linear models of the units; None where one does not even restart, so that nothing can be told of it."""
    try:
        return linear_network(units, wiring)
    except SimulationError:
        return None


def choose(network: Network, linear: Network | None, step: float, name: str | None, tolerance: float) -> tuple[Coupling, Prediction | None]:
    """The coupling of that name, or the cheapest that the units can do and that meets the tolerance; its prediction.

    Where none meets it, the one with the smallest error. Raises InputError when the units cannot do what was asked.
    """
    if name is not None:
        chosen = named_coupling(name)
        missing = chosen.lacks(network)
        if missing:
            names = [c.name for c in COUPLINGS.values() if not c.lacks(network)]
            raise InputError(f"coupling {name!r} is not possible: {missing} (possible: {', '.join(names)})")
        return chosen, predict(chosen, linear, step) if linear else None
    able = [c for c in COUPLINGS.values() if not c.lacks(network)]
    if linear is None:
        return next(c for c in reversed(able) if c.order == max(a.order for a in able)), None
    best: tuple[float, Coupling, Prediction] | None = None
    for candidate in able:
        prediction = predict(candidate, linear, step)
        error = prediction.worst
        if error <= tolerance:
            return candidate, prediction
        if best is None or error < best[0]:
            best = error, candidate, prediction
    assert best is not None
    return best[1], best[2]
