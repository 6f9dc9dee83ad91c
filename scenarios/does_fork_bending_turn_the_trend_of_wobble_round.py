"""Does fork bending turn the trend of wobble damping over speed round, and what do frame torsion and rider do to weave?

The findings of the 2020 paper on the touring motorcycle (Section 4.1 and abstract), with its freedoms freed one by one
from a rigid motorcycle with a rigid rider, and all of them, with the hands off and with the passive rider.
"""

from itertools import cycle

import numpy as np

from fmus.composition.system import System
from motofmi.reports.charts import SEQUENCE, Axis, Chart, Curve, Line, Panel
from motofmi.reports.report import Section, Table
from rider_fmu import riders
from vehicle_fmu import Modes, modes, motorcycles, over_speed, ridden
from vehicle_fmu.components.touring_motorcycle import FLEXIBLE

SPEEDS = np.arange(10.0, 70.25, 2.5)  # m/s
RIGID, ALL, WITH_RIDER = "rigid", "all free", "all free, mean rider"


def systems(vehicle: str = "tum_2020") -> dict[str, System]:
    """The motorcycle rigid, with each freedom, with all of them, and with all of them and the passive rider."""
    free = motorcycles.load(vehicle)
    rigid = free.with_values(**dict.fromkeys(FLEXIBLE, 0.0))
    each = {name.replace("_", " "): ridden(rigid.with_values(**{name: 1.0})) for name in FLEXIBLE}
    return {RIGID: ridden(rigid), **each, ALL: ridden(free), WITH_RIDER: ridden(free, riders.load("mean_2011"))}


def run(speeds: np.ndarray = SPEEDS, vehicle: str = "tum_2020") -> dict[str, Modes]:
    """The modes of each system over speeds (n,) in m/s."""
    return {words: modes(over_speed(system), speeds) for words, system in systems(vehicle).items()}


def trend(one: Modes) -> str:
    """Where the damping of wobble (minus its real part) is least and largest, and which comes first."""
    damping = -one["wobble"].eigenvalue.real
    if np.isnan(damping).all():
        return "no wobble named"
    low, high = int(np.nanargmin(damping)), int(np.nanargmax(damping))
    words = "falls" if high < low else "rises"
    return f"{words}: {damping[min(low, high)]:.1f} at {one.speed[min(low, high)]:g} to {damping[max(low, high)]:.1f} at {one.speed[max(low, high)]:g} m/s"


def findings(found: dict[str, Modes]) -> Table:
    """The findings of the paper that its public text states, with what is computed."""
    rigid, bending = (-found[words]["wobble"].eigenvalue.real for words in (RIGID, "fork bending"))
    speed = found[RIGID].speed
    turned = speed[np.nanargmax(bending)]
    shift = {words: found[words]["weave"].eigenvalue.real - found[RIGID]["weave"].eigenvalue.real
             for words in ("frame torsion", "rider lean", "rider slide")}  # fmt: skip
    low, high = (int(np.argmin(np.abs(speed - v))) for v in (30.0, 60.0))
    rows = [
        ["rigid fork: damping of wobble falls with speed", f"{rigid[low]:.1f} at {speed[low]:g}, {rigid[high]:.1f} 1/s at {speed[high]:g} m/s",
         _met(rigid[high] < rigid[low])],
        ["fork bending turns this trend round", f"{bending[0]:.1f} at {speed[0]:g}, {np.nanmax(bending):.1f} at {turned:g}, "
         f"{bending[-1]:.1f} 1/s at {speed[-1]:g} m/s: rises up to {turned:g} m/s only", _met(turned == speed[-1], turned > speed[low])],
        ["wobble remains well damped, rigid and with fork bending", f"least {rigid.min():.1f} and {np.nanmin(bending):.1f} 1/s",
         _met(rigid.min() > 1 and np.nanmin(bending) > 1, min(rigid.min(), np.nanmin(bending)) > 0)],
        *([f"{words} changes weave", f"real part by {shift[words][low]:+.2f} at {speed[low]:g}, {shift[words][high]:+.2f} 1/s "
           f"at {speed[high]:g} m/s", _met(np.abs(shift[words]).max() > 0.1)] for words in shift),
    ]  # fmt: skip
    return Table(["finding of the 2020 paper", "computed", "met"], rows, "Findings of the paper, and what is computed")


def _met(wholly: bool, partly: bool = False) -> str:
    return "yes" if wholly else "partly" if partly else "no"


def table(found: dict[str, Modes]) -> Table:
    """Weave and wobble of each system at three speeds."""
    rows = [[words, *(_at(one, mode, v) for mode in ("weave", "wobble") for v in (20.0, 40.0, 60.0)), trend(one)]
            for words, one in found.items()]  # fmt: skip
    headings = ["free", *(f"{mode} at {v} m/s" for mode in ("weave", "wobble") for v in (20, 40, 60)), "damping of wobble [1/s]"]
    return Table(headings, rows, "Real part [1/s] and damped frequency [Hz]")


def _at(one: Modes, mode: str, speed: float) -> str:
    value = one[mode].eigenvalue[np.argmin(np.abs(one.speed - speed))]
    return "no name" if np.isnan(value) else f"{value.real:+.2f}, {value.imag / (2 * np.pi):.2f}"


def chart(found: dict[str, Modes]) -> Chart:
    """The real parts of wobble and weave over speed; dashed where colours repeat."""
    styles = dict(zip(found, zip(cycle(SEQUENCE), ["line"] * len(SEQUENCE) + ["dashed"] * len(found), strict=False), strict=False))
    return Chart([Panel(Axis("speed", "m/s"), Axis(f"real part of {mode}", "1/s"),
                        [Curve(words, one.speed, one[mode].eigenvalue.real, *styles[words]) for words, one in found.items()],
                        lines=[Line(0)], height=380) for mode in ("wobble", "weave")], columns=2)  # fmt: skip


def section(found: dict[str, Modes]) -> Section:
    """The answer: findings, figure and table."""
    text = ("With a rigid fork the damping of wobble falls over the speed; with fork bending it rises first. Frame torsion "
            "and fork bending unsettle weave at high speed, the rider's lean settles it.")  # fmt: skip
    return Section("Does fork bending turn the trend of wobble round?", [text],
                   [(chart(found), "Each freedom by itself, all of them, and all of them with the passive rider")],
                   [findings(found), table(found)])  # fmt: skip
