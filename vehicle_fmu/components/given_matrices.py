r"""A bicycle or motorcycle given by the matrices of its linear model, in powers of the speed.

    x' = (A0 + V A1 + V^2 A2) x + B u,    x = (roll, steer, roll rate, steer rate),  u = (roll torque, steer torque)

The lower half of B is the inverse of a mass matrix, B_l = M^-1. Then M q'' = M A_l x + u, so that effects can add to
torques and inertias. A file has the matrices row by row:

    A0 = [[0, 0, 1, 0], [0, 0, 0, 1], [13.6, -0.44, 0, 0], [2.4, 23.1, 0, 0]]
    A1 = [...]                 # and A2, where the matrices depend on the speed
    B = [[0, 0], [0, 0], [0.095, -0.45], [-0.45, 9.3]]
    description = "...", source = "..."
"""

import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from fmus import Component, InputError, input, local, parameter
from fmus.declaration.elements import Element
from fmus.declaration.variables import Variable, state
from fmus.interfaces.handlebar import port_state
from fmus.interfaces.roll import roll_input
from fmus.support.errors import unknown

COORDINATES = ("roll", "steer")
STATES = ("roll_angle", "steer_angle", "roll_rate", "steer_rate")
UNITS = {"angle": ("1/s2", "1/m.s", "1/m2"), "rate": ("1/s", "1/m", "s/m2")}
KEYS = ("A0", "A1", "A2", "B", "description", "source")


def entries() -> Iterator[tuple[str, Variable]]:
    """The lower rows of A0, A1, A2 and B as parameters, in this order and row by row."""
    for power in range(3):
        for i, row in enumerate(COORDINATES):
            for j, column in enumerate(STATES):
                unit = UNITS[column.partition("_")[2]][power]
                meaning = f"Acceleration of the {row} per {column.replace('_', ' ')} and speed to the power of {power}"
                yield (
                    f"{row}_by_{column}_{power}",
                    parameter(unit, meaning, symbol=f"A_{{{power},{i + 3}{j + 1}}}", min=-1e6, max=1e6),
                )
    for i, row in enumerate(COORDINATES):
        for j, column in enumerate(COORDINATES):
            meaning = f"Acceleration of the {row} per {column} torque"
            yield (
                f"{row}_by_{column}_torque",
                parameter("1/kg.m2", meaning, symbol=f"B_{{{i + 3}{j + 1}}}", min=-1e6, max=1e6, start=float(i == j)),
            )


class GivenMatrices(Component):
    """Bicycle or motorcycle given by the matrices of its linear model, with roll and steer as coordinates."""

    vars().update(entries())
    speed = input("m/s", "Forward speed", symbol="V", min=0, max=200, start=5)
    steer_torque = input("N.m", "Disturbance: torque between rear and front frame, on the front frame", symbol="T_d")
    roll_torque = roll_input("roll_torque")
    roll_rate = state("rad/s", "Roll rate", symbol="p", exposed=True)
    steer_rate = port_state("steer_rate")
    roll_angle = state("rad", "Roll angle, lean to the right positive", symbol=r"\phi", exposed=True)
    steer_angle = port_state("steer_angle")
    head_torque = local("N.m", "Torque of the steering head against the steer rate, such as of a damper", symbol="T_s")

    elements: ClassVar = {"steering_head": Element("head_torque", "steer_angle", "steer_rate")}

    def mass(self, v, m):
        B = [[v[f"{row}_by_{column}_torque"] for column in COORDINATES] for row in COORDINATES]
        determinant = B[0][0] * B[1][1] - B[0][1] * B[1][0]
        return {("roll_rate", "roll_rate"): B[1][1] / determinant, ("roll_rate", "steer_rate"): -B[0][1] / determinant,
                ("steer_rate", "roll_rate"): -B[1][0] / determinant,
                ("steer_rate", "steer_rate"): B[0][0] / determinant}  # fmt: skip

    def equations(self, v, m):
        M, free = self.mass(v, m), {}
        for row in COORDINATES:
            free[row] = sum(
                v[f"{row}_by_{column}_{power}"] * v.speed**power * v[column] for power in range(3) for column in STATES
            )
        v.head_torque = 0.0
        return {
            "der(roll_rate)": M["roll_rate", "roll_rate"] * free["roll"]
                              + M["roll_rate", "steer_rate"] * free["steer"] + v.roll_torque,
            "der(steer_rate)": M["steer_rate", "roll_rate"] * free["roll"]
                               + M["steer_rate", "steer_rate"] * free["steer"] + v.steer_torque - v.head_torque,
            "der(roll_angle)": v.roll_rate,
            "der(steer_angle)": v.steer_rate,
        }  # fmt: skip


def holds_matrices(path: Path) -> bool:
    """Whether a .toml file gives matrices instead of parameters. Raises InputError for a file that cannot be read."""
    return not {"A0", "A1", "A2", "B"}.isdisjoint(_read(path))


def from_matrices(path: Path) -> GivenMatrices:
    """The vehicle of a file of matrices. Raises InputError with the matrix, what is wrong and what was expected."""
    contents = _read(path)
    for key in contents:
        if key not in KEYS:
            raise InputError(f"{path.name}: {unknown('key', key, KEYS)}")
    for key in ("A0", "B"):
        if key not in contents:
            raise InputError(
                f"{path.name}: no {key}; expected A0 and B, and A1 and A2 where the matrices depend on the speed"
            )
    A = [_matrix(path, key, contents[key], 4) if key in contents else np.zeros((4, 4)) for key in ("A0", "A1", "A2")]
    B = _matrix(path, "B", contents["B"], 2)
    if not (np.allclose(A[0][:2], np.eye(4)[2:]) and not A[1][:2].any() and not A[2][:2].any() and not B[:2].any()):
        raise InputError(
            f"{path.name}: the upper rows do not state that the rates of the angles are states; "
            "expected x = (roll, steer, roll rate, steer rate)"
        )
    if abs(np.linalg.det(B[2:])) <= 1e-12 * np.abs(B[2:]).max() ** 2:
        raise InputError(
            f"{path.name}: the lower half of B is singular; "
            "expected the inverse of a mass matrix, for roll torque and steer torque"
        )
    numbers = np.concatenate([*(a[2:].ravel() for a in A), B[2:].ravel()])
    values = {n: float(x) for (n, _), x in zip(entries(), numbers, strict=True)}
    return GivenMatrices(path.stem, str(contents.get("source", "")), (), **values)


def _read(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text("utf-8"))
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path} is not a valid TOML file: {error}") from None


def _matrix(path: Path, key: str, given: Any, columns: int) -> np.ndarray:
    try:
        matrix = np.array(given, float)
    except (TypeError, ValueError):
        matrix = np.zeros(0)
    if matrix.shape != (4, columns) or not np.isfinite(matrix).all():
        raise InputError(f"{path.name}: {key} is not a matrix of 4 rows of {columns} finite numbers")
    return matrix
