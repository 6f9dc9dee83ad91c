"""A linearised component in the language of python-control."""

import control

from fmus.linear import StateSpace


def as_control(space: StateSpace) -> control.StateSpace:
    """The state space, of one point, as python-control's, with the names of its states, inputs and outputs.

    python-control has no dots in names: `vehicle.speed` becomes `vehicle_speed`.
    """
    states, inputs, outputs = ([name.replace(".", "_") for name in names] for names in (space.states, space.inputs, space.outputs))
    return control.ss(space.A, space.B, space.C, space.D, states=states, inputs=inputs, outputs=outputs)
