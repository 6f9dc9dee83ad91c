"""The FMUs of a vehicle and of devices at its ports, co-simulated; and one FMU simulated by itself."""

import tempfile
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fmus.cosimulation.cosimulate import TOLERANCE, join
from fmus.cosimulation.cosimulate import cosimulate as run_together
from fmus.cosimulation.cosimulation_run import CosimulationRun
from fmus.cosimulation.coupling import coupling as coupling_of
from fmus.cosimulation.coupling_error import largest_stable_step, linear_network
from fmus.cosimulation.network import Network
from fmus.cosimulation.profiles import Profile, read_profile, split_units
from fmus.cosimulation.simulate import simulate as run_alone
from fmus.cosimulation.simulate import start_time
from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem
from fmus.cosimulation.subsystems.stated_units import warn_of_missing_units
from fmus.cosimulation.subsystems.subsystem import Subsystem
from fmus.cosimulation.subsystems.typed_values import Value
from fmus.declaration.component import Component, in_bounds
from fmus.declaration.units import convert
from fmus.export.build import build
from fmus.support.errors import InputError, unknown
from motofmi.reports.shown import Interactive
from motofmi.reports.time_histories import time_histories
from motofmi.workflows.components import ComponentLike, component
from motofmi.workflows.corner import in_corner
from motofmi.workflows.parts import Part, assumed, parts
from motofmi.workflows.ridden_fmus import errors_by_mode, mode_names, ridden_fmus
from motofmi.workflows.ssp_system import open_system, whole_system

SPEED, DURATION = 30.0, 5.0  # m/s and s; the defaults
Inputs = (
    str | Path | Mapping[str, ArrayLike]
)  # a CSV file, or columns by name with `time` [s]; a pandas.DataFrame has such columns, too


@dataclass(frozen=True, repr=False)
class FmuRun(CosimulationRun):
    """A finished simulation, `run["rider.steer_angle"]` over `run["time"]` [s], that a notebook shows.

        >>> run = mf.simulate("damper:7.5", inputs={"time": [0, 1], "steer_rate": [0, 0.1]}, step=0.01, duration=1.0)
        >>> path = run.show().save("run.html")
        >>> run.title
        'damper_7_5'
    """

    @property
    def title(self) -> str:
        """What was simulated."""
        return ", ".join(dict.fromkeys(name.partition(".")[0] for name in self.units if "." in name))

    def show(self, *names: str) -> Interactive:
        """The signals of these names over time, by default all of them, interactive in a notebook.

        Raises InputError for an unknown name.
        """
        for name in names:
            if name not in self:
                raise unknown("column", name, self.keys())
        return Interactive(time_histories(self, names), self.title)


@dataclass(frozen=True, repr=False)
class VehicleRun(FmuRun):
    """A co-simulation of a named vehicle with named devices.

    errors holds the coupling's error of each mode by name: `frequency` [Hz] and `damping_ratio` of the exact mode,
    `frequency_error` and `damping_error` as fractions, `real_error` [1/s]. largest_stable_step is in s.

        >>> run = mf.cosimulate("sharp_1971", "damper:7.5", speed=30, duration=0.2, initial={"steer_rate": 0.5})
        >>> run.units["vehicle.steer_angle"], sorted(run.errors["wobble"])[:2]
        ('rad', ['damping_error', 'damping_ratio'])
        >>> run.meets_tolerance, bool(run.power_residual < 1.0)  # W
        (True, True)
        >>> path = run.show("vehicle.steer_angle").save("run.html")
        >>> run.to_dict()["steps"]
        200
    """

    vehicle: str = ""
    device: str = "none"
    duration: float = 0.0
    errors: Mapping[str, Mapping[str, float]] | None = None
    largest_stable_step: float = 0.0
    assumed: Mapping[str, str] | None = None
    lean: float | None = None  # deg, of the steady turning from which it starts

    @property
    def title(self) -> str:
        """The vehicle with its devices."""
        return f"{self.vehicle} with {self.device}"

    def to_dict(self) -> dict[str, Any]:
        """The keys of `motofmi cosimulate --json`."""
        power_bonds = {
            bond.name: {
                "power": bond.power,
                "energy": bond.energy,
                "exchanged": bond.exchanged,
                "energy_error": bond.energy_error,
            }
            for bond in self.power_bonds
        }
        return {
            "vehicle": self.vehicle, "device": self.device, "assumed": dict(self.assumed or {}),
            "lean": self.lean, "file": None if self.path is None else str(self.path), "duration": self.duration,
            "step": self.step,
            "steps": self.steps, "shortest_step": self.shortest, "longest_step": self.longest,
            "coupling": self.coupling, "steps_per_second": self.steps_per_second, "predicted": dict(self.errors or {}),
            "stable": self.predicted.stable if self.predicted else None,
            "largest_stable_step": self.largest_stable_step, "meets_tolerance": self.meets_tolerance,
            "advice": self.advice, "power_residual": self.power_residual, "bonds": power_bonds,
        }  # fmt: skip


