"""What does the passive rider do to weave in a corner? The touring motorcycle of 2020 in steady turning, by speed and
lean angle.

Weave and wobble with the hands off and with the mean rider of 2011, followed from straight running over the lean
angle. The rider holds the corner with his muscles; his passive body acts on what deviates from it.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from motofmi.reports.charts import SEQUENCE, Axis, Chart, Curve, Line, Panel
from motofmi.reports.report import Section, Table
from motofmi.workflows.trim import Trim, trim

SPEEDS = (10.0, 20.0, 30.0, 40.0, 50.0)  # m/s
LEANS = np.arange(0.0, 46.0, 15.0)  # deg
OFF, RIDER = "hands off", "mean rider"
DEVICES = {OFF: None, RIDER: "rider:mean_2011"}
MODES = ("weave", "wobble")


def run(
    speeds: Sequence[float] = SPEEDS, leans: np.ndarray = LEANS, vehicle: str = "tum_2020"
) -> dict[tuple[str, float], Trim]:
    """Steady turning by what is at the handlebar and speed [m/s], over lean angles (n,) [deg]."""
    return {
        (words, speed): trim(vehicle, device, speed=speed, lean=leans)
        for words, device in DEVICES.items()
        for speed in speeds
    }


def answer(found: Mapping[tuple[str, float], Trim]) -> str:
    """The answer in sentences, from the numbers."""
    lines = []
    for mode in MODES:
        added = {
            speed: found[RIDER, speed][mode].eigenvalue.real - found[OFF, speed][mode].eigenvalue.real
            for words, speed in found
            if words == RIDER
        }
        upright, leant = ([each[k] for each in added.values()] for k in (0, -1))
        lines.append(
            f"The rider changes the real part of {mode} by {min(upright):+.2f} to {max(upright):+.2f} 1/s upright and by "
            f"{min(leant):+.2f} to {max(leant):+.2f} 1/s at {_last(found):g} deg of lean."
        )
    for words in DEVICES:
        unstable = [
            f"at {speed:g} m/s and {', '.join(f'{lean:g}' for lean in one.lean[one['weave'].eigenvalue.real > 0])} deg"
            for (each, speed), one in found.items()
            if each == words and (one["weave"].eigenvalue.real > 0).any()
        ]
        lines.append(
            f"With {words} weave is unstable {'; '.join(unstable)}."
            if unstable
            else f"With {words} weave is stable throughout."
        )
    return " ".join(lines)


def table(found: Mapping[tuple[str, float], Trim]) -> Table:
    """Weave and wobble by speed and what is at the handlebar, over the lean angle."""
    leans = next(iter(found.values())).lean
    rows = [
        [f"{speed:g} m/s", words, mode, *map(_eigenvalue, one[mode].eigenvalue)]
        for (words, speed), one in sorted(found.items(), key=lambda each: each[0][1])
        for mode in MODES
    ]
    return Table(
        ["speed", "at the handlebar", "mode", *(f"{lean:g} deg" for lean in leans)],
        rows,
        "Real part [1/s] and damped frequency [Hz] over the lean angle",
    )


def equilibria(found: Mapping[tuple[str, float], Trim]) -> Table:
    """The equilibria with the hands off at the largest lean angle."""
    rows = [
        [
            f"{speed:g} m/s",
            f"{one['lateral_acceleration'][-1]:.2f}",
            f"{np.degrees(one['steer_angle'][-1]):.2f}",
            f"{one['steer_torque'][-1]:.1f}",
            *(f"{np.degrees(one[f'{end}_slip_angle'][-1]):.2f}" for end in ("front", "rear")),
            f"{max(one['front_grip_used'][-1], one['rear_grip_used'][-1]):.0%}",
        ]
        for (words, speed), one in found.items()
        if words == OFF
    ]
    return Table(
        [
            "speed",
            "lateral acceleration [m/s2]",
            "steer angle [deg]",
            "steer torque [N.m]",
            "front slip angle [deg]",
            "rear slip angle [deg]",
            "grip used",
        ],
        rows,
        f"Steady turning at {_last(found):g} deg of lean",
    )


def chart(found: Mapping[tuple[str, float], Trim]) -> Chart:
    """The real parts of weave and wobble over the lean angle."""
    speeds = list(dict.fromkeys(speed for _, speed in found))
    panels = []
    for mode in MODES:
        curves = [
            Curve(
                f"{words}, {speed:g} m/s",
                one.lean,
                one[mode].eigenvalue.real,
                SEQUENCE[speeds.index(speed) % len(SEQUENCE)],
                "line" if words == OFF else "dashed",
            )
            for (words, speed), one in found.items()
        ]
        panels.append(
            Panel(Axis("lean angle", "deg"), Axis(f"real part of {mode}", "1/s"), curves, lines=[Line(0)], height=380)
        )
    return Chart(panels, columns=2)


def section(found: Mapping[tuple[str, float], Trim]) -> Section:
    """The answer: sentences, figure and tables."""
    return Section(
        "What does the passive rider do to weave in a corner?",
        [answer(found)],
        [(chart(found), "Hands off and with the passive rider")],
        [table(found), equilibria(found)],
    )


def _last(found: Mapping[tuple[str, float], Trim]) -> float:
    return float(next(iter(found.values())).lean[-1])


def _eigenvalue(value: complex) -> str:
    return "none named" if np.isnan(value) else f"{value.real:+.2f}, {value.imag / (2 * np.pi):.2f}"
