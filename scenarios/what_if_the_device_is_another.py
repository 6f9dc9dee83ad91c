"""What if the device is another? The same motorcycle and wiring with a rider, dampers, an
inerter, a rider and a damper.

Every device is an FMU with the same port. Torques of several devices add up. The modes are those of the linearised
FMUs coupled without error; the time histories begin with the same jump of the steer rate.
"""

from dataclasses import dataclass

import numpy as np

from fmus.cosimulation.cosimulate import CosimulationRun, cosimulate, join
from fmus.cosimulation.network import Network
from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem
from fmus.declaration.component import Component
from fmus.export.build import build
from fmus.linear_analysis.participation import participation
from motofmi.reports.charts import Axis, Chart, Curve, Panel
from motofmi.reports.report import Section, Table
from rider_fmu import riders
from vehicle_fmu import LinearDamper, dampers, motorcycles

SPEED, DURATION, STEP = 50.0, 2.0, 2e-3  # m/s, s, s
START = {"steer_rate": 0.5}  # rad/s


@dataclass(frozen=True)
class Answer:
    """The run, and the oscillatory eigenvalues [1/s] with each subsystem's share in them."""

    run: CosimulationRun
    eigenvalues: np.ndarray
    shares: dict[str, np.ndarray]


def devices() -> dict[str, list[Component]]:
    """What is held at the handlebar, by name."""
    rider, damper = riders.load("mean_2011"), LinearDamper("damper_7_5", "2011, Fig. 14", damping=7.5)
    return {"nothing": [], "rider": [rider], "damper": [damper], "progressive damper": [dampers.load("progressive")],
            "inerter": [dampers.load("inerter")], "rider and damper": [rider, damper]}  # fmt: skip


def run(folder: str) -> dict[str, Answer]:
    """Each device on the motorcycle; the FMUs are built into a folder."""
    vehicle, found = build(motorcycles.load("reference_2011"), folder).path, {}
    for name, held in devices().items():
        # The mean rider's inertia at the port is zero: nothing of the motorcycle changes with the device.
        subsystems = {"vehicle": FmuSubsystem(vehicle, "vehicle", {"speed": SPEED, **START})}
        subsystems |= {
            component.name: FmuSubsystem(build(component, folder).path, component.name) for component in held
        }
        eigenvalues, shares = participation(Network(subsystems, join(subsystems)).linearised())
        swings = eigenvalues.imag > 1e-9 * np.abs(eigenvalues)
        found[name] = Answer(
            cosimulate(subsystems, STEP, DURATION),
            eigenvalues[swings],
            {subsystem: share[swings] for subsystem, share in shares.items()},
        )
        for subsystem in subsystems.values():
            subsystem.close()
    return found


def chart(found: dict[str, Answer]) -> Chart:
    """Steer angle over time, one panel for each device."""
    return Chart(
        [
            Panel(
                Axis("time", "s"),
                Axis("steer angle", "deg"),
                [Curve("steer angle", a.run["time"], np.degrees(a.run["vehicle.steer_angle"]), "found")],
                name,
                height=220,
            )
            for name, a in found.items()
        ],
        columns=3,
        linked=True,
    )


def section(found: dict[str, Answer]) -> Section:
    """The histories side by side and the modes in a table."""
    rows = []
    for name, answer in found.items():
        for k, value in enumerate(answer.eigenvalues):
            held = abs(1.0 - answer.shares["vehicle"][k])
            rows.append(
                [name, f"{value.imag / (2 * np.pi):.2f}", f"{-value.real / abs(value):.3f}", f"{100 * held:.0f}"]
            )
    text = (
        f"The motorcycle at {SPEED:g} m/s after a jump of the steer rate of {START['steer_rate']:g} rad/s, with what "
        "is held at its handlebar exchanged."
    )
    table = Table(
        ["device", "frequency [Hz]", "damping ratio", "share of the device in the mode [%]"], rows, "Oscillatory modes"
    )
    return Section("What if the device is another?", [text], [(chart(found), "Steer angle with each device")], [table])
