"""What moves in each mode? Phasors of the mean rider on the reference motorcycle (2011, Figs 8 to 13)."""

import numpy as np
from matplotlib.figure import Figure

from motofmi.reports.figures import new_figure
from motofmi.reports.report import Section
from motofmi.workflows.scenarios import InReport
from rider_fmu import riders
from vehicle_fmu import modes, motorcycles, over_speed, ridden

REPORT = InReport("tour", 20, "mode phasors")

PAPER = [("weave", 30, "Fig. 8"), ("weave", 50, "Fig. 9"), ("wobble", 1, "Fig. 10"), ("wobble", 60, "Fig. 11"),
         ("rider_wobble", 1, "Fig. 12"), ("rider_wobble", 60, "Fig. 13")]  # fmt: skip
ARROWS = {"steer": "#c00000", "torso": "#0b5394", "roll": "#38761d", "yaw": "#7f6000", "lateral": "#888888"}


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


def figure(found: list) -> Figure:
    """Six phasor diagrams, each scaled to its longest arrow."""
    picture, axes = new_figure(3, 2, width=10, height=6.6)
    for ax, (mode, speed, title, value, motion) in zip(axes.flat, found, strict=True):
        longest = max(abs(z) for z in motion.values())
        for name, z in motion.items():
            tip = z / longest
            ax.annotate(
                "",
                (tip.real, tip.imag),
                (0, 0),
                arrowprops={"arrowstyle": "-|>", "color": ARROWS[name], "linewidth": 1.6},
            )
            if abs(tip) > 0.05:
                ax.text(1.1 * tip.real, 1.1 * tip.imag, name, color=ARROWS[name], fontsize=8, ha="center", va="center")
        ax.set(
            xlim=(-1.25, 1.25), ylim=(-1.25, 1.25), aspect="equal", xlabel="real part [1]", ylabel="imaginary part [1]"
        )
        ax.set_title(f"{title}: {mode.replace('_', '-')}, {speed:g} m/s, {value.imag / 2 / np.pi:.2f} Hz", fontsize=9)
    return picture


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
        [(figure(found), "Mode phasors of the mean rider on the reference motorcycle (2011, Figs 8 to 13)")],
    )