def cosimulate(vehicle: ComponentLike | None = None,
               device: ComponentLike | Sequence[ComponentLike | None] | None = None, *,
               speed: float | None = None, duration: float | None = None, step: float | str = 0.001,
               coupling: str | None = None, tolerance: float = TOLERANCE, initial: Mapping[str, float] | None = None,
               set: Mapping[str, float] | None = None, inputs: Inputs | None = None, ssp: str | Path | None = None,
               units: Mapping[str, str] | None = None, out: str | Path | None = None,
               lean: float | None = None) -> VehicleRun:  # fmt: skip
    """Co-simulate the FMUs of a vehicle and of the devices at its ports from time 0 to `duration` [s] (5 where none
    is given), or the FMUs of an SSP archive.

    vehicle and device are components, names, or paths of value files (.toml) or of FMUs. speed is in m/s (30 where none
    is given). step is in s, or `auto`; without `coupling` the least costly one is used whose relative mode errors are
    within `tolerance` (of the frequency; ten times that of the damping ratio). initial sets states and set parameters
    by name, or by `vehicle.name`, `device.name`, those of an FMU in the units that it states. inputs are linear between
    the given times: of a CSV file, or columns by name with `time` [s]; a name may end in a unit, `speed [km/h]`. units
    states the unit of variables that have none in their FMU. With `out` the rows go to that CSV file, else they stay in
    the run.

    A rider's inertia at the handlebar is bound to the vehicle, and the mass of a rider who leans is taken out of its
    rear frame, as in `modes`. `ssp` is the path of a whole system in place of vehicle and device: speed and duration
    are then those in the archive where none are given.

    With a `lean` angle [deg], to the right positive, the vehicle (tum_2020) is in large motion and starts in steady
    turning as `trim` finds it, with its constant drive torque and steer torque as inputs; set may name numbers of the
    supplement of its value file. Devices are components at the handlebar, whose motion is relative to that of steady
    turning: their springs are free of load there. Nothing keeps the roll: the run shows the motion after a small change
    by initial. Raises InputError for arguments that cannot be used, SimulationError if the coupling diverges.

        >>> run = mf.cosimulate("sharp_1971", "rider:mean_2011", speed=30, duration=0.2, initial={"steer_rate": 0.5})
        >>> run["vehicle.steer_angle"].shape
        (201,)
        >>> mf.cosimulate("tum_2020", "rider:mean_2011", speed=20, lean=65)
        Traceback (most recent call last):
        fmus.support.errors.InputError: no steady turning at 20 m/s and a lean angle of 65 deg: ...
    """
    if not (np.isfinite(tolerance) and tolerance > 0):
        raise InputError(f"tolerance = {tolerance:g}: a tolerance must be positive and finite, as in {TOLERANCE:g}")
    times, columns, stated = _columns(inputs)
    if "speed" in columns and speed is not None:
        raise InputError(f"the speed is given twice: speed = {speed:g} and the column speed of {_shown(inputs)}")
    with ExitStack() as opened:
        if lean is not None:
            if ssp is not None or "speed" in columns:
                raise InputError("a lean angle takes one speed of one vehicle: leave out ssp and the column speed")
            corner = in_corner(vehicle, device, set, SPEED if speed is None else speed)
            start = corner.start(lean)
            states = {f"vehicle.{name}": value for name, value in start.states.items()} | dict(initial or {})
            built = ridden_fmus(start.vehicle, start.devices, states, units=units, parameters=start.values)
            fmus: dict[str, Subsystem] = {n: opened.enter_context(f) for n, f in built.items()}
            wiring = join(fmus)
            names = _names(corner.whole, corner.devices)
        elif whole_system(ssp, vehicle, device):
            changed = {**(set or {}), **(initial or {})}
            system = opened.enter_context(open_system(ssp, changed, units, speed))
            fmus, wiring = system.subsystems, system.wiring
            names = {"vehicle": Path(ssp).name, "device": "none", "assumed": {}}
            duration = system.duration if duration is None else duration
        else:
            whole, devices = parts(vehicle, device, set)
            first = _start_speed(columns, stated) if "speed" in columns else SPEED if speed is None else float(speed)
            if isinstance(whole, Component):
                in_bounds(first, whole.table["speed"], whole.name)
            fmus = {n: opened.enter_context(f) for n, f in ridden_fmus(whole, devices, initial, first, units).items()}
            wiring, names = join(fmus), _names(whole, devices)
        duration = DURATION if duration is None else duration
        profile = Profile.over_time(Network(fmus, wiring), times, columns, stated)
        linear, named = linear_network(fmus, wiring), mode_names(fmus, wiring)
        run = run_together(fmus, step, duration, coupling, wiring=wiring, profile=profile, out=out, tolerance=tolerance)
    return VehicleRun(
        **vars(run), **names, duration=duration, lean=lean,
        errors=errors_by_mode(named, run.predicted) if run.predicted else {},
        largest_stable_step=largest_stable_step(coupling_of(run.coupling), linear),
    )  # fmt: skip


