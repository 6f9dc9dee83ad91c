"""What does lean do to weave? Root loci with no moving rider, one who turns, one who leans, and one who does both.

The rider in roll takes his part of the rigid rider out of the motorcycle and brings it himself (pelvis, torso, head
on springs); the turning rider is the mean rider of 2011. The 2011 paper (Sect. 5) leaves the rider's roll to further
developments of its model.
"""

import numpy as np

from fmus.composition.system import System
from fmus.declaration.component import Component
from motofmi.reports.charts import SEQUENCE, Axis, Chart, Curve, Panel, Shade
from motofmi.reports.report import Section, Table
from motofmi.workflows.scenarios import InReport
from rider_fmu import riders
from vehicle_fmu import Modes, modes, motorcycles, over_speed, ridden

REPORT = InReport("full rider", 50, "weave with a leaning rider")

SPEEDS = np.arange(2.0, 60.1, 0.5)  # m/s
NAMES = {
    "rigid": "no moving rider",
    "turning": "turning rider",
    "leaning": "leaning rider",
    "both": "turning and leaning",
}


def systems(
    vehicle: str = "sharp_1971", turning: str = "mean_2011", leaning: Component | None = None
) -> dict[str, System]:
    """The four systems by name."""
    motorcycle, turns, leans = motorcycles.load(vehicle), riders.load(turning), leaning or riders.load("roll_1971")
    return {
        "rigid": ridden(motorcycle),
        "turning": ridden(motorcycle, turns),
        "leaning": ridden(motorcycle, leans),
        "both": ridden(motorcycle, turns, leans),
    }


def run(speeds: np.ndarray = SPEEDS, **given) -> dict[str, Modes]:
    """The modes of each system over speeds (n,) in m/s."""
    return {name: modes(over_speed(system), speeds) for name, system in systems(**given).items()}


def chart(found: dict[str, Modes]) -> Chart:
    """Root loci of the four, and the growth of weave over speed."""
    colours = dict(zip(found, SEQUENCE, strict=False))
    loci, growth = [], []
    for name, one in found.items():
        inside = (one.eigenvalues.real > -20) & (one.eigenvalues.imag >= 0) & (one.eigenvalues.imag < 24 * np.pi)
        roots, speed = one.eigenvalues[inside], np.broadcast_to(one.speed[:, None], inside.shape)[inside]
        loci.append(
            Curve(
                NAMES[name],
                roots.real,
                roots.imag / (2 * np.pi),
                colours[name],
                "points",
                size=3,
                text=[f"{v:g} m/s" for v in speed],
            )
        )
        growth.append(Curve(NAMES[name], one.speed, one["weave"].eigenvalue.real, colours[name]))
    return Chart(
        [
            Panel(
                Axis("real part", "1/s", low=-20, high=3),
                Axis("frequency", "Hz", low=0, high=12),
                loci,
                shades=[Shade(0, 3, "unstable")],
                hover="point",
                height=380,
            ),
            Panel(
                Axis("speed", "m/s"),
                Axis("real part of weave", "1/s", low=-6, high=2),
                growth,
                shades=[Shade(0, 2, "unstable", across="y")],
                height=380,
            ),
        ],
        columns=2,
    )


def section(found: dict[str, Modes]) -> Section:
    """What leaning does, with numbers."""

    def bands(mode: str) -> str:
        each = {
            name: ", ".join(f"{a:.1f} to {b:.1f}" for a, b in one.unstable[mode]) or "nowhere"
            for name, one in found.items()
        }
        return "; ".join(f"{NAMES[name]} {band}" for name, band in each.items())

    first, last = found["rigid"].speed[[0, -1]]
    text = [f"Between {first:g} and {last:g} m/s weave is unstable at these speeds [m/s]: {bands('weave')}.",
            "A rider who leans on springs removes the instability that turning with the handlebar causes at high speed: the "
            "body follows the roll of weave with a lag, and saddle and waist dissipate. This answers the further "
            "developments of the 2011 paper (Sect. 5) for a rider whose joints meet every printed feature of the 2008 roll "
            "test; the features do not determine the rider.",
            f"Wobble is unstable at these speeds [m/s]: {bands('wobble')}. Lean changes it little; the rider's arms damp it."]  # fmt: skip
    at = [v for v in (5, 10, 15, 20, 30, 40, 50, 60) if first <= v <= last]
    tables = [Table(["rider", *(f"{v} m/s" for v in at)],
                    [[NAMES[name], *(_cell(one, mode, v) for v in at)] for name, one in found.items()],
                    f"{mode.capitalize()}: real part [1/s], frequency [Hz]")
              for mode in ("weave", "wobble")]  # fmt: skip
    return Section(
        "What does lean do to weave?",
        text,
        [
            (
                chart(found),
                f"Root loci from {first:g} to {last:g} m/s, and the real part of weave (the step near 9 m/s: weave and "
                "the lean mode exchange their mode shapes)",
            )
        ],
        tables,
    )


def _cell(one: Modes, mode: str, speed: float) -> str:
    value = one[mode].eigenvalue[np.argmin(np.abs(one.speed - speed))]
    return f"{value.real:+.2f}, {value.imag / (2 * np.pi):.2f}"
