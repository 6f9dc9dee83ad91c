"""What if the rider is swapped for a damper? Three FMUs with one port, at a speed where it decides the weave.

The motorcycle's FMU runs at 50 m/s with the rider's FMU, whose weave grows (2011, Fig. 7). Half-way the rider's FMU is
taken off the port and the damper's FMU put on; the motorcycle goes on from where it was. Beside it the run in which
the rider stays.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fmus.cosimulation.cosimulate import CosimulationRun, cosimulate
from fmus.cosimulation.coupling_error import Prediction
from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem
from fmus.declaration.component import Component
from fmus.export.build import build
from motofmi.reports.charts import Axis, Chart, Curve, Line, Panel
from motofmi.reports.report import Section, Table
from motofmi.workflows.scenarios import InReport
from rider_fmu import riders
from vehicle_fmu import LinearDamper, modes, motorcycles, over_speed, ridden

REPORT = InReport("tour", 40, "FMUs built, co-simulated, rider swapped for damper")

SPEED, STEP, HALF = 50.0, 0.001, 8.0  # m/s, s, s
START = {"steer_rate": 0.1}  # rad/s
ADDED_DAMPING = 7.5  # N.m.s/rad


@dataclass(frozen=True)
class Swap:
    """The run with the rider, what follows with him, what follows with the damper; exact weaves [1/s]; the FMUs, the
    rows as CSV."""

    before: CosimulationRun
    stays: CosimulationRun
    swapped: CosimulationRun
    weave: dict[str, complex]
    fmus: list[Path]
    rows: list[Path]


def run(out: Path) -> Swap:
    """Build the three FMUs into `out`, run them, and write the runs as CSV beside them."""
    vehicle, rider = motorcycles.load("reference_2011"), riders.load("mean_2011")
    damper = LinearDamper("damper_7_5", "2011, Fig. 14", damping=ADDED_DAMPING)
    fmus = {component.name: build(component, out).path for component in (vehicle, rider, damper)}

    def together(device: Component, name: str, motion: dict[str, float], posture: dict[str, float]) -> CosimulationRun:
        # The mean rider's inertia at the port is zero, so that nothing of the vehicle changes with the device.
        subsystems = {"vehicle": FmuSubsystem(fmus[vehicle.name], values={"speed": SPEED, **motion}),
                 "device": FmuSubsystem(fmus[device.name], values=posture)}  # fmt: skip
        done = cosimulate(subsystems, STEP, HALF)
        np.savetxt(out / f"{name}.csv", done.rows, "%.9g", ",", header=",".join(done.columns), comments="")
        return done

    before = together(rider, "with_the_rider", START, {})
    motion = {name: float(before[f"vehicle.{name}"][-1]) for name in vehicle.states}
    posture = {"torso_angle": float(before["device.torso_angle"][-1]),
               "torso_momentum": float(before["device.torso_rate"][-1]) * rider.values["torso_inertia"]}  # fmt: skip
    stays, swapped = (
        together(rider, "the_rider_stays", motion, posture),
        together(damper, "swapped_for_the_damper", motion, {}),
    )
    weave = {device.name: complex(modes(over_speed(ridden(vehicle, device)), np.array([SPEED]))["weave"].eigenvalue[0])
             for device in (rider, damper)}  # fmt: skip
    rows = [out / f"{name}.csv" for name in ("with_the_rider", "the_rider_stays", "swapped_for_the_damper")]
    return Swap(before, stays, swapped, weave, list(fmus.values()), rows)


def chart(swap: Swap) -> Chart:
    """Steer angle and torque on the bar over time, with the swap."""
    time = swap.before["time"]
    parts = [
        (swap.before, 0.0, "found", "line", "rider's FMU"),
        (swap.stays, HALF, "measured", "dotted", "had the rider stayed"),
        (swap.swapped, HALF, "base", "line", "damper's FMU"),
    ]
    angle = [
        Curve(label, time + offset, np.degrees(part["vehicle.steer_angle"]), colour, style, width=1.2)
        for part, offset, colour, style, label in parts
    ]
    torque = [
        Curve(label, time + offset, part["device.handlebar_torque"], colour, style, width=1.2)
        for part, offset, colour, style, label in parts
    ]
    exchanged = [Line(HALF, "FMUs exchanged", across="x")]
    return Chart(
        [
            Panel(Axis("time", "s"), Axis("steer angle", "deg"), angle, lines=exchanged, height=250),
            Panel(Axis("time", "s"), Axis("torque on the bar", "N.m"), torque, lines=exchanged, height=250),
        ],
        linked=True,
    )


def section(swap: Swap) -> Section:
    """What happens to the weave, and how far the coupling can be trusted."""
    growth = {name: value.real for name, value in swap.weave.items()}
    after = [
        f"{np.abs(np.degrees(part['vehicle.steer_angle'][-1000:])).max():.3g} deg"
        for part in (swap.stays, swap.swapped)
    ]
    text = (f"At {SPEED:g} m/s the weave grows with the rider (real part {growth['rider_mean_2011']:+.3f} 1/s) and "
            f"decays with the damper ({growth['damper_7_5']:+.3f} 1/s). {HALF:g} s after the swap the steer angle is "
            f"within {after[1]}; had the rider stayed, within {after[0]}.")  # fmt: skip
    rows = [[name, part.coupling, f"{part.step:g}", f"{part.steps_per_second:.0f}", f"{part.power_residual:.2g}",
             _errors(part.predicted)]
            for name, part in (("rider", swap.before), ("damper", swap.swapped))]  # fmt: skip
    table = Table(("device", "coupling", "step [s]", "steps per second", "largest residual power [W]",
                   "predicted relative error of each mode's frequency and damping "
                   "ratio"), rows, "How the FMUs were coupled")  # fmt: skip
    files = [*((path, "FMU") for path in swap.fmus), *((path, "rows of the co-simulation") for path in swap.rows)]
    return Section("What if the rider is swapped for a damper?", [text],
                   [(chart(swap), f"{2 * HALF:g} s at {SPEED:g} m/s; the FMUs are exchanged at {HALF:g} "
                                   "s")], [table], files=files)  # fmt: skip


def _errors(predicted: Prediction | None) -> str:
    """The predicted errors of the oscillatory modes in words."""
    if predicted is None:
        return "not known"
    return "; ".join(f"{value.imag / 2 / np.pi:.2f} Hz: {frequency:+.0e}, "
                     f"{damping:+.0e}" for value, frequency, damping, swings
                     in zip(predicted.exact, predicted.frequency_error, predicted.damping_error, predicted.oscillatory,
                            strict=True)
                     if swings)  # fmt: skip
