"""Runs that co-simulate the FMUs of a vehicle and its devices at one speed each."""

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from fmus.cosimulation.cosimulate import TOLERANCE, cosimulate, join, steps
from fmus.cosimulation.coupling import COUPLINGS
from fmus.cosimulation.network import Network
from fmus.cosimulation.profiles import Profile, read_profile
from fmus.declaration.component import Component
from fmus.export.build import build
from fmus.support.errors import InputError, unknown
from motofmi.studies.axes import values_of
from motofmi.studies.runs import Column, Computed, Coordinate, Result
from motofmi.workflows.parts import GivenFmu
from motofmi.workflows.ridden_fmus import ridden_fmus
from motofmi.workflows.sweep.system_runs import NUMERIC, SystemRuns, speeds_of
from motofmi.workflows.sweep.systems import Archive, Part, Systems
from vehicle_fmu.ridden import by_name, with_posture_inertia

STEP = 8e-6  # s of processor time for a communication step
OPENING = 15e-3  # s of processor time to open the FMUs and to predict the errors of the coupling
OUTPUTS = ("vehicle.steer_angle", "vehicle.roll_angle", "vehicle.yaw_rate")
DEFAULTS: dict[str, Any] = {"duration": 5.0, "step": 0.001, "coupling": None, "tolerance": TOLERANCE, "initial": {},
                            "inputs": None, "noise": {}, "outputs": OUTPUTS, "output_step": 0.01}  # fmt: skip


