r"""Two tyres whose side force follows slip and camber with a relaxation length:

    (sigma / V) Y' + Y = Y_s(alpha, gamma)

with the slip angle alpha, the camber angle gamma and the side force Y_s of steady motion, which a vehicle states.

Source: Sharp, J. Mech. Eng. Sci. 13(5) (1971) 316-329.
"""

from typing import Any

from fmus import Component, local, parameter, state


class RelaxingTyres(Component):
    """Base class of vehicles with a relaxing tyre at each end."""

    front_relaxation_length = parameter(
        "m", "Relaxation length of the front tyre", symbol=r"\sigma_f", min=1e-6, max=10, start=0.24
    )
    rear_relaxation_length = parameter(
        "m", "Relaxation length of the rear tyre", symbol=r"\sigma_r", min=1e-6, max=10, start=0.24
    )

    front_side_force = state("N", "Side force of the front tyre", symbol="Y_f", exposed=True)
    rear_side_force = state("N", "Side force of the rear tyre", symbol="Y_r", exposed=True)
    front_slip_angle = local("rad", "Slip angle of the front tyre", symbol=r"\alpha_f")
    rear_slip_angle = local("rad", "Slip angle of the rear tyre", symbol=r"\alpha_r")
    front_camber_angle = local("rad", "Camber angle of the front tyre", symbol=r"\gamma_f")
    rear_camber_angle = local("rad", "Camber angle of the rear tyre", symbol=r"\gamma_r")


def relaxed(v: Any, end: str, steady: Any) -> Any:
    """The rate of the side force of the tyre at that end, from its side force in steady motion [N]."""
    return (steady - v[f"{end}_side_force"]) * v.speed / v[f"{end}_relaxation_length"]
