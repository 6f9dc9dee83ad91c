"""Any FMU linearised where it is: x' = A x + B u, y = C x + D u, with the names of its signals.

By directional derivatives where the FMU has them. Where it has none, by central differences,

    (f(z + h) - f(z - h)) / 2 h,

z being given to a second instance as start values, or, where that does not take them, set over a saved state.
The derivatives and states are those that the model description lists; an FMU that lists none, or lets none be set, is
known by its responses: see `fmus.realisation`.
"""

from collections.abc import Callable

import numpy as np

from fmus.errors import InputError, SimulationError
from fmus.fmu_instance import FmuInstance
from fmus.linear import StateSpace
from fmus.realisation import realise

# Exact for what is at most quadratic; at this size rounding costs 1e-13 and a cubic term 1e-6 of itself.
DIFFERENCE = 1e-3


class RefusedError(SimulationError):
    """The FMU does not let its states be set."""


def linearise(unit: FmuInstance) -> StateSpace:
    """The FMU linearised at its present states, inputs and parameters; from its responses, about its start."""
    nx = len(unit.states)
    if not (unit.has_directional_derivatives or nx):
        return realise(unit)
    try:
        jacobian = by_directional_derivatives(unit) if unit.has_directional_derivatives else by_differences(unit)
    except RefusedError:
        return realise(unit)
    return StateSpace(jacobian[:nx, :nx], jacobian[:nx, nx:], jacobian[nx:, :nx], jacobian[nx:, nx:],
                      unit.states, unit.inputs, unit.outputs)  # fmt: skip


def by_directional_derivatives(unit: FmuInstance) -> np.ndarray:
    """d(x', y)/d(x, u), shape (nx + ny, nx + nu), from the FMU's own derivatives."""
    return np.array([unit.along(seed) for seed in np.eye(len(unit.knowns))]).reshape(len(unit.knowns), len(unit.unknowns)).T


def by_differences(unit: FmuInstance) -> np.ndarray:
    """The same from central differences. What the FMU may refuse is tried on a second instance only."""
    point = np.concatenate([unit.state_values(), unit.present_inputs])
    for function in (_over_starts, _over_saved_state):
        twin = unit.twin()
        try:
            return _differences(function(unit, twin), point)
        except (SimulationError, InputError):
            continue
        finally:
            twin.close()
    raise RefusedError(f"the states of {unit.name} cannot be set")


def _differences(at: Callable[[np.ndarray], np.ndarray], point: np.ndarray) -> np.ndarray:
    columns = []
    for k, value in enumerate(point):
        ahead, behind = point.copy(), point.copy()
        ahead[k] += DIFFERENCE * max(1.0, abs(value))
        behind[k] -= DIFFERENCE * max(1.0, abs(value))
        columns.append((at(ahead) - at(behind)) / (ahead[k] - behind[k]))
    return np.array(columns).T


def _over_starts(unit: FmuInstance, twin: FmuInstance) -> Callable[[np.ndarray], np.ndarray]:
    """Derivatives and outputs as a function of states and inputs, of an instance that is initialised anew for every point."""

    def at(point: np.ndarray) -> np.ndarray:
        twin.restart({**unit.values, **dict(zip(unit.states + unit.inputs, point.tolist(), strict=True))}, unit.time)
        outputs = twin.exchange(point[len(unit.states) :]).copy()
        return np.concatenate([twin.state_rates(), outputs])

    return at


def _over_saved_state(unit: FmuInstance, twin: FmuInstance) -> Callable[[np.ndarray], np.ndarray]:
    """The same over a saved state, for FMUs whose states can be set between steps; the FMU is afterwards as before."""
    if not unit.can_go_back:
        raise SimulationError(f"{unit.name} cannot save its state either")
    twin.set_states(unit.state_values())
    saved = unit.save()

    def at(point: np.ndarray) -> np.ndarray:
        unit.set_states(point[: len(unit.states)])
        outputs = unit.exchange(point[len(unit.states) :]).copy()
        found = np.concatenate([unit.state_rates(), outputs])
        unit.restore(saved)
        return found

    return at
