"""Co-simulation of subsystems: inputs are set, outputs read, steps made; rows are written and the
power bonds evaluated.

    from fmus.cosimulation.cosimulate import cosimulate
    from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem

    rider = FmuSubsystem("rider_mean_2011.fmu")
    values = {"speed": 30.0, "steer_rate": 0.5, "added_steer_inertia": rider.get("port_inertia")}
    subsystems = {"vehicle": FmuSubsystem("motorcycle_sharp_1971.fmu", values=values), "device": rider}
    run = cosimulate(subsystems, step=0.001, duration=5.0, out="run.csv")

`motofmi.cosimulate` binds what a rider changes of the vehicle: the inertia at the handlebar, as above, and the
mass of a rider who leans.
"""

import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from time import perf_counter

import numpy as np

from fmus.composition.wiring import join as by_names
from fmus.cosimulation.cosimulation_run import CosimulationRun
from fmus.cosimulation.coupling import COUPLINGS, Coupling
from fmus.cosimulation.coupling import coupling as named_coupling
from fmus.cosimulation.coupling_error import Prediction, ToleranceWarning, assess, linear_network, longest_step, predict
from fmus.cosimulation.master.select import CompiledMaster, InterpretedMaster, Master, master
from fmus.cosimulation.network import Network
from fmus.cosimulation.power_bonds import PowerBond, power_bonds
from fmus.cosimulation.profiles import Profile
from fmus.cosimulation.results import Rows, heading
from fmus.cosimulation.step_control import SEGMENT, StepControl
from fmus.cosimulation.subsystems.subsystem import Subsystem
from fmus.interfaces.handlebar import CONJUGATE_RATES, unbound_inertia
from fmus.support.errors import InputError, SimulationError, StepTooLongError
from fmus.support.progress import track

LARGEST = 1e9  # a signal that exceeds this many times the largest start value, or 1, has diverged
MOST_STEPS = 1_000_000_000  # days of computation; more are taken for a typing error and refused
TOLERANCE = 1e-5  # of a mode's frequency; ten times that of its damping ratio


def cosimulate(subsystems: Mapping[str, Subsystem], step: float | str, duration: float, coupling: str | None = None, *,
               wiring: Mapping[str, Sequence[str]] | None = None, profile: Profile | None = None,
               out: str | Path | None = None, tolerance: float = TOLERANCE,
               compiled: bool = True) -> CosimulationRun:  # fmt: skip
    """Run subsystems together from time 0 to `duration` [s]; equal names meet where no wiring is given.

    coupling names one of `fmus.cosimulation.coupling.COUPLINGS`; without it the cheapest is taken whose modes are
    within `tolerance`. step [s] is made a little smaller where it does not divide the duration; "auto" is the longest
    that is within the tolerance, and follows the run (`fmus.cosimulation.step_control`). profile gives inputs over
    time. compiled=False keeps the loop in Python.

    The run says whether the predicted errors are within the tolerance; where no coupling is named and none meets it, a
    ToleranceWarning says which step would. Raises InputError for what cannot be run, as more than MOST_STEPS steps,
    inputs that end before the run or begin after it, or subsystems without a real input, SimulationError when the
    coupling diverges. Warns, too, where the inertia that a rider adds at the handlebar is missing in the other subsystem
    (`fmus.interfaces.handlebar.unbound_inertia`).
    """
    if missing := unbound_inertia(subsystems):
        warnings.warn(missing, stacklevel=2)
    wiring = join(subsystems) if wiring is None else wiring
    network = Network(subsystems, wiring)
    linear = _linear(subsystems, wiring)
    follows = step == "auto"
    if isinstance(step, str):
        step = _automatic(step, linear, coupling, tolerance)
    step, count = steps(min(step, duration) if follows else step, duration)
    chosen, predicted = choose(network, linear, step, coupling, tolerance)
    assessed = assess(chosen, predicted, linear, step, tolerance) if linear and predicted else None
    if assessed and assessed.advice and coupling is None:
        warnings.warn(assessed.advice, ToleranceWarning, stacklevel=2)
    profile = profile or Profile.constant(network)
    profile.uncovered(0.0, duration)
    columns = ["time [s]", *(heading(name, network.unit_of(name)) for name in network.outputs)]
    rows, watched = Rows(columns, out, count + 1), power_bonds(network, CONJUGATE_RATES)
    network.external[:] = profile.at(np.zeros(2))
    outputs = network.read(np.zeros(len(network.outputs)))
    rows.write(np.concatenate([[0.0], outputs])[None])
    control = StepControl(chosen, subsystems, wiring, watched, step, tolerance)
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
    return CosimulationRun(step, chosen.name, rows.columns, rows.kept, rows.path, rate, predicted, watched, count,
                           control.smallest, control.largest, assessed.meets_tolerance if assessed else None,
                           assessed.advice if assessed else None)  # fmt: skip


def _automatic(word: str, linear: Network | None, coupling: str | None, tolerance: float) -> float:
    """The initial step [s] of an automatic step."""
    if word != "auto":
        raise InputError(f"step {word!r} is neither a number of seconds nor auto")
    if linear is None:
        raise InputError("step auto needs subsystems that can be linearised; give the step in seconds")
    return longest_step(linear, coupling, tolerance)


def _prepared(network: Network, chosen: Coupling, step: float, outputs: np.ndarray, compiled: bool) -> Master:
    """The loop with a step [s], from where `outputs` (ny,) were read."""
    state = chosen.prepare(network, step)
    state.start(outputs)
    loop = master(network, state) if compiled else InterpretedMaster(network, state)
    loop.begin(outputs)
    return loop


