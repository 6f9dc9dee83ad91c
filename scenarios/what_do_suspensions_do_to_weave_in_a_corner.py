"""What do suspensions, tyre deflection and acceleration do to weave in a corner? The touring motorcycle of 2020, hands
off, by lean angle with freedoms in its plane free or locked, and at one lean angle by longitudinal acceleration.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from motofmi.reports.charts import SEQUENCE, Axis, Chart, Curve, Line, Panel
from motofmi.reports.report import Section, Table
from motofmi.workflows.trim import Trim, trim
from vehicle_fmu.large_motion.suspension import SUSPENSIONS
from vehicle_fmu.large_motion.touring_tree import PLANE

SPEED, LEANS = 30.0, np.arange(0.0, 46.0, 15.0)  # m/s, deg
ACCELERATIONS, LEAN = np.arange(-6.0, 5.0, 2.0), 20.0  # m/s2, deg
SLIPS = tuple(name for name in PLANE if name.endswith("slip"))
LOCKED = {
    "all locked": PLANE,
    "suspensions free": tuple(name for name in PLANE if name not in SUSPENSIONS),
    "tyre deflection free": tuple(name for name in PLANE if not name.endswith("deflection")),
    "longitudinal slip free": tuple(name for name in PLANE if name not in SLIPS),
    "all free": (),
}
MODES = ("weave", "wobble", "capsize", "bounce", "pitch", "front_hop", "rear_hop", "fork_bending")


class Found(NamedTuple):
    """Steady turning over the lean angle by what is free, and over the acceleration."""

    over_lean: Mapping[str, Trim]
    over_acceleration: Trim


def run(
    speed: float = SPEED, leans: np.ndarray = LEANS, accelerations: np.ndarray = ACCELERATIONS, lean: float = LEAN
) -> Found:
    """At a speed [m/s]: over lean angles (n,) [deg], and over longitudinal accelerations (m,) [m/s2] at one."""
    over_lean = {
        words: trim("tum_2020", speed=speed, lean=leans, set=dict.fromkeys(names, 0.0)) for words, names in LOCKED.items()
    }
    return Found(over_lean, trim("tum_2020", speed=speed, lean=lean, longitudinal_acceleration=accelerations))


def answer(found: Found) -> str:
    """The answer in sentences, from the numbers."""
    free, locked = found.over_lean["all free"], found.over_lean["all locked"]
    change = free["weave"].eigenvalue.real - locked["weave"].eigenvalue.real
    wobble = free["wobble"].eigenvalue.real - locked["wobble"].eigenvalue.real
    pushed, weave = found.over_acceleration, found.over_acceleration["weave"].eigenvalue.real
    return (
        f"At {free.speed:g} m/s the freedoms in the plane change the real part of weave by {change[0]:+.2f} 1/s upright "
        f"and by {change[-1]:+.2f} 1/s at {free.lean[-1]:g} deg of lean, that of wobble by {wobble[0]:+.2f} and "
        f"{wobble[-1]:+.2f} 1/s. At {pushed.lean[0]:g} deg of lean the real part of weave is {weave[0]:+.2f} 1/s at an "
        f"acceleration of {pushed.longitudinal_acceleration[0]:g} m/s2 and {weave[-1]:+.2f} 1/s at "
        f"{pushed.longitudinal_acceleration[-1]:g} m/s2."
    )


def table(found: Found) -> Table:
    """Weave and wobble by what is free, over the lean angle; all modes in the plane where all is free."""
    rows = [
        [words, mode.replace("_", "-"), *map(_eigenvalue, one[mode].eigenvalue)]
        for words, one in found.over_lean.items()
        for mode in MODES
        if mode in one.named and (words == "all free" or mode in ("weave", "wobble"))
    ]
    one = found.over_lean["all free"]
    heads = ["free in the plane", "mode", *(f"{lean:g} deg" for lean in one.lean)]
    return Table(heads, rows, f"Real part [1/s] and damped frequency [Hz] at {one.speed:g} m/s over the lean angle")


def pushed_table(found: Found) -> Table:
    """Equilibrium and modes over the acceleration."""
    one = found.over_acceleration
    quantities: Sequence[tuple[str, str, float]] = (
        ("front load [N]", "front_load", 1.0),
        ("rear load [N]", "rear_load", 1.0),
        ("front suspension [mm]", "front_suspension", 1e3),
        ("rear longitudinal slip [%]", "rear_longitudinal_slip", 1e2),
        ("steer torque [N.m]", "steer_torque", 1.0),
    )
    rows = [[words, *(f"{scale * x + 0.0:.1f}" for x in one[name])] for words, name, scale in quantities]
    rows += [[mode.replace("_", "-"), *map(_eigenvalue, one[mode].eigenvalue)] for mode in MODES]
    heads = ["acceleration [m/s2]", *(f"{a:g}" for a in one.longitudinal_acceleration)]
    caption = f"At {one.speed:g} m/s and {one.lean[0]:g} deg of lean, hands off: equilibrium, and modes at constant speed"
    return Table(heads, rows, caption)


def chart(found: Found) -> Chart:
    """The real parts of weave over the lean angle by what is free, and of weave and wobble over the acceleration."""
    over_lean = [
        Curve(words, one.lean, one["weave"].eigenvalue.real, colour)
        for (words, one), colour in zip(found.over_lean.items(), SEQUENCE, strict=False)
    ]
    pushed = found.over_acceleration
    over_acceleration = [
        Curve(mode, pushed.longitudinal_acceleration, pushed[mode].eigenvalue.real, colour)
        for mode, colour in zip(("weave", "wobble"), SEQUENCE, strict=False)
    ]
    panels = [
        Panel(Axis("lean angle", "deg"), Axis("real part of weave", "1/s"), over_lean, lines=[Line(0)], height=380),
        Panel(Axis("acceleration", "m/s2"), Axis("real part", "1/s"), over_acceleration, lines=[Line(0)], height=380),
    ]
    return Chart(panels, columns=2)


def section(found: Found) -> Section:
    """The answer: sentences, figure and tables."""
    title = "What do suspensions and acceleration do to weave in a corner?"
    figure = chart(found), "By what is free in the plane, and by longitudinal acceleration"
    return Section(title, [answer(found)], [figure], [table(found), pushed_table(found)])


def _eigenvalue(value: complex) -> str:
    return "none named" if np.isnan(value) else f"{value.real:+.2f}, {value.imag / (2 * np.pi):.2f}"
