"""A mass on a spring and a damper, driven by a force.

    m v' = F - F_s,   x' = v,   F_s = k x + c v
"""

from typing import ClassVar

from fmus.declaration.component import Component
from fmus.declaration.elements import Element
from fmus.declaration.variables import input, local, parameter, state


class MassSpringDamper(Component):
    """Mass on a spring and a damper: force as input, displacement as output."""

    mass = parameter("kg", "Moving mass", symbol="m", min=1e-6, max=1e6,
                     start=1.0)  # type: ignore[assignment]  # rows leave the class
    spring_stiffness = parameter("N/m", "Stiffness of the spring", symbol="k", min=0, max=1e9, start=400.0)
    spring_damping = parameter("N.s/m", "Damping beside the spring", symbol="c", min=0, max=1e9, start=2.0)
    force = input("N", "Force on the mass", symbol="F")
    displacement = state("m", "Displacement of the mass", symbol="x", exposed=True)
    velocity = state("m/s", "Velocity of the mass", symbol="v", exposed=True)
    spring_force = local("N", "Force of spring and damper against the displacement", symbol="F_s")

    elements: ClassVar = {
        "spring": Element("spring_force", "displacement", "velocity", "spring_stiffness", "spring_damping")
    }

    def equations(self, v, m):
        v.spring_force = v.spring_stiffness * v.displacement + v.spring_damping * v.velocity
        return {"der(displacement)": v.velocity, "der(velocity)": (v.force - v.spring_force) / v.mass}
