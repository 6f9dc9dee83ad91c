"""Is a rider a damper? Transfer functions from steer angle to the torques on bar and frame (2011, Fig. 6)."""

import numpy as np
from matplotlib.figure import Figure

from motofmi.reports.figures import COLOURS, new_figure
from motofmi.reports.report import Section
from motofmi.workflows.device import TransferFunctions, transfer_functions
from motofmi.workflows.scenarios import InReport
from rider_fmu import riders
from vehicle_fmu import dampers

REPORT = InReport("tour", 30, "transfer functions of rider and dampers")

FREQUENCY = np.geomspace(0.1, 20, 400)  # Hz
DAMPERS = ("low_2011", "medium_2011", "high_2011")


def run(rider: str = "mean_2011") -> dict[str, TransferFunctions]:
    """Torque per steer angle [N.m/rad], complex (400,), of the rider and the paper's three dampers."""
    found = {"rider": transfer_functions(riders.load(rider), FREQUENCY)}
    for name in DAMPERS:
        found[name] = transfer_functions(dampers.load(name), FREQUENCY)
    return found


def figure(found: dict[str, TransferFunctions]) -> Figure:
    """Amplitude and phase over frequency, in the paper's sign: positive where the torque resists the steer."""
    picture, (amplitude, phase) = new_figure(2, 1, width=10, height=4.4)
    curves = [
        ("handlebar_torque", -1, "rider: on the bar", COLOURS["rider"], "-"),
        ("frame_torque", 1, "rider: on the frame", COLOURS["rider"], "--"),
    ]
    for torque, sign, label, colour, style in curves:
        response = sign * found["rider"][torque]
        amplitude.loglog(FREQUENCY, np.abs(response), style, color=colour, label=label)
        phase.semilogx(FREQUENCY, np.degrees(np.angle(response)), style, color=colour)
    for name, style in zip(DAMPERS, (":", "-.", "-"), strict=True):
        response = -found[name]["handlebar_torque"]
        value = dampers.load(name).values["damping"]
        amplitude.loglog(
            FREQUENCY, np.abs(response), style, color=COLOURS["damper"], label=f"damper of {value:g} N.m.s/rad"
        )
        phase.semilogx(FREQUENCY, np.degrees(np.angle(response)), style, color=COLOURS["damper"])
    amplitude.set(xlabel="frequency [Hz]", ylabel="torque per steer angle [N.m/rad]")
    phase.set(xlabel="frequency [Hz]", ylabel="phase [deg]", ylim=(-60, 185), yticks=range(-45, 181, 45))
    amplitude.legend(fontsize=8)
    return picture


def section(found: dict[str, TransferFunctions]) -> Section:
    """The transfer functions, and where the rider stops being a damper."""
    difference = np.abs(found["rider"]["handlebar_torque"] + found["rider"]["frame_torque"]) / np.abs(
        found["rider"]["handlebar_torque"]
    )
    limit = FREQUENCY[np.argmax(difference > 0.5)]
    text = ("A damper pushes bar and frame with equal and opposite torques. A rider does not, because the torso has "
            "inertia: "
            f"from {limit:.1f} Hz on, the sum of the two exceeds half of the torque on the bar. Shown in the sense "
            "in which the device resists the steer, as the paper draws it.")  # fmt: skip
    return Section(
        "Is a rider a damper?",
        [text],
        [(figure(found), "Transfer functions of the mean rider and three dampers (2011, Fig. 6)")],
    )
