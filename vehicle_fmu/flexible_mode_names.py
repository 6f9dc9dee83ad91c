"""Names of the modes of a vehicle with further freedoms (twist of head and frame, a rider who rolls), beside `mode_names`.

Modes of these freedoms lie between weave and wobble and veer with both, and weave veers with rear wobble. Therefore
  naming speed   of 60, 55, ... 30 m/s the one at which every pair is most clearly one of further states or none of them
  weave          the pair, not mostly of further states, with the largest part of roll, less what the part of the steer exceeds
                 it. It is the branch of the naming speed with more roll than steer, or roll takes a larger part in it
                 than in the third of the real roots (another pair: than in the second) and than half its mean over all
                 modes; otherwise weave is the two least stable of the three real roots with the largest parts of roll
  capsize        the real root in which roll takes the largest part; of those three the most stable one
  rear wobble    the branch that weave has at the naming speed where weave is another pair; its own branch elsewhere
  wobble         its branch from the naming speed, or the branch of another pair there in which steer takes a larger part
                 than roll and further states a smaller one
  rider-wobble   its branch from the naming speed
A front mode in which further states participate most has no name. Names are called mixed where roll exceeds the steer
in two pairs, and in the second by more than half of that in weave.
"""

import numpy as np

from fmus.linear_analysis.eigenvalue_tracking import Branches
from vehicle_fmu.mode_shapes import Columns, Linearised, ModeShapes, further_states

FRONT = ("wobble", "rider_wobble", "rear_wobble")  # modes that exchange their shapes
OTHER = "other"  # modes of further states: heads, delays, twist, lean
MAJORITY = 0.5  # of the participation, above which a mode belongs to further states
STEP, LOWEST = 5.0, 30.0  # m/s: between speeds at which modes may be named, and the lowest of them
MIXED = 0.5

Names = tuple[tuple[str, Columns], ...]


def distinct_speed(speed: float, linearised: Linearised, branches: Branches) -> tuple[bool, float]:
    """Whether the vehicle itself has further freedoms, and the speed at which the shapes are distinct.

    It is the given one, unless the vehicle has: then of those in steps of 5 m/s below it the one at which every pair is
    most clearly one of further states or none of them.
    """
    if "vehicle" not in further_states(linearised(np.array([speed])).states):
        return False, speed
    speeds = np.arange(speed, LOWEST - STEP / 2, -STEP)
    shapes = ModeShapes.at(speeds, linearised, branches)
    parts = [shapes.foreign_participation(k)[shapes.upper(k)] for k in range(len(speeds))]
    return True, float(speeds[np.argmin([np.minimum(part, 1 - part).max() for part in parts])])


def flexible_characters(shapes: ModeShapes, above: dict[str, Columns]) -> list[tuple[Names, bool]]:
    """For each speed: the branches of the modes, and whether names are mixed."""
    return [_character(shapes, k, above) for k in range(len(shapes.eigenvalues))]


def _character(shapes: ModeShapes, k: int, above: dict[str, Columns]) -> tuple[Names, bool]:
    foreign, own = shapes.foreign_participation(k), shapes.column[k]
    excess = shapes.part(k, "roll") - shapes.part(k, "steer")
    names = {mode: above[mode] for mode in FRONT if mode in above}

    def part(of: np.ndarray, columns: Columns) -> float:
        return float(of[np.isin(own, columns)].max(initial=-1.0))

    if len(names.get("wobble", ())) == 2:
        others = [columns for mode, columns in above.items() if len(columns) == 2 and mode.startswith(OTHER)]
        others = [columns for columns in others if set(columns) <= set(own) and part(excess, columns) < 0]
        names["wobble"] = min([names["wobble"], *others], key=lambda columns: part(foreign, columns))
    names |= _slow_modes(shapes, k, excess, above.get("weave", ()))
    if "rear_wobble" in names and len(above.get("weave", ())) == 2 and set(names["weave"]) != set(above["weave"]):
        names["rear_wobble"] = above["weave"]
    slow = {*names["weave"], *names["capsize"]}
    for mode in FRONT:
        if names.get(mode) and (part(foreign, names[mode]) > MAJORITY or not slow.isdisjoint(names[mode])):
            names[mode] = ()
    ranked = sorted((excess[i] for i in shapes.upper(k)), reverse=True)
    return tuple(sorted(names.items())), len(ranked) > 1 and bool(ranked[1] > MIXED * ranked[0] > 0)


def _slow_modes(shapes: ModeShapes, k: int, excess: np.ndarray, branch: Columns) -> dict[str, Columns]:
    """The branches of weave and capsize, from the branch of weave at the naming speed."""
    foreign, roll, values = shapes.foreign_participation(k), shapes.part(k, "roll"), shapes.eigenvalues[k]
    pairs = [i for i in shapes.upper(k) if foreign[i] <= MAJORITY]
    real = sorted((i for i, value in enumerate(values) if value.imag == 0), key=lambda i: -roll[i])
    weave = max(pairs, key=lambda i: roll[i] + min(excess[i], 0.0), default=None)
    if weave is not None:
        kept = set(shapes.pair(k, weave)) == set(branch)
        least = max([float(roll.mean()) / 2, *roll[real[2:3] if kept else real[1:2]]])
        if (kept and excess[weave] > 0) or len(real) < 3 or roll[weave] > least:
            return {"weave": shapes.pair(k, weave), "capsize": tuple(int(shapes.column[k, i]) for i in real[:1])}
    three = sorted(real[:3], key=lambda i: -values[i].real)
    columns = tuple(int(shapes.column[k, i]) for i in three)
    return {"weave": columns[:2], "capsize": columns[2:]}
