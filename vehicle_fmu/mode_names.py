"""Names of modes: weave, wobble and the others by mode shape, kept along the branches of the eigenvalues.

At 60 m/s the mode shapes are distinct. Names are given there and kept along each branch:
  other          modes in which further states of a device or an effect (heads, lean, delays) participate most
  weave          the oscillation in which roll exceeds the steer most, by their participation factors
  wobble         of the two oscillations in which steer and torso take the largest part the one in which the torso
                 moves more against the bar; without a torso the one in which the steer has the largest part
  rider-wobble   the other one of the two
  capsize        the slowest real root
  rear wobble    the pair that unnamed real roots form on the way down (near 18 m/s for Sharp's motorcycle)
A wobble that is overdamped there is the two real roots in which the steer takes the largest part.

Below the speed at which another pair forms, the branches of wobble, rider-wobble and rear wobble veer and exchange
their mode shapes. There the names follow the mode shapes:
  rear wobble    the largest |Y_r / Y_f|, rear over front tyre side force, if above one
  wobble         of the other two the one in which the torso moves more against the bar:
                 the smaller Re(theta delta*) / (|theta|^2 + |delta|^2)
  rider-wobble   the last; where only one is left beside rear wobble, wobble is overdamped
A pair in which further states of a device have more than a quarter of the participation has none of these names. Where
weave veers with such a mode, weave is the one in which those states have the smaller part.
Names are called mixed where the second largest |Y_r / Y_f| is more than half of the largest.

Further states are those of a device or an effect besides a torso, and those of freedoms of a vehicle besides lateral
motion, yaw, roll and steer (twist of a frame, lean). `flexible_mode_names` names the modes of vehicles with such
freedoms.

Modes and their usual bands: Sharp 1971; Cossalter et al., Meccanica 46 (2011), Sect. 5.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fmus.linear_analysis.eigenvalue_tracking import Branches
from vehicle_fmu.flexible_mode_names import FRONT, MAJORITY, OTHER, distinct_speed, flexible_characters
from vehicle_fmu.mode_shapes import Columns, Linearised, ModeShapes

MODES = ("weave", "wobble", "capsize", "rear_wobble", "rider_wobble")
COARSE, FINE = 1.0, 0.1  # m/s: steps at which exchanges are searched for, and located
MIXED = 0.5
SHARE = 0.25  # of the participation, above which a mode belongs to a device below the naming speed


@dataclass(frozen=True)
class Names:
    """The branches of each mode: `above` at the naming speed `speed` [m/s]; from each speed in `below` downward the columns
    given there.
    """

    speed: float
    above: dict[str, Columns]
    below: list[tuple[float, dict[str, Columns]]]
    mixed: list[list[float]]

    @property
    def present(self) -> list[str]:
        """The modes that exist at some speed."""
        return [mode for mode in MODES if any(mode in named for named in (self.above, *(named for _, named in self.below)))]

    def masks(self, speeds: np.ndarray, width: int) -> np.ndarray:
        """Which of the branches each of MODES has at speeds (n,): (modes, n, width)."""
        found = np.repeat(masks([self.above], width), len(speeds), axis=0).swapaxes(0, 1)
        for speed, named in self.below:
            given = masks([named], width)[0]
            for k in (k for k, mode in enumerate(MODES) if mode in named):
                found[k, speeds <= speed + 1e-9] = given[k]
        return found


def masks(names: Sequence[dict[str, Columns]], width: int) -> np.ndarray:
    """Which of the branches each of MODES has (n, modes, width)."""
    found = np.zeros((len(names), len(MODES), width), bool)
    for member, named in enumerate(names):
        for k, mode in enumerate(MODES):
            found[member, k, list(named.get(mode, ()))] = True
    return found


def name_modes(linearised: Linearised, branches: Branches, reference_speed: float) -> Names:
    """The names of the branches at all speeds. The grid of the branches has every multiple of 0.1 m/s."""
    flexible, reference_speed = distinct_speed(reference_speed, linearised, branches)
    above = named_at(ModeShapes.at(np.array([reference_speed]), linearised, branches), 0)
    formation, another = _formation_of_another_pair(linearised, branches, above, reference_speed)
    if not another and not flexible:
        return Names(reference_speed, above, [], [])
    if another and not {c for mode, columns in above.items() if not mode.startswith(OTHER) for c in columns} & set(another):
        above["rear_wobble"] = another

    def characters(speeds: np.ndarray) -> list:
        if flexible:
            return flexible_characters(ModeShapes.at(speeds, linearised, branches), above)
        return _characters(speeds, linearised, branches, above)

    low, top = branches.parameter[0], branches.parameter[-1] if flexible else formation
    return Names(reference_speed, above, *_along(FINE * np.arange(np.floor(top / FINE + 1e-9), np.ceil(low / FINE - 1e-9) - 1, -1), characters))


def _along(tenths: np.ndarray, characters: Callable) -> tuple[list[tuple[float, dict[str, Columns]]], list[list[float]]]:
    """The changes of names along descending speeds, and the intervals of mixed names."""
    stride = round(COARSE / FINE)
    coarse = np.unique(np.append(np.arange(0, len(tenths), stride), len(tenths) - 1))
    found = dict(zip(coarse.tolist(), characters(tenths[coarse]), strict=True))
    changed = [k for a, b in pairwise(coarse) if found[a] != found[b] for k in range(a + 1, b)]
    if changed:
        found.update(zip(changed, characters(tenths[changed]), strict=True))
    below: list[tuple[float, dict[str, Columns]]] = []
    mixed: list[list[float]] = []
    last = None
    for k in sorted(found):
        columns, is_mixed = found[k]
        if columns != last:
            below.append((float(tenths[k]), dict(columns)))
            last = columns
        if is_mixed and mixed and mixed[-1][0] - tenths[k] < COARSE + FINE:
            mixed[-1][0] = float(tenths[k])
        elif is_mixed:
            mixed.append([float(tenths[k]), float(tenths[k])])
    return below, mixed[::-1]


def named_at(shapes: ModeShapes, k: int) -> dict[str, Columns]:
    """The branches of weave, wobble, rider-wobble and capsize by their mode shapes k, those at the naming speed."""
    part, roll, torso = (shapes.part(k, motion) for motion in ("steer", "roll", "torso"))
    other = shapes.foreign_participation(k) > MAJORITY
    upper = shapes.upper(k)
    in_pairs = {c for i in upper for c in shapes.pair(k, i)}
    real = [i for i in range(len(part)) if int(shapes.column[k, i]) not in in_pairs and not other[i]]
    names: dict[str, Columns] = {}
    if real:
        capsize = min(real, key=lambda i: abs(shapes.eigenvalues[k, i]))
        names["capsize"] = (int(shapes.column[k, capsize]),)
        real.remove(capsize)
    pairs = [i for i in upper if not other[i]]
    if pairs:
        weave = max(pairs, key=lambda i: roll[i] - part[i])
        names["weave"] = shapes.pair(k, weave)
        rest = sorted((i for i in pairs if i != weave), key=lambda i: -part[i] - torso[i])
        has_torso = bool(torso.any())
        front = sorted(rest[: 1 + has_torso], key=lambda i: shapes.together[k, i])
        if has_torso and len(front) == 1 and shapes.together[k, front[0]] > 0:
            names["rider_wobble"] = shapes.pair(k, front[0])
            names["wobble"] = tuple(int(shapes.column[k, i]) for i in sorted(real, key=lambda i: -part[i])[:2])
        else:
            names.update({mode: shapes.pair(k, i) for mode, i in zip(("wobble", "rider_wobble"), front, strict=False)})
        names.update({f"{OTHER} {n}": shapes.pair(k, i) for n, i in enumerate(rest[1 + has_torso :])})
    of_devices = [shapes.pair(k, i) for i in upper if other[i]] + [
        (int(c),) for i, c in enumerate(shapes.column[k]) if other[i] and int(c) not in in_pairs
    ]
    names.update({f"{OTHER} of device {n}": columns for n, columns in enumerate(of_devices)})
    return names


def _formation_of_another_pair(
    linearised: Linearised, branches: Branches, named: dict[str, Columns], reference_speed: float
) -> tuple[float, Columns]:
    """The highest speed below the naming speed with a pair of the vehicle that has not one name, and its branches."""
    values = branches.eigenvalues
    partner = np.arange(values.shape[1])
    for columns in named.values():
        if len(columns) == 2:
            partner[list(columns)] = columns[::-1]
    of_one_name = (partner != np.arange(len(partner))) & (
        np.abs(values[:, partner] - values.conj()) <= 1e-6 * np.abs(values)
    )
    apart = (values.imag > 0) & ~of_one_name
    formed = np.flatnonzero(apart.any(axis=1) & (branches.parameter < reference_speed))
    if not len(formed):
        return 0.0, ()
    if not any(mode.startswith(OTHER) for mode in named):
        formed = formed[-1:]
    shapes = ModeShapes.at(branches.parameter[formed], linearised, branches)
    for k in range(len(formed))[::-1]:
        foreign = shapes.foreign_participation(k)
        for i in shapes.upper(k):
            if apart[formed[k], shapes.column[k, i]] and foreign[i] < SHARE:
                return float(branches.parameter[formed[k]]), shapes.pair(k, i)
    return 0.0, ()


def _characters(speeds: np.ndarray, linearised: Linearised, branches: Branches, above: dict[str, Columns]) -> list:
    """For each speed below the formation of rear wobble: the branches of the modes, and whether they are mixed."""
    shapes = ModeShapes.at(speeds, linearised, branches)
    return [_character(shapes, k, above) for k in range(len(speeds))]


def _character(shapes: ModeShapes, k: int, above: dict[str, Columns]) -> tuple[tuple[tuple[str, Columns], ...], bool]:
    rivals = [
        columns for mode, columns in above.items() if len(columns) == 2 and (mode == "weave" or mode.startswith(OTHER))
    ]
    elsewhere = {c for columns in rivals for c in columns}
    foreign, own = shapes.foreign_participation(k), shapes.column[k]
    weave = {"weave": min(rivals, key=lambda columns: foreign[np.isin(own, columns)].sum())} if "weave" in above else {}
    pairs = {i: shapes.pair(k, i) for i in shapes.upper(k)}
    pairs = {i: columns for i, columns in pairs.items() if foreign[i] < SHARE or not elsewhere.isdisjoint(columns)}
    tyres, together = shapes.tyres[k].tolist(), shapes.together[k].tolist()
    front = sorted((i for i, columns in pairs.items() if elsewhere.isdisjoint(columns)), key=lambda i: -tyres[i])
    if not front:
        return tuple((weave | {mode: above[mode] for mode in FRONT if mode in above}).items()), False
    names: dict[str, Columns] = dict(weave)
    if tyres[front[0]] > 1:
        names["rear_wobble"] = pairs[front.pop(0)]
    rest = sorted(front, key=lambda i: together[i])
    if len(rest) == 1 and "rider_wobble" in above and ("rear_wobble" in names or together[rest[0]] > 0):
        names["rider_wobble"] = pairs[rest[0]]
    else:
        names.update({mode: pairs[i] for mode, i in zip(("wobble", "rider_wobble"), rest, strict=False)})
    used = {c for columns in pairs.values() for c in columns}
    left = tuple(c for mode in FRONT for c in above.get(mode, ()) if c not in used)
    names.update({mode: left for mode in FRONT if mode in above and mode not in names})
    ratios = sorted((tyres[i] for i, columns in pairs.items() if elsewhere.isdisjoint(columns)), reverse=True)
    is_mixed = "rider_wobble" in above and "rear_wobble" in names and len(ratios) > 1 and ratios[1] > MIXED * ratios[0]
    return tuple(sorted(names.items())), is_mixed

