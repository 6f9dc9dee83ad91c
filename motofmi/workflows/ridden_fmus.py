"""A vehicle and devices at its ports as FMUs: built from components, or archives of any tool with the port."""

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from fmus.cosimulation.cosimulate import join
from fmus.cosimulation.coupling_error import Prediction
from fmus.cosimulation.network import Network
from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem, model_description
from fmus.cosimulation.subsystems.stated_units import by_fmu, described_unit, warn_of_missing_units
from fmus.cosimulation.subsystems.subsystem import LinearSubsystem, Subsystem
from fmus.cosimulation.subsystems.typed_values import REAL
from fmus.declaration.component import Component
from fmus.declaration.units import convert
from fmus.export.build import build
from fmus.interfaces.handlebar import MOTION
from fmus.linear_analysis.linearisation import StateSpace
from fmus.support.errors import InputError, unknown
from fmus.support.progress import stage
from motofmi.workflows.parts import GivenFmu, Part
from vehicle_fmu import MODES, modes
from vehicle_fmu.mode_shapes import Linearised
from vehicle_fmu.ridden import by_name, with_posture_inertia
from vehicle_fmu.rider_mass_removed import RIDER_BODY, rear_frame_without


def ridden_fmus(vehicle: Part, device: Part | Sequence[Part] | None, initial: Mapping[str, float] | None = None,
                speed: float | None = None, units: Mapping[str, str] | None = None,
                parameters: Mapping[str, Mapping[str, float]] | None = None) -> dict[str, FmuSubsystem]:  # fmt: skip
    """Vehicle and devices as subsystems `vehicle`, `device`, `device_2` and so on, initialised.

    initial sets states by name, or by `part.name` where several have it, parameters those of each part. A rider's
    inertia that moves with the handlebar becomes the vehicle's `added_steer_inertia`; a rider who leans is taken out of
    the vehicle's rear frame. units states the unit of variables that have none, by name. Raises InputError for a name
    that none has, and when the vehicle cannot spare the rider; warns of units that are missing.
    """
    devices = by_name([] if device is None else [device] if isinstance(device, Part) else device)
    if isinstance(vehicle, Component):
        vehicle = with_posture_inertia(vehicle, {name for part in devices.values() for name in _outputs(part)})
    parts = {"vehicle": vehicle, **devices}
    with tempfile.TemporaryDirectory() as folder:
        with stage("building the FMUs"):
            paths = {
                name: build(part, folder).path if isinstance(part, Component) else part.path
                for name, part in parts.items()
            }
        given = {name: part.values for name, part in parts.items() if isinstance(part, GivenFmu)}
        starts, changed = _starts(paths, initial or {}), {**given, **(parameters or {})}
        for name, values in changed.items():
            starts[name] |= values
        every = {name: {v.name: v for v in model_description(path).modelVariables} for name, path in paths.items()}
        stated = by_fmu(units or {}, every)
        subsystems = {name: FmuSubsystem(paths[name], name, starts[name], units=stated[name]) for name in devices}
        variables = every["vehicle"]
        if speed is not None and "speed" in variables:
            unit = stated["vehicle"].get("speed") or described_unit(variables["speed"])
            starts["vehicle"]["speed"] = convert(speed, "m/s", unit or "m/s")
        starts["vehicle"] |= _carried(
            {n: float(v.start) for n, v in variables.items() if v.causality == "parameter" and v.type in REAL}
            | dict(changed.get("vehicle", {})),
            subsystems,
        )
        subsystems["vehicle"] = FmuSubsystem(paths["vehicle"], "vehicle", starts["vehicle"], units=stated["vehicle"])
    subsystems = {name: subsystems[name] for name in parts}
    warn_of_missing_units(subsystems)
    network = Network(subsystems, join(subsystems))
    network.read(np.zeros(len(network.outputs)))  # sets every input to the output that drives it
    return subsystems


def _outputs(part: Part) -> list[str]:
    """The names of the outputs of a part."""
    return (
        list(part.outputs)
        if isinstance(part, Component)
        else [v.name for v in model_description(part.path).modelVariables if v.causality == "output"]
    )


def _carried(vehicle: Mapping[str, float], devices: Mapping[str, FmuSubsystem]) -> dict[str, float]:
    """The vehicle parameters that the devices change, by name, as `vehicle_fmu.ridden` binds them.

    Raises InputError for two riders who hold the handlebar, and when the vehicle cannot spare the
    mass of one who leans.
    """
    changed: dict[str, float] = {}
    holding = [name for name, subsystem in devices.items() if "port_inertia" in subsystem.variables]
    if len(holding) > 1:
        raise InputError(f"{' and '.join(holding)} cannot both hold the handlebar; give one rider there")
    for subsystem in devices.values():
        if "port_inertia" in subsystem.variables and "added_steer_inertia" in vehicle:
            changed["added_steer_inertia"] = subsystem.get("port_inertia")
        if set(RIDER_BODY) <= subsystem.variables.keys():
            changed |= rear_frame_without(
                "the vehicle", {**vehicle, **changed}, *(subsystem.get(name) for name in RIDER_BODY)
            )
    return changed


