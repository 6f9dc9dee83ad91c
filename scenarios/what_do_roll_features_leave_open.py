"""What do the roll test's features leave open? All riders in roll that meet every printed feature at once (2008).

Random walks over the logarithms of joints, accelerometer places and the height of the roll axis, which is not printed:
a step is taken when every one of the 14 features still holds. What the walks visit is at least what the features allow
within WIDEST around the shipped rider's joints and within PLACES. Modulus and phase curves are those of the paper's
Figs 16 to 23, of the three riders that ship: inertias from height and mass, joints found by the search.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import differential_evolution

from fmus.declaration.component import Component
from fmus.linear_analysis.linearisation import linearise
from fmus.support.progress import track
from motofmi.reports.charts import SEQUENCE, Axis, Chart, Curve, Panel
from motofmi.reports.report import Section, Table
from motofmi.scenarios.what_does_lean_do_to_weave import systems
from motofmi.workflows.scenarios import InReport
from rider_fmu import RiderInRoll, riders
from rider_fmu.components.rider_in_roll import POINTS
from rider_fmu.roll_features import FEATURES, FREQUENCIES, NUMBER, RIDERS, misses, readings, relative, roll_frf
from vehicle_fmu import modes, over_speed

REPORT = InReport("full rider", 40, "riders that meet the roll features")

JOINTS = tuple(f"{joint}_{kind}" for joint in ("saddle", "lean", "neck_roll") for kind in ("stiffness", "damping"))
PLACES = {
    "saddle_height": (0.5, 2.0),
    "waist_point": (0.05, 0.3),
    "shoulder_point": (0.3, 0.55),
    "head_point": (0.05, 0.3),
}  # m
FREE = (*JOINTS, *PLACES)
WIDEST = 8.0  # factor either way for a joint; what ends here is not bounded by the features
UNSTABLE, VALLEY = 100.0, 0.02
STEP = 0.08  # of the logarithm
SPEED = np.array([40.0])  # m/s, where a turning rider's weave grows fastest


@dataclass(frozen=True)
class OpenFeatures:
    """The shipped riders' curves by number, the riders (n, parameters) that the walks visited, and
    what they have in common.

    taken is the share of steps that each walk took; ranges maps every free parameter to the least, the median and the
    largest value visited; weave (k,) is the real part [1/s] at 40 m/s of a motorcycle with a turning and leaning
    rider, for some of them.
    """

    curves: dict[int, dict[str, np.ndarray]]
    visited: np.ndarray
    taken: list[float]
    weave: np.ndarray
    ranges: dict[str, np.ndarray]


def run(rider: str = "roll_3_2008", starts: int = 4, proposals: int = 1500, generations: int = 250) -> OpenFeatures:
    """Walks from the shipped rider and from riders found by a global search (`starts` of them, less where it fails
    within `generations`)."""
    shipped = riders.load(rider)
    found = [
        shipped,
        *(
            one
            for seed in track(range(1, starts + 1), "search")
            if allowed(one := searched(shipped, seed, generations))
        ),
    ]
    walks = [walk(one, proposals, np.random.default_rng(seed)) for seed, one in enumerate(found)]
    visited, taken = np.concatenate([v for v, _ in walks]), [t for _, t in walks]
    curves = {k: roll_frf(riders.load(f"roll_{k}_2008")) for k in RIDERS}
    chosen = visited[:: max(len(visited) // 30, 1)]
    growth = [_weave(values) for values in track(chosen, "weave")]
    return OpenFeatures(
        curves,
        visited,
        taken,
        np.array(growth),
        dict(zip(FREE, np.percentile(visited, (0, 50, 100), axis=0).T, strict=True)),
    )


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
    """The real part of weave at 40 m/s with these joints, on the motorcycle's saddle and with the
    masses of Sharp's rider."""
    joints = {n: x for n, x in zip(FREE, values, strict=True) if n in JOINTS}
    both = systems(leaning=riders.load("roll_1971", **joints))["both"]
    return float(modes(over_speed(both), SPEED)["weave"].eigenvalue[0].real)


def chart(found: OpenFeatures) -> Chart:
    """Moduli and phases of the FRFs of three riders, point by point, and of rider 3's relative FRFs."""
    panels = []
    for point in POINTS:
        by_rider = {f"rider {rider}": curves[point] for rider, curves in found.curves.items()}
        panels += _panels(by_rider, f"FRF_{NUMBER[point]}", SEQUENCE)
    relative_to_mockup = {
        f"point {NUMBER[point]}: {point}": curve for point, curve in relative(found.curves[3]).items()
    }
    return Chart([*panels, *_panels(relative_to_mockup, "rFRF of rider 3", SEQUENCE[3:])], columns=2)


def _panels(curves: dict[str, np.ndarray], what: str, colours: Sequence[str]) -> list[Panel]:
    frequency = Axis("frequency", "Hz")
    modulus = [
        Curve(n, FREQUENCIES, np.abs(z), c, "both", width=1) for (n, z), c in zip(curves.items(), colours, strict=False)
    ]
    phase = [Curve(n, FREQUENCIES, -np.degrees(np.mod(-np.angle(z), 2 * np.pi)), c, "both", width=1)
             for (n, z), c in zip(curves.items(), colours, strict=False)]  # fmt: skip
    return [
        Panel(frequency, Axis(f"modulus of {what}", "1"), modulus, height=260),
        Panel(frequency, Axis(f"phase of {what}", "deg"), phase, height=260),
    ]


def section(found: OpenFeatures) -> Section:
    """Every feature with its reading, and what stays open."""
    low, high = found.weave.min(), found.weave.max()
    text = [f"Every one of the {len(FEATURES)} printed features is met at once by riders of three freedoms: a pelvis "
            "that shifts on the saddle, a torso that leans, a head on the neck. (The head of rider 2 is the exception "
            "of the paper: above 4 Hz it does not come to rest.)",
            "The features do not single him out: the table gives how far riders that meet all of them were found "
            "apart, at least; with the motorcycle's turning rider added, the real part of weave at 40 m/s is "
            f"{low:+.2f} to {high:+.2f} 1/s for them, +0.34 without lean."]  # fmt: skip
    read = {rider: readings(curves) for rider, curves in found.curves.items()}
    rows = [[f.quantity, str(NUMBER[f.point]), f.name.replace("_", " "), f"{f.low:g} to {f.high:g} {f.unit}",
             *("{:.3g} to {:.3g}".format(*read[rider][k]) + ("" if rider in f.riders else " (not printed)")
               for rider in read)]
            for k, f in enumerate(FEATURES)]  # fmt: skip
    units = {n: RiderInRoll.declared[n].unit for n in FREE}
    ranges = [[n.replace("_", " "), units[n], *(f"{x:.3g}" for x in found.ranges[n])] for n in FREE]
    return Section("What do roll features leave open?", text, [(chart(found), "The paper's Figs 16 to 23, as "
                                                                               "computed: FRFs of three riders at "
                                                                               "waist, shoulders and head, relative "
                                                                               "FRFs of rider 3")],
                   [Table(["quantity", "point", "feature", "printed", *(f"rider {k}" for k in read)], rows),
                    Table(["parameter", "unit", "least", "median", "largest"], ranges)])  # fmt: skip
