"""What does lean do to weave? Root loci with no moving rider, one who turns, one who leans, and one who does both.

The rider in roll takes his part of the rigid rider out of the motorcycle and brings it himself (pelvis, torso, head
on springs); the turning rider is the mean rider of 2011. The 2011 paper (Sect. 5) leaves the rider's roll to further
developments of its model.
"""

import numpy as np
from matplotlib.figure import Figure

from fmus.component import Component
from fmus.linear import linearise
from fmus.modes import crossings, follow
from fmus.system import System
from rider_fmu import riders
from rider_fmu.anthropometry import roll_values
from rider_fmu.rider_in_roll import rigid_body
from scenarios.report import Section, Table, new_figure
from vehicle_fmu import motorcycles
from vehicle_fmu.lightened import lightened

SPEEDS = np.arange(15.0, 60.1, 0.5)  # m/s; slower, weave and the modes of the lean exchange character and no name holds
SADDLE_HEIGHT = 0.75  # m above the ground; the simulator's roll axis is not the ground
HEIGHT, MASS = 1.76, 72.0  # m, kg: a rider of the size of Sharp's
NAMES = {"rigid": "no moving rider", "turning": "turning rider", "leaning": "leaning rider", "both": "turning and leaning"}
ROLL_MODES = 2.2  # Hz: below are the rider's own modes in roll, above weave and wobble at the naming speed
NAMING_SPEED = 40.0  # m/s


def leaning_rider(rider: str = "roll_3_2008") -> Component:
    """The rider in roll with his joints, on the motorcycle's saddle, of the size of Sharp's rider."""
    return riders.load(rider).with_values(**roll_values(HEIGHT, MASS), saddle_height=SADDLE_HEIGHT)


def systems(vehicle: str = "sharp_1971", turning: str = "mean_2011", leaning: Component | None = None) -> dict[str, System]:
    """The four systems by name."""
    whole, device, rider = motorcycles.load(vehicle), riders.load(turning), leaning or leaning_rider()
    bare = lightened(whole, *rigid_body(rider))
    bound = {"vehicle.added_steer_inertia": "device.port_inertia"}
    return {"rigid": System("rigid", {"vehicle": whole}), "turning": System("turning", {"vehicle": whole, "device": device}, bindings=bound),
            "leaning": System("leaning", {"vehicle": bare, "rider": rider}),
            "both": System("both", {"vehicle": bare, "device": device, "rider": rider}, bindings=bound)}  # fmt: skip


def run(speeds: np.ndarray = SPEEDS, **given) -> dict[str, dict]:
    """For each system: speed (n,), eigenvalues (n, nx), weave (n,) [1/s], and `unstable`, weave's bands [from, to] in m/s."""
    return {name: weave_of(system, speeds) for name, system in systems(**given).items()}


def weave_of(system: System, speeds: np.ndarray) -> dict:
    """The weave of a system: at 40 m/s the slowest oscillation above the rider's own in roll, followed from there."""

    def matrices(v: np.ndarray) -> np.ndarray:
        return linearise(system, **{"vehicle.speed": v}).A

    branches = follow(matrices, speeds)
    at = branches.at(np.array([NAMING_SPEED]))[0]
    frequency = np.where(at.imag > 2 * np.pi * ROLL_MODES, at.imag, np.inf)
    column = int(np.argmin(frequency))
    weave = branches.eigenvalues[:, column]
    weave = weave.real + 1j * np.abs(weave.imag)
    return {"speed": speeds, "eigenvalues": branches.at(speeds), "weave": weave[np.searchsorted(branches.parameter, speeds - 1e-9)],
            "unstable": crossings(matrices, branches.parameter, weave.real)}  # fmt: skip


def figure(found: dict[str, dict]) -> Figure:
    """Root loci of the four, and the growth of weave over speed."""
    picture, (locus, growth) = new_figure(2, 1, width=11, height=4.6)
    for name, one in found.items():
        roots = one["eigenvalues"]
        locus.plot(roots.real.ravel(), roots.imag.ravel() / (2 * np.pi), ".", markersize=2, label=NAMES[name])
        growth.plot(one["speed"], one["weave"].real, label=NAMES[name])
    growth.axhline(0, color="k", linewidth=0.6)
    locus.set(xlabel="real part [1/s]", ylabel="frequency [Hz]", xlim=(-20, 3), ylim=(0, 12))
    growth.set(xlabel="speed [m/s]", ylabel="real part of weave [1/s]", ylim=(-6, 2))
    growth.legend(fontsize=8)
    return picture


def section(found: dict[str, dict]) -> Section:
    """What leaning does, with numbers."""

    def bands(name: str) -> str:
        return ", ".join(f"{a:.1f} to {b:.1f} m/s" for a, b in found[name]["unstable"]) or "nowhere"

    text = ("A rider who turns with the bar makes weave unstable at speed (" + bands("turning") + "). One who leans on springs moderates it: "
            "on the same motorcycle leaning alone leaves it unstable " + bands("leaning") + ", and turning and leaning together " + bands("both")
            + ". The lean's joints are those of a rider who meets every printed feature of the 2008 roll test; the features do not single him out.")  # fmt: skip
    at = [15, 20, 30, 40, 50, 60]
    rows = [[NAMES[name], *(_cell(one, v) for v in at)] for name, one in found.items()]
    return Section("What does lean do to weave?", [text], [(figure(found), "Root loci from 15 to 60 m/s, and the real part of weave")],
                   [Table(["rider", *(f"{v} m/s" for v in at)], rows, "Weave: real part [1/s], frequency [Hz]")])  # fmt: skip


def _cell(one: dict, speed: float) -> str:
    value = one["weave"][np.argmin(np.abs(one["speed"] - speed))]
    return f"{value.real:+.2f}, {value.imag / (2 * np.pi):.2f}"
