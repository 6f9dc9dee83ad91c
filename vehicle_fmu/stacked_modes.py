"""The named modes of many vehicles of one structure at the same speeds: a population, a grid of parameters.

The names are those of `vehicle_fmu.mode_names`, found with fewer spectra. Eigenvalues are tracked from the naming speed
down over the requested speeds, with further points only where neighbouring spectra cannot be matched. Below the
formation of another pair the names follow the mode shapes at each requested speed.

An instability that begins and ends between two requested speeds is not found; the ends of the others are located by
the method of false position.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fmus.linear_analysis.eigenvalue_tracking import track_stacked
from fmus.linear_analysis.linearisation import StateSpace
from vehicle_fmu.flexible_mode_names import FRONT, OTHER
from vehicle_fmu.mode_curves import ABSENT, PARTNER, factors_of, mode_curves
from vehicle_fmu.mode_names import COARSE, MODES, SHARE, masks, named_at
from vehicle_fmu.mode_shapes import Columns, ModeShapes, further_states
from vehicle_fmu.named_modes import LOWEST_SPEED, REFERENCE_SPEED, modes

# member indices (n,) and speeds (n,) [m/s] -> stacked state spaces with outputs
StackedLinearised = Callable[[np.ndarray, np.ndarray], StateSpace]
BAND_STEPS = 3  # of false position: an end is then within 0.01 m/s for grids of 1 m/s


@dataclass(frozen=True)
class StackedModes:
    """eigenvalue (members, modes, speeds) [1/s] of the modes MODES, with Im >= 0, NaN where absent.

    unstable holds the bands of all members, one row each: member, mode (indices), and from, to in m/s.
    """

    speed: np.ndarray
    eigenvalue: np.ndarray
    unstable: np.ndarray


def stacked_modes(linearised: StackedLinearised, members: int, speeds: np.ndarray,
                  reference_speed: float = REFERENCE_SPEED) -> StackedModes:  # fmt: skip
    """The named modes of `members` vehicles at ascending speeds (n,) [m/s].

    found = stacked_modes(lambda member, speed: linearise(system, **{
        "vehicle.speed": speed, "vehicle.trail": trails[member]}), len(trails), speeds)
    """
    if "vehicle" in further_states(linearised(np.zeros(1, int), speeds[:1]).states):
        return _one_by_one(linearised, members, speeds, reference_speed)
    grid = grid_of(speeds, reference_speed)
    tracked = track_stacked(lambda member, speed: linearised(member, speed).A, members, grid)
    everyone, top = np.arange(members), int(np.searchsorted(grid, reference_speed - 1e-9))
    distinct = ModeShapes.of(linearised(everyone, np.full(members, grid[top])), tracked[:, top])
    above = [named_at(distinct, k) for k in range(members)]
    formation = _formations(linearised, tracked[:, :top], grid[:top], above)
    wanted = np.searchsorted(grid, speeds - 1e-9)
    spectra = tracked[:, wanted]
    named = masks(above, spectra.shape[2])
    own = np.repeat(named[:, :, None], len(speeds), axis=2)
    member, place = np.nonzero(wanted[None, :] <= formation[:, None])
    if len(member):
        shapes = ModeShapes.of(linearised(member, speeds[place]), spectra[member, place])
        own[member, :, place] = _by_shape(shapes, member, above)
    flat, count, width = spectra.reshape(-1, spectra.shape[2]), len(speeds), spectra.shape[2]
    curves = mode_curves(flat, own.swapaxes(0, 1).reshape(len(MODES), -1, width),
                         lambda at: ModeShapes.of(linearised(at // count, speeds[at % count]), flat[at]),
                         lambda at: factors_of(distinct, named)[at // count])  # fmt: skip
    eigenvalue = curves.reshape(len(MODES), members, count).swapaxes(0, 1)
    return StackedModes(speeds, eigenvalue, _unstable(linearised, speeds, eigenvalue))


def _one_by_one(
    linearised: StackedLinearised, members: int, speeds: np.ndarray, reference_speed: float
) -> StackedModes:
    """The modes of each vehicle by itself: of those with further freedoms, whose names need the finer grid."""
    eigenvalue, unstable = np.full((members, len(MODES), len(speeds)), ABSENT), []
    for member in range(members):

        def alone(speed: np.ndarray, member: int = member) -> StateSpace:
            return linearised(np.full(len(speed), member), speed)

        found = modes(alone, speeds, reference_speed)
        for k, mode in enumerate(MODES):
            eigenvalue[member, k] = found[mode].eigenvalue
            unstable += [(member, k, *band) for band in found.unstable.get(mode, [])]
    return StackedModes(speeds, eigenvalue, np.reshape(np.array(unstable, float), (-1, 4)))


def grid_of(speeds: np.ndarray, reference_speed: float = REFERENCE_SPEED) -> np.ndarray:
    """The requested speeds, the lowest and the naming speed, with points at most COARSE apart between them: names do
    not depend on the requested speeds."""
    ends = np.union1d(speeds, [LOWEST_SPEED, reference_speed])
    inner = [np.linspace(a, b, int(np.ceil((b - a) / COARSE - 1e-9)) + 1)[1:-1] for a, b in pairwise(ends)]
    return np.sort(np.concatenate([ends, *inner]))


def _formations(linearised: StackedLinearised, spectra: np.ndarray, grid: np.ndarray,
                above: list[dict[str, Columns]]) -> np.ndarray:  # fmt: skip
    """The index of the highest speed below the naming speed at which another pair of the vehicle exists, -1 for none.

    Where the pair has no branch of a name, it becomes the rear wobble in `above`.
    """
    members, _, width = spectra.shape
    partner = np.tile(np.arange(width), (members, 1))
    for member, named in enumerate(above):
        for columns in named.values():
            if len(columns) == 2:
                partner[member, list(columns)] = columns[::-1]
    paired = np.take_along_axis(spectra, np.broadcast_to(partner[:, None], spectra.shape), axis=2)
    one_name = (partner != np.arange(width))[:, None] & (np.abs(paired - spectra.conj()) <= PARTNER * np.abs(spectra))
    apart = (spectra.imag > 0) & ~one_name
    every = [np.flatnonzero(each.any(axis=1)) for each in apart]
    formed = [at if any(mode.startswith(OTHER) for mode in named) else at[-1:]
              for at, named in zip(every, above, strict=True)]  # fmt: skip
    formation = np.full(members, -1)
    owner, place = _pairs_of(formed)
    if not len(owner):
        return formation
    shapes = ModeShapes.of(linearised(owner, grid[place]), spectra[owner, place])
    foreign = shapes.foreign_participations
    own = np.take_along_axis(apart[owner, place], shapes.column, axis=1)
    own &= (shapes.eigenvalues.imag > 0) & (foreign < SHARE)
    for p in np.flatnonzero(own.any(axis=1)):  # ascending: the highest speed of a member is the last
        formation[owner[p]] = p
    for k in np.flatnonzero(formation >= 0).tolist():
        at = int(formation[k])
        another = shapes.pair(at, int(own[at].argmax()))
        if not {c for mode, columns in above[k].items() if not mode.startswith(OTHER) for c in columns} & set(another):
            above[k]["rear_wobble"] = another
        formation[k] = place[at]
    return formation


def _pairs_of(places: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Member indices and places (n,) of the places of each member."""
    member = np.repeat(np.arange(len(places)), [len(at) for at in places])
    return member, np.concatenate([np.zeros(0, int), *places])