def _names(vehicle: Part, devices: Sequence[Part]) -> dict[str, Any]:
    """What a run says about its vehicle and devices."""
    return {"vehicle": vehicle.name, "device": ", ".join(d.name for d in devices) or "none",
            "assumed": assumed(vehicle, devices)}  # fmt: skip


def _start_speed(columns: Mapping[str, np.ndarray], units: Mapping[str, str]) -> float:
    """The first speed [m/s] of the inputs."""
    return convert(float(columns["speed"][0]), units.get("speed", "m/s"), "m/s")


def simulate(fmu: ComponentLike, *, inputs: Inputs | None = None, step: float | None = None,
             duration: float | None = None, set: Mapping[str, Value] | None = None,
             units: Mapping[str, str] | None = None, out: str | Path | None = None,
             start: float | None = None) -> FmuRun:  # fmt: skip
    """Simulate one FMU (FMI 2.0 or 3.0, co-simulation) by itself from time `start` over `duration` [s] in steps [s].

    fmu is the path of any archive, or a component or its name, whose FMU is built. start, step and duration are those
    of its default experiment where none are given, else 0 s, 0.001 s and 5 s. set gives parameters, inputs and
    starts of states by name; inputs, units and out are as in `cosimulate`. Outputs of other types than Real or Float64
    follow after those, Booleans as 0 or 1, arrays by element. The run ends where the FMU asks for it; its notes state
    that, and the variables without a column. Raises InputError for an unknown name and for more than ten million rows,
    SimulationError when the FMU fails.

        >>> run = mf.simulate("rider:mean_2011", inputs={"time": [0, 1], "steer_angle": [0, 0.1]}, step=0.01, duration=1.0)
        >>> len(run["time"])
        101
    """
    times, columns, stated = _columns(inputs)
    with tempfile.TemporaryDirectory() as folder:
        named = not isinstance(fmu, Component) and Path(fmu).suffix == ".fmu"
        path = Path(str(fmu)) if named else build(component(fmu), folder).path
        begin = start_time(path) if start is None else _finite_start(start)
        subsystem = FmuSubsystem(path, path.stem.replace(".", "_"), set, begin, units)
    with subsystem:
        warn_of_missing_units({subsystem.name: subsystem})
        return FmuRun(**vars(run_alone(subsystem, step, duration, times, columns, stated, out)))


def _finite_start(start: float) -> float:
    if not np.isfinite(start):
        raise InputError(f"start = {start:g} s: a start time must be finite, as in 0")
    return float(start)


def _columns(inputs: Inputs | None) -> tuple[np.ndarray, dict[str, np.ndarray], dict[str, str]]:
    """Times (n,) [s], columns (n,) by name, and units by name. Raises InputError for columns without a time or of
    different lengths."""
    if inputs is None:
        return np.zeros(1), {}, {}
    if isinstance(inputs, str | Path):
        return read_profile(inputs)
    columns = {str(name): np.atleast_1d(np.asarray(values, float)) for name, values in inputs.items()}
    if len({column.shape for column in columns.values()} | {(len(c),) for c in columns.values()}) > 1:
        lengths = ", ".join(f"{name} {column.shape}" for name, column in columns.items())
        raise InputError(f"the columns of the inputs differ in shape: {lengths}; expected one value for each time")
    return split_units(columns)


def _shown(inputs: Inputs | None) -> str:
    return str(inputs) if isinstance(inputs, str | Path) else "the inputs"