def _segments(
    network: Network,
    control: StepControl,
    loop: Master,
    duration: float,
    profile: Profile,
    rows: Rows,
    watched: list[PowerBond],
) -> int:
    """Steps whose length is chosen again after every segment; returns their number."""
    time, made, compiled = 0.0, 0, isinstance(loop, CompiledMaster)
    while duration - time > 1e-9 * duration:
        step, left = steps(min(control.step, duration - time), duration - time)
        if step != loop.state.step:  # at the end, a little shorter so as to divide what is left
            if left > SEGMENT:
                step = control.step
            network.external[:] = profile.at(np.full(2, time))
            loop = _prepared(network, control.chosen, step, network.read(loop.outputs.copy()), compiled)
        count = min(left, SEGMENT)
        _loop(loop, profile, time, step, count, rows, watched)
        time, made = time + count * step, made + count
        control.decide()
    return made


def _loop(
    loop: Master, profile: Profile, begin: float, step: float, count: int, rows: Rows, watched: list[PowerBond]
) -> None:
    """Steps from a time [s], in chunks: rows are written, power bonds evaluated, divergence is detected."""
    chunk = min(loop.chunk, count)
    block, end_inputs = np.zeros((chunk, len(rows.columns))), np.zeros((chunk, len(profile.constant_values)))
    limit = LARGEST * max(1.0, step * count, begin, float(np.abs(loop.outputs).max(initial=0.0)))
    chunks = range(0, count, chunk)
    for first in track(chunks, "co-simulation", len(chunks)) if len(chunks) > 1 else chunks:
        size, failure, advised = min(chunk, count - first), "", False
        times = begin + (first + np.arange(size + 1)) * step
        try:
            loop.steps(profile.at(times), block[:size, 1:], end_inputs[:size])
        except SimulationError as error:
            failure, advised = str(error), isinstance(error, StepTooLongError)
        done = loop.done
        block[:done, 0] = times[1 : done + 1]
        if not (block[:done].max(initial=0.0) <= limit and block[:done].min(initial=0.0) >= -limit):
            wild = ~(np.abs(block[:done, 1:]).max(axis=1) <= limit)
            done, failure, advised = int(wild.argmax()) + 1, "the signals diverge", True
        rows.write(block[:done])
        for bond in watched:
            bond.add(block[:done, 1:], end_inputs[:done], step)
        if failure:
            advice = f"; take a smaller step than {step:g} s or a coupling of higher order" if advised else ""
            raise SimulationError(_diagnosis(failure, watched, begin + (first + done) * step) + advice)


def _diagnosis(failure: str, watched: list[PowerBond], time: float) -> str:
    worst = max(watched, key=lambda bond: abs(bond.energy), default=None)
    bond = (
        f" at {worst.name} ({worst.energy:.3g} J added by the coupling, {worst.exchanged:.3g} J exchanged)"
        if worst
        else ""
    )
    return f"stopped at {time:.6g} s{bond}: {failure}"


def steps(step: float, duration: float, most: int = MOST_STEPS) -> tuple[float, int]:
    """The step [s] that divides the duration, at most as large as the one given, and how many there are.

    Raises InputError for a step or a duration that is not positive, and for more steps than `most`.
    """
    if not (np.isfinite(duration) and duration > 0):  # first, because a step that is not given is at most the duration
        raise InputError(f"duration = {duration:g} s: a duration must be positive and finite, as in 5")
    if not (np.isfinite(step) and step > 0):
        raise InputError(f"step = {step:g} s: a step must be positive and finite, as in 0.001")
    if step > duration:
        raise InputError(f"step = {step:g} s is longer than the duration of {duration:g} s")
    rows = duration / step * (1 - 1e-9)
    if rows > most:
        wanted = duration / step
        shown = f"{wanted:,.0f}" if wanted < 1e15 else f"{wanted:.3g}" if np.isfinite(wanted) else "more than 1e308"
        raise InputError(f"step = {step:g} s over a duration of {duration:g} s gives {shown} rows of output; expected at "
                         f"most {most:,}: give a step of {_rounded_up(duration / most):g} s or more, or a "
                         "shorter duration")  # fmt: skip
    count = int(np.ceil(rows))
    return duration / count, count


def _rounded_up(step: float) -> float:
    """A step [s] with two digits, not below the one given."""
    digit = 10.0 ** (np.floor(np.log10(step)) - 1)
    return float(np.ceil(step / digit * (1 - 1e-9)) * digit)


def join(subsystems: Mapping[str, Subsystem]) -> dict[str, list[str]]:
    """The wiring in which equal names meet; several torques on one input add up.

    Raises InputError for an input with two writers that is neither torque nor force.
    """
    return by_names(subsystems, lambda _, name: name in CONJUGATE_RATES)


def _linear(subsystems: Mapping[str, Subsystem], wiring: Mapping[str, Sequence[str]]) -> Network | None:
    """The linear models of the subsystems; None where one does not even restart, so that nothing can be predicted."""
    try:
        return linear_network(subsystems, wiring)
    except SimulationError:
        return None


def choose(
    network: Network, linear: Network | None, step: float, name: str | None, tolerance: float
) -> tuple[Coupling, Prediction | None]:
    """The coupling of that name, or the cheapest that the subsystems allow and that meets the
    tolerance; with its prediction.

    Where none meets it, the one with the smallest error. Raises InputError when the subsystems
    cannot do what was asked.
    """
    if name is not None:
        chosen = named_coupling(name)
        missing = chosen.missing_capability(network)
        if missing:
            names = [c.name for c in COUPLINGS.values() if not c.missing_capability(network)]
            raise InputError(f"coupling {name!r} is not possible: {missing} (possible: {', '.join(names)})")
        return chosen, predict(chosen, linear, step) if linear else None
    able = [c for c in COUPLINGS.values() if not c.missing_capability(network)]
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
