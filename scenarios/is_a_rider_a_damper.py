"""Is a rider a damper? Transfer functions from steer angle to the torques on bar and frame (2011, Fig. 6)."""

import numpy as np

from motofmi.reports.charts import Axis, Chart, Curve, Panel
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


def chart(found: dict[str, TransferFunctions]) -> Chart:
    """Amplitude and phase over frequency, in the paper's sign: positive where the torque resists the steer."""
    rider = found["rider"]
    drawn = [
        ("rider: on the bar", -rider["handlebar_torque"], "found", "line"),
        ("rider: on the frame", rider["frame_torque"], "found", "dashed"),
    ]
    for name, colour in zip(DAMPERS, ("fifth", "base", "fourth"), strict=True):
        drawn.append(
            (
                f"damper of {dampers.load(name).values['damping']:g} N.m.s/rad",
                -found[name]["handlebar_torque"],
                colour,
                "line",
            )
        )
    frequency = Axis("frequency", "Hz", log=True)
    return Chart(
        [
            Panel(
                frequency,
                Axis("torque per steer angle", "N.m/rad", log=True),
                [Curve(n, FREQUENCY, np.abs(z), c, s) for n, z, c, s in drawn],
            ),
            Panel(
                frequency,
                Axis("phase", "deg", low=-50, high=200),
                [Curve(n, FREQUENCY, np.degrees(np.angle(z)), c, s) for n, z, c, s in drawn],
            ),
        ],
        columns=2,
        linked=True,
    )


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
        [(chart(found), "Transfer functions of the mean rider and three dampers (2011, Fig. 6)")],
    )
