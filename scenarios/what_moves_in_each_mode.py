"""What moves in each mode? Phasors of the mean rider on the reference motorcycle (2011, Figs 8 to 13)."""

import numpy as np

from motofmi.reports.charts import Axis, Chart, Curve, Panel
from motofmi.reports.report import Section
from motofmi.workflows.scenarios import InReport
from rider_fmu import riders
from vehicle_fmu import modes, motorcycles, over_speed, ridden

REPORT = InReport("tour", 20, "mode phasors")

PAPER = [("weave", 30, "Fig. 8"), ("weave", 50, "Fig. 9"), ("wobble", 1, "Fig. 10"), ("wobble", 60, "Fig. 11"),
         ("rider_wobble", 1, "Fig. 12"), ("rider_wobble", 60, "Fig. 13")]  # fmt: skip
ARROWS = {"steer": "significant", "torso": "found", "roll": "changed", "yaw": "fifth", "lateral": "measured"}


def phasors(
    mode: str, speed: float, vehicle: str = "reference_2011", rider: str = "mean_2011"
) -> tuple[complex, dict[str, complex]]:
    """The eigenvalue [1/s] and the phasors of steer, torso, roll, yaw [rad] and lateral position [m], steer = 1."""
    linearised = over_speed(ridden(motorcycles.load(vehicle), riders.load(rider)))
    wanted = modes(linearised, np.array([speed]))[mode].eigenvalue[0]
    space = linearised(np.array([float(speed)]))
    values, vectors = np.linalg.eig(space.A[0])
    k = int(np.argmin(np.abs(values - wanted)))
    moves = dict(zip(space.outputs, space.C[0] @ vectors[:, k], strict=True))
    yaw = moves["vehicle.yaw_rate"] / values[k]
    motion = {
        "steer": moves["vehicle.steer_angle"],
        "torso": moves["device.torso_angle"],
        "roll": moves["vehicle.roll_angle"],
        "yaw": yaw,
        "lateral": (moves["vehicle.lateral_velocity"] + speed * yaw) / values[k],
    }
    return complex(values[k]), {name: complex(value / motion["steer"]) for name, value in motion.items()}


def run() -> list[tuple[str, float, str, complex, dict[str, complex]]]:
    """(mode, speed [m/s], the paper's figure, eigenvalue, phasors) for the paper's six."""
    return [(mode, speed, title, *phasors(mode, speed)) for mode, speed, title in PAPER]


def chart(found: list) -> Chart:
    """Six phasor diagrams, each scaled to its longest arrow."""
    panels = []
    for mode, speed, title, value, motion in found:
        longest = max(abs(z) for z in motion.values())
        arrows = [Curve(name, [z.real / longest], [z.imag / longest], ARROWS[name], "needles",
                        text=[f"{abs(z):.3g} at {np.degrees(np.angle(z)):.0f} deg, relative to steer"])
                  for name, z in motion.items()]  # fmt: skip
        label = f"{title}: {mode.replace('_', '-')}, {speed:g} m/s, {value.imag / 2 / np.pi:.2f} Hz"
        panels.append(
            Panel(
                Axis("real part, over the longest", "1", low=-1.0, high=1.0),
                Axis("imaginary part, over the longest", "1", low=-1.0, high=1.0),
                arrows,
                label,
                hover="point",
                square=True,
                height=290,
            )
        )
    return Chart(panels, columns=3)


def section(found: list) -> Section:
    """The phasors, with the phase between torso and bar that separates wobble from rider-wobble."""
    phases = "; ".join(f"{mode.replace('_', '-')} at {speed:g} m/s {np.degrees(np.angle(motion['torso'])):.0f} deg"
                       for mode, speed, _, _, motion in found)  # fmt: skip
    text = ("Lengths are relative to the longest arrow, angles in rad against lateral position in m. In wobble the "
            "torso turns "
            "against the bar, in rider-wobble with it. Phase of the torso relative to the steer: "
            f"{phases}.")  # fmt: skip
    return Section(
        "What moves in each mode?",
        [text],
        [(chart(found), "Mode phasors of the mean rider on the reference motorcycle (2011, Figs 8 to 13)")],
    )
