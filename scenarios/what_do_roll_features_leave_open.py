"""What do the roll test's features leave open? All riders in roll that meet every printed feature at once (2008).

Random walks over the logarithms of joints, accelerometer places and the height of the roll axis, which is not
printed: a step is taken when every one of the 14 features still holds. What the walks visit is at least what the features
allow within WIDEST around the shipped rider's joints and within PLACES. Its modulus and phase curves are the paper's Figs 16 to 23.
"""

import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import differential_evolution

from fmus.component import Component
from fmus.linear import linearise
from fmus.progress import track
from rider_fmu import RiderInRoll, riders
from rider_fmu.rider_in_roll import POINTS
from rider_fmu.roll_features import FEATURES, FREQUENCIES, NUMBER, misses, readings, relative, roll_frf
from scenarios.report import Section, Table, new_figure
from scenarios.what_does_lean_do_to_weave import systems
from vehicle_fmu import modes, over_speed

JOINTS = tuple(f"{joint}_{kind}" for joint in ("saddle", "lean", "neck_roll") for kind in ("stiffness", "damping"))
PLACES = {"saddle_height": (0.5, 2.0), "waist_point": (0.05, 0.3), "shoulder_point": (0.3, 0.55), "head_point": (0.05, 0.3)}  # m
FREE = (*JOINTS, *PLACES)
WIDEST = 8.0  # factor either way for a joint; what ends here is not bounded by the features
UNSTABLE, VALLEY = 100.0, 0.02
STEP = 0.08  # of the logarithm
SPEED = np.array([40.0])  # m/s, where a turning rider's weave grows fastest


