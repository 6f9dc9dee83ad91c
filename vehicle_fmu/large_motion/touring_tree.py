"""The bodies of the touring motorcycle as a tree in space, and its tyres, from the values of the component.

Bodies, joints and axes are those of `vehicle_fmu.components.touring_motorcycle`; vertical motion, pitch and the
freedoms of `vehicle_fmu.large_motion.suspension` are added: after lateral bending the fork bends lengthwise at the same
joint, after torsion the lower fork slides along the fork; before torsion the swingarm turns about its pivot. Their
values, the pitch inertias, and what the tyres need beside the component's values are in the section `supplement` of the
value file. A locked freedom has no link.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from fmus.declaration.component import Component
from fmus.expressions.functions import NUMERIC
from fmus.support.errors import InputError
from vehicle_fmu import magic_formula_tyres
from vehicle_fmu.components.touring_motorcycle import BODIES, FLEXIBLE, TouringMotorcycle, bodies
from vehicle_fmu.large_motion import magic_formula, suspension
from vehicle_fmu.large_motion.magic_formula import Tyre
from vehicle_fmu.large_motion.suspension import FRONT, LENGTHWISE, REAR
from vehicle_fmu.large_motion.tree import Link, RigidBody, Tree
from vehicle_fmu.out_of_plane import Body, Freedom

ENDS = magic_formula_tyres.ENDS
SPRUNG = (*FLEXIBLE, *suspension.SUSPENSIONS)
TYRE_FREEDOMS = tuple(f"{end}_{name}" for name in ("tyre_deflection", "longitudinal_slip") for end in ENDS)
PLANE = (*suspension.SUSPENSIONS, *TYRE_FREEDOMS)
RIGHT, NOWHERE = (0.0, 1.0, 0.0), np.zeros(3)
ORDER = ("frame", "lower_body", "upper_body", "upper_fork", "lower_fork", "swingarm", "front_wheel", "rear_wheel")
PITCH_INERTIAS = tuple(f"{body}_yy" for body in BODIES if not body.endswith("wheel"))
SUPPLEMENT = (
    *PITCH_INERTIAS,
    *suspension.SUPPLEMENT,
    *TYRE_FREEDOMS,
    *(f"{end}_tyre_deflection_{what}" for end in ENDS for what in suspension.COEFFICIENTS),
    "front_brake_share",
    *(f"{end}_{name}" for end in ENDS for name in magic_formula.COEFFICIENTS),
)


def check_large_motion(motorcycle: Component) -> None:
    """Raises InputError for a vehicle that has no equations in large motion, or whose value file lacks values for
    them.
    """
    if not isinstance(motorcycle, TouringMotorcycle):
        raise InputError(
            f"{motorcycle.name} is a {motorcycle.title}, which has no equations for corners (valid: tum_2020, "
            "or a value file of a TouringMotorcycle)"
        )
    missing = [name for name in SUPPLEMENT if name not in motorcycle.supplement]
    if missing:
        raise InputError(
            f"{motorcycle.name}: corners need {len(missing)} more values, such as {missing[0]}; give them in "
            "[supplement] of its value file, as in tum_2020.toml"
        )
    for name, value in motorcycle.supplement.items():
        if name in PLANE and value not in (0.0, 1.0):
            raise InputError(f"{motorcycle.name}: {name} = {value:g} must be 1 (free) or 0 (locked)")
        if (name.endswith("_stiffness") and value <= 0) or (name.endswith("_damping") and value < 0):
            least = "above 0" if name.endswith("_stiffness") else "0 or above"
            raise InputError(f"{motorcycle.name}: {name} = {value:g} must be {least}")
        if name == "front_brake_share" and not 0 <= value <= 1:
            raise InputError(f"{motorcycle.name}: {name} = {value:g} must be from 0 to 1")


def touring_tree(motorcycle: Component) -> Tree:
    """The tree of a touring motorcycle, its wheels' spin last."""
    v = named_values(motorcycle.values)
    found, _ = bodies(v, NUMERIC)
    links = [
        Link("along", "", NOWHERE, np.array([1.0, 0, 0]), True),
        Link("lateral", "along", NOWHERE, np.array(RIGHT), True),
        Link("vertical", "lateral", NOWHERE, np.array([0, 0, 1.0]), True),
        Link("yaw", "vertical", NOWHERE, np.array([0, 0, 1.0])),
        Link("roll", "yaw", NOWHERE, np.array([1.0, 0, 0])),
        Link("pitch", "roll", NOWHERE, np.array(RIGHT)),
    ]
    known = {link.name for link in links}
    parents: list[str] = []
    for body in found:
        parent = "pitch"
        for link in _chain(body, motorcycle.supplement):
            if link.name not in known:
                links.append(replace(link, parent=parent))
                known.add(link.name)
            parent = link.name
        parents.append(parent)
    masses = []
    for name, body, parent in zip(ORDER, found, parents, strict=True):
        end = name.removesuffix("_wheel")
        centre = _in_space(body.centre)
        pitch = v[f"{end}_spin_inertia"] if end in ENDS else motorcycle.supplement[f"{name}_yy"]
        carrier = f"{end}_spin" if end in ENDS else parent
        if end in ENDS:
            links.append(Link(carrier, parent, centre, -np.array(RIGHT)))
        tensor = np.array(
            [[body.roll_inertia, 0, -body.product], [0, pitch, 0], [-body.product, 0, body.yaw_inertia]], float
        )
        masses.append(RigidBody(carrier, float(body.mass), centre, tensor))
    return Tree(links, masses)


def tyre(motorcycle: Component, end: str) -> Tyre:
    """The tyre at an end."""
    values = {name: motorcycle.values[f"{end}_{name}"] for name in magic_formula_tyres.COEFFICIENTS}
    return Tyre(values | {name: motorcycle.supplement[f"{end}_{name}"] for name in magic_formula.COEFFICIENTS})


def _chain(body: Body, supplement: dict[str, float]) -> Iterator[Link]:
    """The free links of a body's path from the frame on, without their parents."""
    for freedom in body.path[3:]:
        name, at, axis = freedom.rate.removesuffix("_rate"), _in_space(freedom.point), _axis(freedom)
        if name == "fork_torsion" and supplement[LENGTHWISE]:
            yield Link(LENGTHWISE, "", at, np.array(RIGHT))
        if name == "swingarm_torsion" and supplement[REAR]:
            yield Link(REAR, "", at, -np.array(RIGHT))
        if freedom.free:
            yield Link(name, "", at, axis, freedom.axis is None)
        if name == "fork_torsion" and supplement[FRONT]:
            yield Link(FRONT, "", at, -axis, True)


def _axis(freedom: Freedom) -> np.ndarray:
    return np.array(RIGHT if freedom.axis is None else (freedom.axis[0], 0.0, freedom.axis[1]), float)


def _in_space(point: tuple[Any, Any]) -> np.ndarray:
    return np.array([point[0], 0.0, point[1]], float)


class _Values(SimpleNamespace):
    """Values by attribute and by key."""

    def __getitem__(self, name: str) -> Any:
        return self.__dict__[name]


def named_values(values: Mapping[str, Any]) -> Any:
    """Values for `vehicle_fmu.components.touring_motorcycle.bodies`, whose wheels do not spin; freedoms are free unless
    given.
    """
    return _Values(**{**dict.fromkeys(FLEXIBLE, 1.0), **values, "speed": 0.0})
