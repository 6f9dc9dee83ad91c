"""Components as tables of variables and equations: composed, linearised, exported as FMUs, coupled and checked.

    from fmus import Component, input, output, parameter, state

    class Damper(Component):
        '''Linear rotational damper.'''

        damping = parameter("N.m.s/rad", "Damping coefficient", min=0, start=7.5)
        rate = input("rad/s", "Rate across the damper")
        torque = output("N.m", "Torque against the rate")

        def equations(self, v, m):
            return {"torque": -v.damping * v.rate}

This package contains the ports of riders and vehicles (`fmus.interfaces`), but no rider and no motorcycle. A name is
imported when it is first used.
"""

from typing import TYPE_CHECKING

from fmus.support.public_names import on_use

__all__, _get, _dir = on_use(__name__, {
    "fmus.composition.system": ("System",),
    "fmus.declaration.component": ("Component",),
    "fmus.declaration.elements": ("Element",),
    "fmus.declaration.variables": ("calculated", "input", "local", "output", "parameter", "state"),
    "fmus.effects": ("Effect", "adds_to"),
    "fmus.linear_analysis.linearisation": ("StateSpace", "linearise"),
    "fmus.support.errors": ("InputError",),
})  # fmt: skip

if TYPE_CHECKING:  # the same names for editors and type checkers
    from fmus.composition.system import System as System
    from fmus.declaration.component import Component as Component
    from fmus.declaration.elements import Element as Element
    from fmus.declaration.variables import calculated as calculated
    from fmus.declaration.variables import input as input
    from fmus.declaration.variables import local as local
    from fmus.declaration.variables import output as output
    from fmus.declaration.variables import parameter as parameter
    from fmus.declaration.variables import state as state
    from fmus.effects import Effect as Effect
    from fmus.effects import adds_to as adds_to
    from fmus.linear_analysis.linearisation import StateSpace as StateSpace
    from fmus.linear_analysis.linearisation import linearise as linearise
    from fmus.support.errors import InputError as InputError
else:
    __getattr__, __dir__ = _get, _dir