def _by_shape(shapes: ModeShapes, member: np.ndarray, above: list[dict[str, Columns]]) -> np.ndarray:
    """Which branches each mode has (points, modes, width) by the mode shapes at points of given members."""
    points, width = shapes.eigenvalues.shape
    every = np.arange(points)
    rivals: list[dict[str, Columns]] = [
        {m: c for m, c in named.items() if len(c) == 2 and (m == "weave" or m.startswith(OTHER))} for named in above
    ]
    elsewhere = np.zeros((len(above), width), bool)
    for k, pairs_of_others in enumerate(rivals):
        elsewhere[k, [c for both in pairs_of_others.values() for c in both]] = True
    conjugate = np.roll(shapes.column, -1, axis=1)  # LAPACK returns pairs in adjacent positions
    foreign = shapes.foreign_participations
    upper = shapes.eigenvalues.imag > 0
    of_rivals = np.take_along_axis(elsewhere[member], shapes.column, 1) | np.take_along_axis(
        elsewhere[member], conjugate, 1)  # fmt: skip
    pairs = upper & ((foreign < SHARE) | of_rivals)
    front = pairs & ~of_rivals

    def columns(i: np.ndarray, chosen: np.ndarray) -> np.ndarray:
        """The branches (points, width) of the pair at index i, none where not chosen."""
        mask = np.zeros((points, width), bool)
        mask[every, shapes.column[every, i]] = chosen
        mask[every, conjugate[every, i]] |= chosen
        return mask

    before = masks(above, width)[member]
    present = before.any(axis=2)
    rear_at = np.where(front, shapes.tyres, -np.inf).argmax(axis=1)
    rear = front.any(axis=1) & (shapes.tyres[every, rear_at] > 1)
    rest = front.copy()
    rest[every, rear_at] &= ~rear
    order = np.where(rest, shapes.together, np.inf).argsort(axis=1, kind="stable")
    first, second, left = order[:, 0], order[:, 1], rest.sum(axis=1)
    rider = MODES.index("rider_wobble")
    alone = (left == 1) & present[:, rider] & (rear | (shapes.together[every, first] > 0))
    named = {
        "rear_wobble": columns(rear_at, rear),
        "wobble": columns(first, (left > 0) & ~alone),
        "rider_wobble": columns(first, alone) | columns(second, (left > 1) & ~alone),
    }
    used = np.zeros((points, width), bool)
    for i in range(width):
        used |= columns(np.full(points, i), pairs[:, i])
    front_before = before[:, [MODES.index(mode) for mode in FRONT]].any(axis=1)
    found = before.copy()
    some = front.any(axis=1)[:, None]
    for mode, mask in named.items():
        k = MODES.index(mode)
        kept = np.where(mask.any(axis=1)[:, None], mask, front_before & ~used & present[:, k, None])
        found[:, k] = np.where(some, kept, before[:, k])
    _choose_weave(found, shapes, foreign, member, rivals)
    return found


