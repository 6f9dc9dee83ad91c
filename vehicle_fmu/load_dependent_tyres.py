r"""Tyres whose coefficients are polynomials of the load Z (positive), with relaxation, of both ends of a vehicle.

    side force      (sigma / V) Y' + Y = C_1 alpha + C_2 gamma
    moment about z  M = lambda M_l + (1 - lambda) N,   (sigma / V) M_l' + M_l = N = -C_3 alpha + C_4 gamma
    moment about x  M_x = C_5 gamma

alpha is the slip angle, gamma the camber angle, C_1 to C_5 and sigma are polynomials of Z. The aligning moment turns
the wheel against its slip and into its camber. lambda is 1 where the moment relaxes with the side force, 0 where it
follows slip and camber at once. C_5 is negative: a round tyre touches the ground on the side to which it leans.

Source: Sharp, Vehicle System Dynamics 23 (1994) 425-443; one transient slip for force and moment: Pacejka, Tire and
Vehicle Dynamics (2012), Chapter 7.
"""

from collections.abc import Iterator
from typing import Any

from fmus import Component, local, parameter, state
from fmus.declaration.variables import Variable

ENDS = ("front", "rear")
# Coefficient: symbol, meaning, units of its powers of the load in N.
PER_ANGLE = ("N/rad", "1/rad", "1/N.rad", "1/N2.rad", "1/N3.rad")
MOMENT_PER_ANGLE = ("N.m/rad", "m/rad", "m/N.rad")
POLYNOMIALS = {
    "cornering_stiffness": ("C_{%s1}", "Side force per slip angle", PER_ANGLE),
    "camber_stiffness": ("C_{%s2}", "Side force per camber angle", PER_ANGLE[:3]),
    "aligning_stiffness": ("C_{%s3}", "Aligning moment per slip angle", MOMENT_PER_ANGLE),
    "camber_moment_stiffness": ("C_{%s4}", "Moment about z per camber angle", MOMENT_PER_ANGLE),
    "overturning_stiffness": ("C_{%s5}", "Moment about x per camber angle", MOMENT_PER_ANGLE[:2]),
    "relaxation_length": (r"\sigma_%s", "Relaxation length", ("m", "m/N", "m/N2", "m/N3")),
}


def rows() -> Iterator[tuple[str, Variable]]:
    """The coefficients as parameters `end_name_power`, and their values at the load as locals `end_name`."""
    for end in ENDS:
        for name, (symbol, meaning, units) in POLYNOMIALS.items():
            written = symbol % end[0]
            for power, unit in enumerate(units):
                start = 0.2 if name == "relaxation_length" and power == 0 else 0.0
                yield f"{end}_{name}_{power}", parameter(
                    unit, f"{meaning} of the {end} tyre: coefficient of the load to the power of {power}",
                    symbol=f"{{{written}}}^{{({power})}}", min=-1e6, max=1e6, start=start)  # fmt: skip
            yield f"{end}_{name}", local(units[0], f"{meaning} of the {end} tyre at its load", symbol=written)
        mark = end[0]
        yield f"{end}_load", local("N", f"Load on the {end} tyre", symbol=f"Z_{mark}")
        yield f"{end}_slip_angle", local("rad", f"Slip angle of the {end} tyre", symbol=rf"\alpha_{mark}")
        yield f"{end}_camber_angle", local("rad", f"Camber angle of the {end} tyre", symbol=rf"\gamma_{mark}")
        yield f"{end}_yaw_moment", local("N.m", f"Moment of the {end} tyre about z", symbol=f"M_{{z{mark}}}")
        yield f"{end}_overturning_moment", local("N.m", f"Moment of the {end} tyre about x", symbol=f"M_{{x{mark}}}")


class LoadDependentTyres(Component):
    """Two relaxing tyres with coefficients that depend on their load."""

    vars().update(rows())
    moment_relaxes = parameter(
        "1", "Whether the moment about z relaxes with the side force (1) or not (0)", symbol=r"\lambda", min=0,
        max=1, start=1)  # fmt: skip
    front_side_force = state("N", "Side force of the front tyre", symbol="Y_f", exposed=True, nominal=100)
    rear_side_force = state("N", "Side force of the rear tyre", symbol="Y_r", exposed=True, nominal=100)
    front_relaxed_moment = state("N.m", "Relaxed moment of the front tyre about z", symbol="M_{lf}", nominal=10)
    rear_relaxed_moment = state("N.m", "Relaxed moment of the rear tyre about z", symbol="M_{lr}", nominal=10)


def set_tyre(v: Any, end: str, load: Any, slip: Any, camber: Any) -> dict[str, Any]:
    """Set the locals of the tyre at that end from its load [N], slip and camber angle [rad]; the rates of its
    states."""
    setattr(v, f"{end}_load", load)
    load = v[f"{end}_load"]
    for name, (_, _, units) in POLYNOMIALS.items():
        polynomial = sum(v[f"{end}_{name}_{power}"] * load**power for power in range(len(units)))
        setattr(v, f"{end}_{name}", polynomial)
    setattr(v, f"{end}_slip_angle", slip)
    setattr(v, f"{end}_camber_angle", camber)
    slip, camber = v[f"{end}_slip_angle"], v[f"{end}_camber_angle"]
    force = v[f"{end}_cornering_stiffness"] * slip + v[f"{end}_camber_stiffness"] * camber
    moment = -v[f"{end}_aligning_stiffness"] * slip + v[f"{end}_camber_moment_stiffness"] * camber
    setattr(v, f"{end}_yaw_moment", v.moment_relaxes * v[f"{end}_relaxed_moment"] + (1 - v.moment_relaxes) * moment)
    setattr(v, f"{end}_overturning_moment", v[f"{end}_overturning_stiffness"] * camber)
    pace = v.speed / v[f"{end}_relaxation_length"]
    return {
        f"der({end}_side_force)": (force - v[f"{end}_side_force"]) * pace,
        f"der({end}_relaxed_moment)": (moment - v[f"{end}_relaxed_moment"]) * pace,
    }
