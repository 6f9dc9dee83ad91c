"""What does each reading of the published values do to weave and wobble of Sharp's motorcycle of 1994?

The parameter file of that model leaves some choices open. Each row changes one of them against the shipped values, with
the hands off and on.
"""

from math import cos, pi

import numpy as np

from fmus.declaration.component import Component
from motofmi.reports.report import Section, Table
from vehicle_fmu import Modes, modes, motorcycles, over_speed, ridden

SPEEDS = np.unique(np.append(np.arange(1.0, 70.5, 1.0), [20.0, 50.0]))  # m/s
DEFAULT = "as shipped"
TRIPLETS = ("roll_inertia", "yaw_inertia", "product_of_inertia")
HANDS = {"hands off": 0.0, "hands on": 1.0}


def readings(motorcycle: Component) -> dict[str, dict[str, float]]:
    """The values that each reading changes, by its words."""
    v = motorcycle.values
    bodies = ("frame", "upper_body")
    exchanged = {f"{a}_{n}": v[f"{b}_{n}"] for a, b in (bodies, bodies[::-1]) for n in TRIPLETS}
    camber = [n for n in v if "_camber_moment_stiffness_" in n]
    return {
        DEFAULT: {},
        "inertias of rear frame and upper body exchanged, as the file names them": exchanged,
        "products of inertia as tensor elements": {f"{b}_product_of_inertia": -v[f"{b}_product_of_inertia"] for b in bodies},
        "inertia of the front frame in the vehicle's axes": {"front_inertia_inclination": 0.0},
        "trail measured on the ground": {"trail": v["trail"] * cos(v["caster_angle"])},
        "aligning moments follow slip and camber at once": {"moment_relaxes": 0.0},
        "camber moments turn the wheels out of their camber": {n: -v[n] for n in camber},
        "head twists about a horizontal axis": {"head_twist_inclination": 0.0},
        "rear assembly twists about an axis that rises forwards": {"rear_twist_inclination": pi - v["rear_twist_inclination"]},
        "rear assembly twists about a horizontal axis": {"rear_twist_inclination": pi / 2},
        "flywheel carried by the rear wheel assembly": {
            "rear_spin_inertia": v["rear_spin_inertia"] + v["engine_spin_inertia"], "engine_spin_inertia": 0.0},
        "no drag, rolling resistance and drive beside the loads": {"longitudinal_forces": 0.0},
    }  # fmt: skip


def run(vehicle: str = "sharp_1994", speeds: np.ndarray = SPEEDS) -> dict[tuple[str, str], Modes]:
    """The modes by reading and hands, over speeds [m/s]."""
    motorcycle = motorcycles.load(vehicle)
    return {
        (words, hands): modes(over_speed(ridden(motorcycle.with_values(**changed, hands_on=on))), speeds)
        for words, changed in readings(motorcycle).items()
        for hands, on in HANDS.items()
    }


def table(found: dict[tuple[str, str], Modes]) -> Table:
    """One row for each reading: weave at 50 m/s, wobble at 20 m/s, and the speed from which weave is unstable."""
    rows = []
    for words in dict.fromkeys(words for words, _ in found):
        row = [words]
        for hands in HANDS:
            one = found[words, hands]
            row += [_at(one, "weave", 50.0), _at(one, "wobble", 20.0), _upper(one)]
        rows.append(row)
    headings = ["reading", *(f"{h}: {m}" for h in HANDS for m in ("weave at 50 m/s", "wobble at 20 m/s", "weave unstable from [m/s]"))]
    return Table(headings, rows, "Real part [1/s] and damped frequency [Hz] with each reading")


def _at(one: Modes, mode: str, speed: float) -> str:
    value = one[mode].eigenvalue[np.argmin(np.abs(one.speed - speed))]
    return "no name" if np.isnan(value) else f"{value.real:+.2f}, {value.imag / (2 * pi):.2f}"


def _upper(one: Modes) -> str:
    """Where weave becomes unstable at high speed."""
    return next((f"{a:.1f}" for a, b in one.unstable["weave"][::-1] if b == one.speed[-1]), f"above {one.speed[-1]:g}")


def section(found: dict[tuple[str, str], Modes]) -> Section:
    """The table of all readings."""
    text = "One reading differs from the shipped values in each row; hands off the bar, and with the paper's hands on it."
    return Section("What does each reading of the values of Sharp's motorcycle of 1994 do?", [text], [], [table(found)])
