"""The errors that a coupling makes in the modes, predicted before the run.

The coupling's own algorithm is run for one step on the linearised subsystems, started from every column of the
identity: that gives the matrix P of the discrete-time system (states of the subsystems and memory of the coupling).
Its eigenvalues mu are those of the coupled simulation,

    lambda = log(mu) / H

and are compared with the eigenvalues of the same subsystems coupled without error.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fmus.cosimulation.coupling import COUPLINGS, Coupling, coupling
from fmus.cosimulation.network import Network
from fmus.cosimulation.subsystems.subsystem import LinearSubsystem, Subsystem
from fmus.support.errors import InputError, SimulationError

VANISHED = 1e-14  # a discrete eigenvalue this small is forgotten within one step
GROWS = 1e-6  # 1/s
LONGEST = 1e-2  # s: an automatic step still shows motions of 15 Hz
SHORTEST = 1e-6  # s
GROWTH = 10**0.1  # ratio of the steps that are tried


@dataclass(frozen=True)
class Prediction:
    """The exact eigenvalues (n,), those of the coupled simulation that belong to them (n,), and
    all of the latter [1/s].

    stable: nothing grows but what belongs to an eigenvalue of the exact system that grows.
    """

    exact: np.ndarray
    coupled: np.ndarray
    everything: np.ndarray
    stable: bool

    @property
    def oscillatory(self) -> np.ndarray:
        """Which of the exact eigenvalues stand for an oscillation, one of each pair."""
        return self.exact.imag > 1e-9 * np.abs(self.exact)

    @property
    def frequency_error(self) -> np.ndarray:
        """Of the damped frequency, as a fraction; NaN for real eigenvalues."""
        return _ratio(self.coupled.imag, self.exact.imag, self.oscillatory)

    @property
    def damping_error(self) -> np.ndarray:
        """Of the damping ratio, as a fraction; NaN for real eigenvalues."""
        return _ratio(_damping(self.coupled), _damping(self.exact), self.oscillatory)

    @property
    def real_error(self) -> np.ndarray:
        """Of the real part [1/s]."""
        return self.coupled.real - self.exact.real

    @property
    def worst(self) -> float:
        """The largest error of a mode: of the frequency, or a tenth of that of the damping; infinite when not stable.

        A damping ratio below 0.1 % counts as 0.1 %, because a ratio means nothing where damping is nearly zero. A real
        eigenvalue counts with its error relative to itself, a slow one relative to 1/s.
        """
        if not self.stable or np.isnan(self.coupled).any():
            return np.inf
        exact, coupled, swings = self.exact, self.coupled, self.oscillatory
        damping = np.abs(_damping(coupled[swings]) - _damping(exact[swings])) / np.maximum(
            np.abs(_damping(exact[swings])), 1e-3
        )
        real = np.abs(coupled - exact)[~swings] / np.maximum(np.abs(exact[~swings]), 1.0)
        return float(
            max(
                np.abs(self.frequency_error[swings]).max(initial=0.0),
                damping.max(initial=0.0) / 10,
                real.max(initial=0.0) / 10,
            )
        )


def _damping(eigenvalue: np.ndarray) -> np.ndarray:
    return -eigenvalue.real / np.maximum(np.abs(eigenvalue), 1e-300)


def _ratio(found: np.ndarray, exact: np.ndarray, where: np.ndarray) -> np.ndarray:
    return np.divide(found - exact, exact, out=np.full(len(exact), np.nan), where=where)


def linear_network(subsystems: Mapping[str, Subsystem], wiring: Mapping[str, Sequence[str]]) -> Network:
    """The subsystems' linear models, where the subsystems are, with the same abilities and the same wiring.

    Units that are alike and wired alike are one, whose outputs are those of all: what they do against each other meets
    no other subsystem, so that no coupling has an error there. A subsystem without a real input, which only drives
    others, is in no loop and is left out. Raises InputError where no subsystem has a real input.
    """
    driven = {name: subsystem for name, subsystem in subsystems.items() if subsystem.inputs}
    if not driven:
        (name, subsystem), *_ = subsystems.items()
        model = getattr(getattr(subsystem, "description", None), "modelName", "")
        raise InputError(f"the FMU {name}{f' (model {model})' * bool(model)} has no real input, so that nothing can be "
                         "coupled to it; expected at least one input of type Real (FMI 2.0) or Float64 (FMI 3.0): "
                         "leave it out of the co-simulation, or run it by itself with motofmi simulate")  # fmt: skip
    models = {
        n: LinearSubsystem(u.linearised(), u.input_order, u.output_order, u.can_restore) for n, u in driven.items()
    }
    drives: dict[str, list[str]] = {}
    for target, sources in wiring.items():
        for source in sources:
            drives.setdefault(source, []).append(target)
    alike: dict[tuple, list[str]] = {}
    for name, m in models.items():
        driven_by = tuple(tuple(wiring.get(f"{name}.{i}", ())) for i in m.inputs)
        driving = tuple(tuple(drives.get(f"{name}.{o}", ())) for o in m.outputs)
        matrices = tuple(getattr(m.space, matrix).tobytes() for matrix in "ABCD")
        alike.setdefault(
            (m.inputs, m.outputs, m.input_order, m.output_order, m.can_restore, driven_by, driving, matrices), []
        ).append(name)
    merged = {names[0]: models[names[0]].multiplied(len(names)) for names in alike.values()}
    kept = {
        target: [s for s in sources if s.partition(".")[0] in merged]
        for target, sources in wiring.items()
        if target.partition(".")[0] in merged
    }
    return Network(merged, kept)


def transition(chosen: Coupling, network: Network, step: float) -> np.ndarray:
    """The matrix of one step of a coupling on linear subsystems: states of all subsystems, then the coupling's memory.

    Raises SimulationError when an iteration does not converge at this step.
    """
    run = chosen.prepare(network, step)
    subsystems = [subsystem for subsystem, _, _ in network.parts if isinstance(subsystem, LinearSubsystem)]
    sizes = [len(subsystem.space.states) for subsystem in subsystems]
    total = sum(sizes) + run.memory.size
    columns = np.split(np.eye(total), np.cumsum(sizes))
    for subsystem, state in zip(subsystems, columns[:-1], strict=True):
        subsystem.state = state
    run.memory = columns[-1].reshape(*run.memory.shape, total)
    run.advance(network.read(np.zeros((len(network.outputs), total))))
    return np.vstack([*(subsystem.state for subsystem in subsystems), run.memory.reshape(total - sum(sizes), total)])


def predict(chosen: Coupling, network: Network, step: float) -> Prediction:
    """The modes of a coupling at a step [s] on a network of linear subsystems, beside the exact ones."""
    from scipy.optimize import linear_sum_assignment  # noqa: PLC0415 - imported on use: it takes 0.5 s

    exact = np.linalg.eigvals(network.linearised().A).astype(complex)
    exact = exact[exact.imag > -1e-9 * np.abs(exact)]
    exact = exact[np.argsort(np.abs(exact))]
    try:
        multipliers = np.linalg.eigvals(transition(chosen, network, step)).astype(complex)
    except SimulationError:
        lost = np.full(len(exact), np.nan + 0j)
        return Prediction(exact, lost, lost, False)
    everything = np.log(multipliers[np.abs(multipliers) > VANISHED]) / step
    upper = everything[everything.imag > -1e-9 * np.abs(everything)]
    rows, columns = linear_sum_assignment(np.abs(exact[:, None] - upper[None, :]))
    coupled = np.full(len(exact), np.nan + 0j)
    coupled[rows] = upper[columns]
    may_grow = np.zeros(len(upper), bool)
    may_grow[columns] = exact[rows].real > -GROWS
    return Prediction(exact, coupled, everything, not np.any((upper.real > GROWS) & ~may_grow))


def largest_stable_step(chosen: Coupling, network: Network, smallest: float = 1e-5, largest: float = 1.0) -> float:
    """The largest step [s], to 1 %, up to which the coupling is stable at all steps tried; 0 when at none."""
    steps = np.geomspace(smallest, largest, 61)
    stable = 0.0
    for step in steps:
        if not predict(chosen, network, step).stable:
            break
        stable = step
    else:
        return float(largest)
    unstable = float(step)
    while stable > 0 and unstable / stable > 1.01:
        middle = float(np.sqrt(stable * unstable))
        stable, unstable = (middle, unstable) if predict(chosen, network, middle).stable else (stable, middle)
    return float(stable)


class ToleranceWarning(UserWarning):
    """No coupling is within the tolerance at this step."""


@dataclass(frozen=True)
class Assessment:
    """Whether a coupling meets the tolerance at a step; where not, one sentence with what meets it."""

    meets_tolerance: bool
    advice: str | None = None


def assess(chosen: Coupling, predicted: Prediction, network: Network, step: float, tolerance: float) -> Assessment:
    """A coupling's prediction at a step [s] compared with a tolerance (as `Prediction.worst`) on a
    network of linear subsystems.

    Where the tolerance is exceeded, the advice names the cheapest coupling that meets it at this step, and otherwise
    the largest smaller step at which one does, to two digits.
    """
    if predicted.worst <= tolerance:
        return Assessment(True)
    missed = (f"the coupling {chosen.name} is unstable at a step of {step:g} s" if not np.isfinite(predicted.worst) else
              f"the coupling {chosen.name} exceeds the tolerance of {tolerance:g} at a step of {step:g} s (largest "
              f"error of a mode {predicted.worst:.2g})")  # fmt: skip
    able = [c for c in COUPLINGS.values() if not c.missing_capability(network)]
    for candidate in able:
        if predict(candidate, network, step).worst <= tolerance:
            return Assessment(False, f"{missed}; {candidate.name} meets it at this step")
    while (step := _two_digits(step / GROWTH)) > SHORTEST:
        for candidate in able:
            if predict(candidate, network, step).worst <= tolerance:
                return Assessment(
                    False,
                    f"{missed}; no coupling meets it at this step; take a step of at most {step:g} s, with "
                    f"{candidate.name}",
                )
    return Assessment(
        False, f"{missed}; no coupling meets it at any step above {SHORTEST:g} s; take a larger tolerance"
    )


def _two_digits(value: float) -> float:
    """A positive number rounded down to two digits."""
    unit = 10.0 ** (np.floor(np.log10(value)) - 1)
    return float(f"{np.floor(value / unit) * unit:.2g}")


def longest_step(network: Network, name: str | None, tolerance: float) -> float:
    """The longest step [s], at most 10 ms, at which the coupling of that name, or any, is within the tolerance.

    Raises InputError when there is none above a microsecond.
    """
    candidates = [coupling(name)] if name else list(COUPLINGS.values())
    candidates = [c for c in candidates if not c.missing_capability(network)]
    for step in LONGEST / 10 ** (np.arange(41) / 10):
        if any(predict(c, network, float(step)).worst <= tolerance for c in candidates):
            return float(step)
    names = ", ".join(c.name for c in candidates)
    raise InputError(
        f"no step above {SHORTEST:g} s is within a tolerance of {tolerance:g} with {names}; give --step or another "
        "coupling"
    )