def _starts(paths: Mapping[str, Path], initial: Mapping[str, float]) -> dict[str, dict[str, float]]:
    """The values to start from by part."""
    states = {
        part: {u.variable.derivative.name for u in model_description(path).derivatives} for part, path in paths.items()
    }
    starts: dict[str, dict[str, float]] = {part: {} for part in paths}
    for key, value in initial.items():
        part, dot, name = key.partition(".")
        owners = [part] if dot and name in states.get(part, ()) else [p for p in states if key in states[p]]
        if not owners:
            raise unknown("state", key, [f"{p}.{n}" for p, own in states.items() for n in own])
        if len(owners) > 1:
            raise InputError(f"{key!r} is a state of {' and '.join(owners)}: write {owners[-1]}.{key}={value:g}")
        if not np.isfinite(value):
            raise InputError(f"{key} = {value:g} is not a finite number")
        starts[owners[0]][name if dot else key] = value
    return starts


def over_speed_fmus(
    subsystems: Mapping[str, Subsystem], wiring: Mapping[str, Sequence[str]] | None = None
) -> Linearised:
    """The coupled FMUs, without coupling error, linearised as a function of speeds (n,) in m/s.

    Raises InputError when not exactly one of them has an input `speed`, and when another one drives it.
    """
    wiring = join(subsystems) if wiring is None else wiring
    moving = [name for name, subsystem in subsystems.items() if "speed" in subsystem.inputs]
    if len(moving) != 1:
        raise InputError(
            f"modes over speed need one FMU with an input speed, not {len(moving)} ({', '.join(moving) or 'none'})"
        )
    if driving := wiring.get(f"{moving[0]}.speed"):
        raise InputError(f"modes over speed set the input {moving[0]}.speed, but {driving[0]} drives it")
    vehicle = subsystems[moving[0]]
    assert isinstance(vehicle, FmuSubsystem)
    # Nothing but the vehicle changes with its speed.
    models: dict[str, Subsystem] = {
        name: subsystem if subsystem is vehicle else LinearSubsystem(subsystem.linearised())
        for name, subsystem in subsystems.items()
    }
    network = Network(models, wiring)
    unit = vehicle.unit_of("speed") or "m/s"

    def linearised(speeds: np.ndarray) -> StateSpace:
        spaces = []
        for speed in speeds:
            vehicle.set("speed", convert(float(speed), "m/s", unit))
            spaces.append(network.linearised())
        first = spaces[0]
        A, B, C, D = (np.stack([getattr(space, matrix) for space in spaces]) for matrix in "ABCD")
        return StateSpace(A, B, C, D, first.states, first.inputs, first.outputs)

    return linearised


def errors_by_mode(named: Mapping[str, complex], prediction: Prediction) -> dict[str, dict[str, float]]:
    """The coupling's errors of every oscillatory mode by its name, from `mode_names`; one without a name
    goes by its frequency."""
    found = {}
    for k in np.flatnonzero(prediction.oscillatory):
        eigenvalue = prediction.exact[k]
        found[f"{eigenvalue.imag / (2 * np.pi):.2f}_Hz"] = (eigenvalue, {
            "frequency": eigenvalue.imag / (2 * np.pi),
            "damping_ratio": -eigenvalue.real / abs(eigenvalue),
            "frequency_error": prediction.frequency_error[k],
            "damping_error": prediction.damping_error[k],
            "real_error": prediction.real_error[k],
        })  # fmt: skip
    return {_name(eigenvalue, named, default): errors for default, (eigenvalue, errors) in found.items()}


def _name(eigenvalue: complex, named: Mapping[str, complex], default: str) -> str:
    return next((name for name, value in named.items() if abs(value - eigenvalue) < 1e-6 * abs(eigenvalue)), default)


def mode_names(
    subsystems: Mapping[str, Subsystem], wiring: Mapping[str, Sequence[str]] | None = None
) -> dict[str, complex]:
    """The eigenvalues [1/s] of the named modes of the subsystems where they are; none unless exactly one of them is a
    vehicle whose speed is free."""
    vehicles = [s for n, s in subsystems.items() if isinstance(s, FmuSubsystem) and "speed" in s.inputs
                and set(MOTION) <= set(s.outputs) and f"{n}.speed" not in (wiring or {})]  # fmt: skip
    if len(vehicles) != 1:
        return {}
    vehicle = vehicles[0]
    given = float(vehicle.present_inputs[vehicle.inputs.index("speed")])
    speed = convert(given, vehicle.unit_of("speed") or "m/s", "m/s")
    try:
        found = modes(over_speed_fmus(subsystems, wiring), np.array([speed]))
    finally:
        vehicle.set("speed", given)
    return {mode: complex(found[mode].eigenvalue[0]) for mode in MODES}