def run(rider: str = "roll_3_2008", starts: int = 4, proposals: int = 1500, generations: int = 250) -> dict:
    """The shipped rider's curves and readings, the walks' riders (n, parameters), and the weave of some of them.

    Walks start from the shipped rider and from riders found by a global search (`starts` of them, less where it fails
    within `generations`). ranges maps every free parameter to the least, the median and the largest value visited;
    weave is the real part [1/s] at 40 m/s of a motorcycle with a turning and leaning rider.
    """
    shipped = riders.load(rider)
    found = [shipped, *(one for seed in track(range(1, starts + 1), "search") if allowed(one := searched(shipped, seed, generations)))]
    walks = [walk(one, proposals, np.random.default_rng(seed)) for seed, one in enumerate(found)]
    visited, taken = np.concatenate([v for v, _ in walks]), [t for _, t in walks]
    curves = roll_frf(shipped)
    chosen = visited[:: max(len(visited) // 30, 1)]
    growth = [_weave(values) for values in track(chosen, "weave")]
    return {"curves": curves, "readings": readings(curves), "visited": visited, "taken": taken, "weave": np.array(growth),
            "ranges": dict(zip(FREE, np.percentile(visited, (0, 50, 100), axis=0).T, strict=True))}  # fmt: skip


def limits(rider: Component) -> np.ndarray:
    """Least and largest values (10, 2) of FREE."""
    return np.array([PLACES.get(n, (rider.values[n] / WIDEST, rider.values[n] * WIDEST)) for n in FREE])


def searched(rider: Component, seed: int, generations: int) -> Component:
    """The rider that differential evolution finds within the limits, with the fewest and smallest misses."""
    def of(x: np.ndarray) -> Component:
        return rider.with_values(**dict(zip(FREE, np.exp(x), strict=True)))

    def cost(x: np.ndarray) -> float:
        one = of(x)
        if not stable(one):
            return UNSTABLE
        curves = roll_frf(one)
        # A count of peaks has no slope, the depth of the valley between them has.
        return float(misses(curves).sum() + max(VALLEY - valley(np.abs(curves["head"])), 0.0))

    found = differential_evolution(cost, np.log(limits(rider)), maxiter=generations, popsize=12, rng=seed, polish=False,
                                   callback=lambda x, convergence: cost(x) == 0)  # fmt: skip
    return of(found.x)


def valley(modulus: np.ndarray) -> float:
    """How far the modulus dips between two peaks below 2 Hz; negative where there is one peak."""
    low = modulus[FREQUENCIES <= 2]
    return float(max(min(low[:k].max(), low[k + 1 : -1].max()) - low[k] for k in range(1, len(low) - 2)))


def walk(rider: Component, proposals: int, generator: np.random.Generator) -> tuple[np.ndarray, float]:
    """Values of FREE (proposals, 10) along the walk, and the share of steps taken."""
    here = np.log([rider.values[n] for n in FREE])
    low, high = limits(riders.load("roll_3_2008")).T
    visited, taken = [], 0
    for _ in track(range(proposals), "riders that meet every feature"):
        # Steps in few directions at a time: the allowed region is thin in some of them.
        there = here + STEP * generator.standard_normal(len(FREE)) * (generator.random(len(FREE)) < 0.3)
        inside = ((low < np.exp(there)) & (np.exp(there) < high)).all()
        if inside and allowed(rider.with_values(**dict(zip(FREE, np.exp(there), strict=True)))):
            here, taken = there, taken + 1
        visited.append(np.exp(here))
    return np.array(visited), taken / proposals


def allowed(rider: Component) -> bool:
    """Whether the rider sits stably and meets every feature."""
    return stable(rider) and not misses(roll_frf(rider)).any()


def stable(rider: Component) -> bool:
    """Whether joints hold the rider up."""
    return bool(np.linalg.eigvals(linearise(rider).A).real.max() < 0)


def _weave(values: np.ndarray) -> float:
    """The real part of weave at 40 m/s with these joints, on the motorcycle's saddle and with the masses of Sharp's rider."""
    joints = {n: x for n, x in zip(FREE, values, strict=True) if n in JOINTS}
    both = systems(leaning=riders.load("roll_1971", **joints))["both"]
    return float(modes(over_speed(both), SPEED)["weave"].eigenvalue[0].real)


def figure(found: dict) -> Figure:
    """Moduli and phases of FRF and rFRF at the three points."""
    picture, axes = new_figure(2, 2, width=10, height=7)
    for row, (name, curves) in zip(np.atleast_2d(axes), (("FRF", found["curves"]), ("rFRF", relative(found["curves"]))), strict=True):
        for point in POINTS:
            phase = -np.degrees(np.mod(-np.angle(curves[point]), 2 * np.pi))
            row[0].plot(FREQUENCIES, np.abs(curves[point]), "o-", markersize=3, label=f"{NUMBER[point]}: {point}")
            row[1].plot(FREQUENCIES, phase, "o-", markersize=3)
        row[0].set(xlabel="frequency [Hz]", ylabel=f"|{name}| [1]")
        row[1].set(xlabel="frequency [Hz]", ylabel=f"phase of {name} [deg]")
        row[0].legend(fontsize=8)
    return picture


def section(found: dict) -> Section:
    """Every feature with its reading, and what stays open."""
    low, high = found["weave"].min(), found["weave"].max()
    text = [f"Every one of the {len(FEATURES)} printed features is met at once by a rider of three freedoms: a pelvis that shifts on the saddle, a torso that "
            "leans, a head on the neck.",
            "The features do not single him out: the table gives how far riders that meet all of them were found apart, at least; with the motorcycle's turning rider added, "
            f"the real part of weave at 40 m/s is {low:+.2f} to {high:+.2f} 1/s for them, +0.34 without lean."]  # fmt: skip
    rows = [[f.quantity, str(NUMBER[f.point]), f.name.replace("_", " "), f"{f.low:g} to {f.high:g} {f.unit}", f"{a:.3g} to {b:.3g}"]
            for f, (a, b) in zip(FEATURES, found["readings"], strict=True)]  # fmt: skip
    units = {n: RiderInRoll.declared[n].unit for n in FREE}
    ranges = [[n.replace("_", " "), units[n], *(f"{x:.3g}" for x in found["ranges"][n])] for n in FREE]
    return Section("What do roll features leave open?", text, [(figure(found), "FRF and relative FRF (2008, Figs 16 to 23), as computed")],
                   [Table(["quantity", "point", "feature", "printed", "computed"], rows), Table(["parameter", "unit", "least", "median", "largest"], ranges)])  # fmt: skip
