"""Is a passive rider like the hands of Sharp (1994), a spring and a damper between handlebar and frame?

The motorcycle of 1994 with its hands off, with its own hands (stiffness, damping and inertia of the steer), with the
passive rider of 2011, and with the same rider whose torso has hardly any inertia. The last one is arms and waist in
series, springs and dampers between bar and frame: what is different with the rider is the inertia of his torso.
"""

import numpy as np

from fmus.composition.system import System
from motofmi.reports.charts import SEQUENCE, Axis, Chart, Curve, Panel, Shade
from motofmi.reports.report import Section, Table
from rider_fmu import riders
from vehicle_fmu import Modes, modes, motorcycles, over_speed, ridden

SPEEDS = np.arange(10.0, 60.25, 1.0)  # m/s
OFF, HANDS, LIGHT, RIDER = "hands off", "Sharp's hands", "rider without the inertia of his torso", "passive rider"
LIGHT_TORSO = 1e-2  # of his inertia


def systems(vehicle: str = "sharp_1994", rider: str = "mean_2011") -> dict[str, System]:
    """The four systems by words."""
    motorcycle, device = motorcycles.load(vehicle), riders.load(rider)
    light = device.with_values(torso_inertia=LIGHT_TORSO * device.values["torso_inertia"])
    return {OFF: ridden(motorcycle), HANDS: ridden(motorcycle.with_values(hands_on=1.0)), LIGHT: ridden(motorcycle, light),
            RIDER: ridden(motorcycle, device)}  # fmt: skip


def run(speeds: np.ndarray = SPEEDS, **given: str) -> dict[str, Modes]:
    """The modes of each system over speeds (n,) in m/s."""
    return {words: modes(over_speed(system), speeds) for words, system in systems(**given).items()}


def changes(found: dict[str, Modes], mode: str) -> dict[str, float]:
    """The mean change of a mode's real part over speed against hands off [1/s], by words."""
    off = found[OFF][mode].eigenvalue.real
    return {words: float(np.nanmean(one[mode].eigenvalue.real - off)) for words, one in found.items() if words != OFF}


def chart(found: dict[str, Modes]) -> Chart:
    """Real parts of weave and wobble over speed."""
    panels = []
    for mode, low in (("weave", -8.0), ("wobble", -40.0)):
        curves = [Curve(words, one.speed, one[mode].eigenvalue.real, SEQUENCE[k])
                  for k, (words, one) in enumerate(found.items())]  # fmt: skip
        axes = Axis("speed", "m/s"), Axis(f"real part of {mode}", "1/s", low=low, high=5.0)
        panels.append(Panel(*axes, curves, shades=[Shade(0.0, 5.0, "unstable", across="y")]))
    return Chart(panels, columns=2)


def section(found: dict[str, Modes]) -> Section:
    """What each does to weave and wobble."""
    change = {mode: changes(found, mode) for mode in ("weave", "wobble")}
    text = [f"{words[0].upper()}{words[1:]}: the real part of weave changes by {change['weave'][words]:+.2f} 1/s, that of wobble by "
            f"{change['wobble'][words]:+.2f} 1/s, in the mean over speed." for words in change["weave"]]  # fmt: skip
    speed = next(iter(found.values())).speed
    places = [(mode, k) for mode in ("weave", "wobble") for k in (len(speed) // 4, 3 * len(speed) // 4)]
    rows = [[words, *(_cell(one[mode].eigenvalue[k]) for mode, k in places)] for words, one in found.items()]
    table = Table(["at the handlebar", *(f"{mode} at {speed[k]:g} m/s" for mode, k in places)], rows,
                  "Real part [1/s] and damped frequency [Hz]")  # fmt: skip
    return Section("Is a passive rider like Sharp's hands?", text, [(chart(found), "Real parts over speed.")], [table])


def _cell(value: complex) -> str:
    return "none named" if np.isnan(value) else f"{value.real:+.2f}, {value.imag / (2 * np.pi):.2f}"
