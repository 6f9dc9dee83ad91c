"""Linearisation of any FMU at its present state: x' = A x + B u, y = C x + D u, with the names of its signals.

Directional derivatives are used where the FMU provides them, otherwise central differences,

    (f(z + h) - f(z - h)) / 2 h,

where z is set as start values of a second instance, or, where those are refused, over a saved state. The states and
derivatives are those that the model description lists. An FMU that lists none, or refuses to set them, is identified
from its responses: see `fmus.cosimulation.subsystems.era`.
"""

from collections.abc import Callable

import numpy as np

from fmus.cosimulation.subsystems.era import era
from fmus.cosimulation.subsystems.fmu_instance import FmuInstance
from fmus.linear_analysis.linearisation import StateSpace
from fmus.support.errors import InputError, SimulationError

# Exact for what is at most quadratic; at this size rounding costs 1e-13 and a cubic term 1e-6 of itself.
DIFFERENCE = 1e-3


class RefusedError(SimulationError):
    """The FMU does not let its states be set."""


def linearise(subsystem: FmuInstance) -> StateSpace:
    """The FMU linearised at its present states, inputs and parameters; where only its responses are
    available, about its start."""
    nx = len(subsystem.states)
    if not (subsystem.has_directional_derivatives or nx):
        return era(subsystem)
    try:
        jacobian = (
            by_directional_derivatives(subsystem)
            if subsystem.has_directional_derivatives
            else by_differences(subsystem)
        )
    except RefusedError:
        return era(subsystem)
    return StateSpace(jacobian[:nx, :nx], jacobian[:nx, nx:], jacobian[nx:, :nx], jacobian[nx:, nx:],
                      subsystem.states, subsystem.inputs, subsystem.outputs)  # fmt: skip


def by_directional_derivatives(subsystem: FmuInstance) -> np.ndarray:
    """d(x', y)/d(x, u), shape (nx + ny, nx + nu), from the FMU's own derivatives."""
    return (
        np.array([subsystem.along(seed) for seed in np.eye(len(subsystem.knowns))])
        .reshape(len(subsystem.knowns), len(subsystem.unknowns))
        .T
    )


def by_differences(subsystem: FmuInstance) -> np.ndarray:
    """The same from central differences. What the FMU may refuse is tried on a second instance only."""
    point = np.concatenate([subsystem.state_values(), subsystem.present_inputs])
    for function in (_over_starts, _over_saved_state):
        twin = subsystem.twin()
        try:
            return _differences(function(subsystem, twin), point)
        except (SimulationError, InputError):
            continue
        finally:
            twin.close()
    raise RefusedError(f"the states of {subsystem.name} cannot be set")


def _differences(at: Callable[[np.ndarray], np.ndarray], point: np.ndarray) -> np.ndarray:
    columns = []
    for k, value in enumerate(point):
        ahead, behind = point.copy(), point.copy()
        ahead[k] += DIFFERENCE * max(1.0, abs(value))
        behind[k] -= DIFFERENCE * max(1.0, abs(value))
        columns.append((at(ahead) - at(behind)) / (ahead[k] - behind[k]))
    return np.array(columns).T


def _over_starts(subsystem: FmuInstance, twin: FmuInstance) -> Callable[[np.ndarray], np.ndarray]:
    """Derivatives and outputs as a function of states and inputs, of an instance that is initialised
    anew for every point."""

    def at(point: np.ndarray) -> np.ndarray:
        twin.restart(
            {**subsystem.values, **dict(zip(subsystem.states + subsystem.inputs, point.tolist(), strict=True))},
            subsystem.time,
        )
        outputs = twin.exchange(point[len(subsystem.states) :]).copy()
        return np.concatenate([twin.state_rates(), outputs])

    return at


def _over_saved_state(subsystem: FmuInstance, twin: FmuInstance) -> Callable[[np.ndarray], np.ndarray]:
    """The same over a saved state, for FMUs whose states can be set between steps; the FMU is afterwards as before."""
    if not subsystem.can_restore:
        raise SimulationError(f"{subsystem.name} cannot save its state either")
    twin.set_states(subsystem.state_values())
    saved = subsystem.save()

    def at(point: np.ndarray) -> np.ndarray:
        subsystem.set_states(point[: len(subsystem.states)])
        outputs = subsystem.exchange(point[len(subsystem.states) :]).copy()
        found = np.concatenate([subsystem.state_rates(), outputs])
        subsystem.restore(saved)
        return found

    return at
