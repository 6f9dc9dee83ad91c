"""The bodies of the touring motorcycle as a tree in space, and its tyres, from the values of the component.

Bodies, joints and axes are those of `vehicle_fmu.components.touring_motorcycle`; vertical motion and pitch are added.
Pitch inertias and the further coefficients of the Magic Formula are in the section `supplement` of the value file. A
locked freedom has no link.
"""

from types import SimpleNamespace
from typing import Any

import numpy as np

from fmus.declaration.component import Component
from fmus.expressions.functions import NUMERIC
from fmus.support.errors import InputError
from vehicle_fmu import magic_formula_tyres
from vehicle_fmu.components.touring_motorcycle import BODIES, FLEXIBLE, TouringMotorcycle, bodies
from vehicle_fmu.large_motion import magic_formula
from vehicle_fmu.large_motion.magic_formula import Tyre
from vehicle_fmu.large_motion.tree import Link, RigidBody, Tree
from vehicle_fmu.out_of_plane import Freedom

ENDS = magic_formula_tyres.ENDS
SUSPENDED = tuple(FLEXIBLE)
RIGHT, NOWHERE = (0.0, 1.0, 0.0), np.zeros(3)
ORDER = ("frame", "lower_body", "upper_body", "upper_fork", "lower_fork", "swingarm", "front_wheel", "rear_wheel")
PITCH_INERTIAS = tuple(f"{body}_yy" for body in BODIES if not body.endswith("wheel"))
SUPPLEMENT = (*PITCH_INERTIAS, *(f"{end}_{name}" for end in ENDS for name in magic_formula.COEFFICIENTS))


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


def touring_tree(motorcycle: Component) -> Tree:
    """The tree of a touring motorcycle, its wheels' spin last."""
    v = _Values({**motorcycle.values, "speed": 0.0})
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
        for freedom in body.path[3:]:
            if not freedom.free:
                continue
            link = _link(freedom, parent)
            if link.name not in known:
                links.append(link)
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


def _link(freedom: Freedom, parent: str) -> Link:
    name = freedom.rate.removesuffix("_rate")
    axis = RIGHT if freedom.axis is None else (float(freedom.axis[0]), 0.0, float(freedom.axis[1]))
    return Link(name, parent, _in_space(freedom.point), np.array(axis), freedom.axis is None)


def _in_space(point: tuple[Any, Any]) -> np.ndarray:
    return np.array([point[0], 0.0, point[1]], float)


class _Values(SimpleNamespace):
    """Values by attribute and by key."""

    def __init__(self, values: dict[str, float]):
        super().__init__(**values)

    def __getitem__(self, name: str) -> float:
        return self.__dict__[name]
