"""How a component is declared, rendered, packed as an FMU, coupled and linearised. Knows no motorcycle."""

from fmus.component import Component
from fmus.effects import Effect, adds_to
from fmus.errors import InputError
from fmus.linear import StateSpace, linearise
from fmus.system import System
from fmus.variables import calculated, input, local, output, parameter, state

__all__ = ["Component", "Effect", "InputError", "StateSpace", "System", "adds_to", "calculated", "input",
           "linearise", "local", "output", "parameter", "state"]  # fmt: skip
