r"""Motorcycle tyres by the Magic Formula, linear about straight running at their load Z (positive), at both ends.

    side force      Y = C_1 alpha' + C_2 gamma,    (sigma / V) alpha'' + alpha' = alpha    (alpha'' : rate of alpha')
    moment about z  M = -C_3 alpha' + C_4 gamma
    moment about x  M_x = -r_c Z gamma

with the load increment d = (Z - Z_0) / Z_0, the radius r_c of the tyre's cross-section, and

    C_1 = p_Ky1 Z_0 sin(p_Ky2 atan(Z / (p_Ky3 Z_0)))       C_2 = lambda (p_Ky6 + p_Ky7 d) Z
    C_3 = (Z / Z_0) r_c (q_Dz1 + q_Dz2 d) C_1              C_4 = Z r_c (q_Dz8 + q_Dz9 d)
    sigma = C_1 (s_0 + s_1 V + s_2 V^2)

alpha is the slip angle, gamma the camber angle. The slip angle relaxes, camber acts at once. The wheel touches the
ground on the side to which it leans, by r_c gamma beside the lowest point of a disc, which is the moment about x. These
are the derivatives at alpha = gamma = 0 of the full formulas, which the tests hold.

Source: Pacejka, Tire and Vehicle Dynamics (2012), Section 4.3, motorcycle version; relaxation length, lambda and r_c as
in the open model of Passigato et al., Applied Sciences 10 (2020) 6826.
"""

from collections.abc import Iterator
from typing import Any

from fmus import Component, local, output, parameter, state
from fmus.declaration.variables import Variable

ENDS = ("front", "rear")
COEFFICIENTS = {
    "nominal_load": ("Z_{0%s}", "N", "Nominal load", 1e3),
    "section_radius": ("r_{c%s}", "m", "Radius of the cross-section", 0.05),
    "pKy1": ("p_{Ky1%s}", "1/rad", "Maximum cornering stiffness per nominal load", 20.0),
    "pKy2": ("p_{Ky2%s}", "1", "Curvature of the cornering stiffness", 2.0),
    "pKy3": ("p_{Ky3%s}", "1", "Load of maximum cornering stiffness per nominal load", 2.0),
    "pKy6": ("p_{Ky6%s}", "1/rad", "Camber stiffness per load", 0.5),
    "pKy7": ("p_{Ky7%s}", "1/rad", "Change of the camber stiffness with the load", 0.0),
    "camber_scale": (r"\lambda_{%s}", "1", "Factor of the camber stiffness", 1.0),
    "qDz1": ("q_{Dz1%s}", "1", "Pneumatic trail per radius of the cross-section", 0.2),
    "qDz2": ("q_{Dz2%s}", "1", "Change of the pneumatic trail with the load", 0.0),
    "qDz8": ("q_{Dz8%s}", "1/rad", "Residual moment per camber angle, load and radius of the cross-section", 0.0),
    "qDz9": ("q_{Dz9%s}", "1/rad", "Change of the residual moment with the load", 0.0),
    "relaxation_0": ("s_{0%s}", "m.rad/N", "Relaxation length per cornering stiffness", 1e-5),
    "relaxation_1": ("s_{1%s}", "s.rad/N", "Its change with the speed", 0.0),
    "relaxation_2": ("s_{2%s}", "s2.rad/N.m", "Its change with the squared speed", 0.0),
}
VALUES = {
    "cornering_stiffness": ("C_{%s1}", "N/rad", "Side force per slip angle"),
    "camber_stiffness": ("C_{%s2}", "N/rad", "Side force per camber angle"),
    "aligning_stiffness": ("C_{%s3}", "N.m/rad", "Aligning moment per slip angle"),
    "camber_moment_stiffness": ("C_{%s4}", "N.m/rad", "Moment about z per camber angle"),
    "relaxation_length": (r"\sigma_%s", "m", "Relaxation length"),
    "load": ("Z_%s", "N", "Load"),
    "slip_angle": (r"\alpha_%s", "rad", "Slip angle"),
    "camber_angle": (r"\gamma_%s", "rad", "Camber angle"),
    "yaw_moment": ("M_{z%s}", "N.m", "Moment about z"),
    "overturning_moment": ("M_{x%s}", "N.m", "Moment about x"),
}


def rows() -> Iterator[tuple[str, Variable]]:
    """The coefficients of both tyres as parameters, their values at load and speed as locals, states and outputs."""
    for end in ENDS:
        mark = end[0]
        for name, (symbol, unit, meaning, start) in COEFFICIENTS.items():
            least = 1e-9 if name in ("nominal_load", "section_radius") else -1e6
            yield f"{end}_{name}", parameter(unit, f"{meaning}, {end} tyre", symbol=symbol % mark, min=least, max=1e6,
                                             start=start)  # fmt: skip
        for name, (symbol, unit, meaning) in VALUES.items():
            yield f"{end}_{name}", local(unit, f"{meaning} of the {end} tyre", symbol=symbol % mark)
        yield f"{end}_relaxed_slip", state("rad", f"Relaxed slip angle of the {end} tyre", symbol=rf"\alpha'_{mark}",
                                           nominal=1e-2)  # fmt: skip
        yield f"{end}_side_force", output("N", f"Side force of the {end} tyre", symbol=f"Y_{mark}", nominal=100)


class MagicFormulaTyres(Component):
    """Two tyres by the Magic Formula, linear about straight running."""

    vars().update(rows())


def set_tyre(v: Any, m: Any, end: str, load: Any, slip: Any, camber: Any) -> dict[str, Any]:
    """Set the locals of the tyre at that end from its load [N], slip and camber angle [rad]; its rate and its side
    force."""

    def local_value(name: str, value: Any) -> Any:
        setattr(v, f"{end}_{name}", value)
        return v[f"{end}_{name}"]

    p = {name: v[f"{end}_{name}"] for name in COEFFICIENTS}
    load, radius, nominal = local_value("load", load), p["section_radius"], p["nominal_load"]
    increment = (load - nominal) / nominal
    cornering = local_value(
        "cornering_stiffness", p["pKy1"] * nominal * m.sin(p["pKy2"] * m.atan(load / (p["pKy3"] * nominal))))  # fmt: skip
    by_camber = local_value("camber_stiffness", p["camber_scale"] * (p["pKy6"] + p["pKy7"] * increment) * load)
    aligning = local_value(
        "aligning_stiffness", load / nominal * radius * (p["qDz1"] + p["qDz2"] * increment) * cornering)  # fmt: skip
    turning = local_value("camber_moment_stiffness", load * radius * (p["qDz8"] + p["qDz9"] * increment))
    length = local_value(
        "relaxation_length",
        cornering * (p["relaxation_0"] + p["relaxation_1"] * v.speed + p["relaxation_2"] * v.speed**2))  # fmt: skip
    slip, camber = local_value("slip_angle", slip), local_value("camber_angle", camber)
    relaxed = v[f"{end}_relaxed_slip"]
    local_value("yaw_moment", -aligning * relaxed + turning * camber)
    local_value("overturning_moment", -radius * load * camber)
    return {
        f"der({end}_relaxed_slip)": (slip - relaxed) * v.speed / length,
        f"{end}_side_force": cornering * relaxed + by_camber * camber,
    }
