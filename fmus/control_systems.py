"""A linearised component in the language of python-control."""

import control

from fmus.linear import StateSpace


def as_control(space: StateSpace) -> control.StateSpace:
    """The state space, of one point, as python-control's, with the names of its states, inputs and outputs."""
    return control.ss(space.A, space.B, space.C, space.D, states=list(space.states), inputs=list(space.inputs),
                      outputs=list(space.outputs))  # fmt: skip