def _choose_weave(found: np.ndarray, shapes: ModeShapes, foreign: np.ndarray, member: np.ndarray,
                  rivals: list[dict[str, Columns]]) -> None:  # fmt: skip
    """Where weave veers with a mode of a device, weave is the one in which the device's states have the smaller
    part."""
    weave = MODES.index("weave")
    for p in np.flatnonzero([len(rivals[k]) > 1 and "weave" in rivals[k] for k in member]):
        best = min(rivals[member[p]].values(), key=lambda c: foreign[p][np.isin(shapes.column[p], c)].sum())
        found[p, weave] = False
        found[p, weave, list(best)] = True


def _unstable(linearised: StackedLinearised, speeds: np.ndarray, eigenvalue: np.ndarray) -> np.ndarray:
    """The unstable bands: rows of member, mode, from, to."""
    growth = np.nan_to_num(eigenvalue.real, nan=-1.0)
    unstable = np.pad(growth > 0, ((0, 0), (0, 0), (1, 1)))
    member, mode, place = np.nonzero(unstable[..., 1:] != unstable[..., :-1])
    ends = speeds[np.clip(place, 0, len(speeds) - 1)].astype(float)
    ends[place == len(speeds)] = speeds[-1]
    inside = (place > 0) & (place < len(speeds))
    inside &= np.isfinite(eigenvalue.real[member, mode, np.clip(place - 1, 0, None)])
    inside[inside] &= np.isfinite(eigenvalue.real[member[inside], mode[inside], place[inside]])
    if inside.any():
        at = member[inside], mode[inside]
        ends[inside] = _zeros(linearised, at[0], speeds[place[inside] - 1], speeds[place[inside]],
                              growth[(*at, place[inside] - 1)], growth[(*at, place[inside])])  # fmt: skip
    return np.column_stack([member[::2], mode[::2], ends[::2], ends[1::2]])


def _zeros(linearised: StackedLinearised, member: np.ndarray, a: np.ndarray, b: np.ndarray, fa: np.ndarray,
           fb: np.ndarray) -> np.ndarray:  # fmt: skip
    """The speeds between a and b at which a real part changes its sign, by the method of false position."""
    a, b, fa, fb = (np.array(x, float) for x in (a, b, fa, fb))
    for _ in range(BAND_STEPS):
        middle = (a * fb - b * fa) / (fb - fa)
        values = np.linalg.eigvals(linearised(member, middle).A).real
        expected = fa + (fb - fa) * (middle - a) / (b - a)
        value = np.take_along_axis(values, np.abs(values - expected[:, None]).argmin(axis=1)[:, None], axis=1)[:, 0]
        left = (value > 0) == (fa > 0)
        a, fa = np.where(left, middle, a), np.where(left, value, fa)
        b, fb = np.where(left, b, middle), np.where(left, fb, value)
    return (a * fb - b * fa) / np.where(fb == fa, 1.0, fb - fa)