class CosimulationRuns(SystemRuns):
    """The chosen outputs over `time`. The table has for each output the largest magnitude of the run and of its last
    quarter, and the coupling.

    Several steps and several couplings are dimensions of their own. initial sets states, inputs is a CSV file of inputs
    over time, noise the standard deviation of normal random values that are added to an input at every output step
    (linear in between; different in every run, the same at each repetition). The FMUs are built once; the parameters of
    a run are set before its start.
    """

    OPTIONS = tuple(DEFAULTS)

    @classmethod
    def checked(cls, study: Any, systems: Systems) -> dict[str, Any]:
        options = {**DEFAULTS, **study.options}
        speeds = speeds_of(study.speed, systems, np.array([30.0]))
        duration = _number(options, "duration")
        options["step"] = np.array([steps(float(h), duration)[0] for h in values_of("step", options["step"])])
        _, count = steps(min(_number(options, "output_step"), options["duration"]), options["duration"])
        options["time"] = np.linspace(0.0, options["duration"], count + 1)
        options["coupling"] = _couplings(options["coupling"])
        options["profile"] = None if options["inputs"] is None else read_profile(options["inputs"])
        options["inputs"] = None if options["inputs"] is None else str(options["inputs"])
        options |= {"outputs": list(options["outputs"]), "speed": speeds, "seed": study.seed}
        options["fmus"] = _built(systems)
        cls._try(systems, options)
        return options

    @classmethod
    def _try(cls, systems: Systems, options: dict[str, Any]) -> None:
        """Open the FMUs of every system once. Raises InputError for names that they lack."""
        for parts in options["fmus"].values():
            with _Opened(parts, options, float(options["speed"][0]), {}) as opened:
                for name in options["outputs"]:
                    if name not in opened.network.outputs:
                        raise unknown("output of the co-simulation", name, opened.network.outputs)
                opened.profile(options, 0)

    @classmethod
    def axes_of(cls, options: dict[str, Any]) -> dict[str, Coordinate]:
        couplings, step, speed = options["coupling"], options["step"], options["speed"]
        several = {"coupling": Coordinate("coupling", couplings, "", "coupling of the FMUs"),
                   "step": Coordinate("step", step, "s", "communication step")}  # fmt: skip
        return {**{name: axis for name, axis in several.items() if len(axis.values) > 1},
                "speed": Coordinate("speed", speed, "m/s", "forward speed")}  # fmt: skip

    def stated(self) -> dict[str, Any]:
        kept = {name: self.options[name] for name in DEFAULTS if name != "inputs"}
        kept["step"] = self.options["step"].tolist()
        profile = self.options["profile"]
        if profile is not None:
            kept["inputs"] = {"time": profile[0].tolist(), **{n: x.tolist() for n, x in profile[1].items()}}
        return kept

    def describe(self) -> None:
        time, units = self.options["time"], self._units()
        self.results = {name: Result(("time",), time.shape, "float64", units[name], f"{name} over time")
                        for name in self.options["outputs"]}  # fmt: skip
        self.extra = {"time": Coordinate("time", time, "s", "time")}
        self.values = {f"{name}_{part}": Column(NUMERIC, units[name]) for name in self.options["outputs"]
                       for part in ("peak", "last_peak")} | {
                           "meets_tolerance": Column("bool")}  # fmt: skip
        if "coupling" not in self.axes:
            self.values["coupling"] = Column("string")

    def _units(self) -> dict[str, str]:
        parts = next(iter(self.options["fmus"].values()))
        with _Opened(parts, self.options, float(self.options["speed"][0]), {}) as opened:
            return {n: opened.network.subsystems[n.partition(".")[0]].unit_of(n.partition(".")[2])
                    for n in self.options["outputs"]}  # fmt: skip

    def cost(self) -> float:
        return OPENING + STEP * self.options["duration"] * float(np.mean(1 / self.options["step"]))

    def of_system(self, vehicle: int, device: int, indices: np.ndarray) -> Computed:
        options, numbers = self.options, self.grid.numbers(indices)
        arrays = {name: np.empty((len(indices), len(options["time"]))) for name in self.results}
        columns: dict[str, list[Any]] = {name: [] for name in self.values}
        for k, place in enumerate(indices):
            with opened_run(self, place) as opened:
                run = cosimulate(opened.fmus, self.at("step", place), options["duration"], self.at("coupling", place),
                                 wiring=opened.wiring, profile=opened.profile(options, int(numbers[k])),
                                 tolerance=options["tolerance"])  # fmt: skip
            if "coupling" in columns:
                columns["coupling"].append(run.coupling)
            columns["meets_tolerance"].append(run.meets_tolerance)
            for name in self.results:
                signal = np.interp(options["time"], run["time"], run[name])
                arrays[name][k] = signal
                columns[f"{name}_peak"].append(float(np.abs(signal).max()))
                columns[f"{name}_last_peak"].append(float(np.abs(signal[-(-3 * len(signal) // 4) :]).max()))
        return Computed(arrays, columns)


def opened_run(runs: SystemRuns, place: np.ndarray) -> "_Opened":
    """The FMUs of the run at a place (dims,) of the grid, with its parameters. Raises InputError for a value outside
    its bounds."""
    vehicle, device = int(place[0]), int(place[1])
    parts = runs.systems.parts(vehicle, device)
    names = dict(zip(parts, ("vehicle", *by_name(list(parts.values())[1:])), strict=True))
    changed: dict[str, dict[str, float]] = {}
    for (part, name), column in runs.systems.values(place[None]).items():
        runs.systems.within_bounds(parts[part], {name: column})
        changed.setdefault(names[part], {})[name] = float(column[0])
    return _Opened(runs.options["fmus"][vehicle, device], runs.options, float(runs.at("speed", place)), changed)


class _Opened:
    """The FMUs of a run, initialised, with their network."""

    def __init__(self, parts: list[Archive], options: dict[str, Any], speed: float,
                 parameters: dict[str, dict[str, float]]):  # fmt: skip
        vehicle, *devices = (GivenFmu(part.path()) for part in parts)
        self.fmus = ridden_fmus(vehicle, devices, options["initial"], speed, parameters=parameters)
        self.wiring = join(self.fmus)
        self.network = Network(self.fmus, self.wiring)

    def __enter__(self) -> "_Opened":
        return self

    def __exit__(self, *error: Any) -> None:
        for fmu in self.fmus.values():
            fmu.close()

    def profile(self, options: dict[str, Any], run: int) -> Profile:
        """The inputs over time of a run with this number. Raises InputError for an unknown input."""
        times, columns = options["profile"] or (np.zeros(1), {})
        if options["noise"]:
            random, grid = np.random.default_rng((options["seed"], run)), options["time"]
            columns = {name: np.interp(grid, times, column) for name, column in columns.items()}
            for name, deviation in options["noise"].items():
                columns[name] = columns.get(name, 0.0) + random.normal(0.0, float(deviation), len(grid))
            times = grid
        return Profile.over_time(self.network, times, columns)


def _couplings(given: Any) -> list[str | None]:
    """The names of couplings; None is the one that is chosen for a run. Raises InputError for an unknown name."""
    names = [given] if given is None or isinstance(given, str) else list(given)
    for name in names:
        if name not in COUPLINGS and (name is not None or len(names) > 1):
            raise unknown("coupling", name, COUPLINGS)
    return names or [None]


def _number(options: dict[str, Any], name: str) -> float:
    try:
        return float(options[name])
    except (TypeError, ValueError):
        raise InputError(f"{name} = {options[name]!r} is not a number of seconds") from None


def _built(systems: Systems) -> dict[tuple[int, int], list[Archive]]:
    """The archives of vehicle and devices of every system; each component is built once."""
    archives: dict[int, Archive] = {}

    def archive(part: Part, folder: str) -> Archive:
        if isinstance(part, Archive):
            return part
        if id(part) not in archives:
            archives[id(part)] = Archive.of(build(part, folder).path)
        return archives[id(part)]

    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for v in range(len(systems.vehicles)):
            for d in range(len(systems.devices)):
                vehicle, *devices = systems.parts(v, d).values()
                held = [archive(part, folder) for part in devices]
                if isinstance(vehicle, Component):
                    outputs = {n for part in devices if isinstance(part, Component) for n in part.outputs}
                    whole = with_posture_inertia(vehicle, outputs)
                    found[v, d] = [archive(vehicle, folder) if whole is vehicle else
                                   Archive.of(build(whole, Path(folder) / f"{v}_{d}").path), *held]  # fmt: skip
                else:
                    found[v, d] = [vehicle, *held]
    return found
