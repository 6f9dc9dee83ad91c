"""A vehicle and devices at its ports as FMUs: built from components, or anybody's archives with the port."""

import argparse
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from fmus.build import build
from fmus.component import Component
from fmus.cosimulation import join
from fmus.coupling import LinearUnit, Network, Unit
from fmus.errors import InputError, unknown
from fmus.importer import FmuUnit, model_description
from fmus.linear import StateSpace
from fmus.ports import MOTION, TORQUES
from fmus.prediction import Prediction
from fmus.roll_port import FLOWS, ROLL
from scenarios import names
from vehicle_fmu import MODES, modes
from vehicle_fmu.lightened import BODY, rest_of
from vehicle_fmu.mode_names import Linearised
from vehicle_fmu.ridden import by_name, carrying

Part = Component | Path  # what becomes an FMU, or an FMU
LEANING = "leaning rider"
PORTS = {"device": (MOTION, TORQUES), LEANING: (tuple(n for n in ROLL if n not in FLOWS), FLOWS)}  # role: told, answered


def parts(arguments: argparse.Namespace) -> tuple[Part, list[Part], dict[str, str]]:
    """Vehicle and devices that a command line names, as components or archives, and what is assumed in their values.

    arguments has vehicle, device, fmu (paths: a vehicle's replaces that, devices' replace the devices) and settings.
    """
    given: dict[str, Path] = {}
    for path in arguments.fmu:
        role = role_of(path)
        if role in given:
            raise InputError(f"two FMUs for the {role}: {given[role]} and {path}")
        given[role] = Path(path)
    archives = [given[role] for role in PORTS if role in given]
    held = {} if archives else by_name(names.devices(arguments.device))
    components = {"vehicle": None if "vehicle" in given else names.vehicle(arguments.vehicle), **held}
    vehicle, *devices = names.with_settings(components, names.assignments(arguments.settings))
    assumed = {k: reason for c in (vehicle, *devices) if c for k, reason in c.assumed.items()}
    whole = given.get("vehicle") or vehicle
    assert whole is not None
    return whole, [*archives, *(d for d in devices if d is not None)], assumed


def role_of(path: str | Path) -> str:
    """`device` for an archive that answers the handlebar port's torques, `leaning rider` for one that answers the roll
    port's, `vehicle` for one that is told the handlebar port's.

    Raises InputError that lists what the archive lacks of the port.
    """
    description = model_description(path)
    inputs, outputs = ({v.name for v in description.modelVariables if v.causality == c} for c in ("input", "output"))
    wanted = {**PORTS, "vehicle": (TORQUES, MOTION)}
    missing = {role: [f"input {n}" for n in told if n not in inputs] + [f"output {n}" for n in answered if n not in outputs]
               for role, (told, answered) in wanted.items()}  # fmt: skip
    for role, lacking in missing.items():
        if not lacking:
            return role
    role = min(missing, key=lambda r: len(missing[r]))
    raise InputError(f"{path} has not the {'roll' if role == LEANING else 'handlebar'} port: as a {role} it lacks {', '.join(missing[role])}")


def ridden_fmus(vehicle: Part, device: Part | Sequence[Part] | None, initial: Mapping[str, float] | None = None,
                speed: float | None = None) -> dict[str, FmuUnit]:  # fmt: skip
    """Vehicle and devices as units `vehicle`, `device`, `device_2` and so on, initialised.

    initial sets states by name, or by `part.name` where several have it. A rider's inertia that moves with the
    handlebar becomes the vehicle's `added_steer_inertia`; a rider who leans is taken out of the vehicle's rear frame.
    Raises InputError for a name that none has, and when the vehicle cannot spare the rider.
    """
    devices = by_name([] if device is None else [device] if isinstance(device, Part) else device)
    if isinstance(vehicle, Component):
        vehicle = carrying(vehicle, {name for part in devices.values() for name in _outputs(part)})
    parts = {"vehicle": vehicle, **devices}
    with tempfile.TemporaryDirectory() as folder:
        paths = {name: build(part, folder).path if isinstance(part, Component) else part for name, part in parts.items()}
        starts = _starts(paths, initial or {})
        units = {name: FmuUnit(paths[name], name, starts[name]) for name in devices}
        variables = {v.name: v for v in model_description(paths["vehicle"]).modelVariables}
        if speed is not None and "speed" in variables:
            starts["vehicle"]["speed"] = speed
        starts["vehicle"] |= _carried({n: float(v.start) for n, v in variables.items() if v.causality == "parameter"}, units)
        units["vehicle"] = FmuUnit(paths["vehicle"], "vehicle", starts["vehicle"])
    units = {name: units[name] for name in parts}
    network = Network(units, join(units))
    network.read(np.zeros(len(network.outputs)))  # so that each is told where the other starts
    return units


def _outputs(part: Part) -> list[str]:
    """The names of what a part answers."""
    return list(part.outputs) if isinstance(part, Component) else [v.name for v in model_description(part).modelVariables if v.causality == "output"]


def _carried(vehicle: Mapping[str, float], devices: Mapping[str, FmuUnit]) -> dict[str, float]:
    """What the devices change of a vehicle's parameters by name, as `vehicle_fmu.ridden` binds them."""
    changed: dict[str, float] = {}
    for unit in devices.values():
        if "port_inertia" in unit.variables and "added_steer_inertia" in vehicle:
            changed["added_steer_inertia"] = unit.get("port_inertia")
        if set(BODY) <= unit.variables.keys():
            changed |= rest_of("the vehicle", {**vehicle, **changed}, *(unit.get(name) for name in BODY))
    return changed


def _starts(paths: Mapping[str, Path], initial: Mapping[str, float]) -> dict[str, dict[str, float]]:
    """The values to start from by part."""
    states = {part: {u.variable.derivative.name for u in model_description(path).derivatives} for part, path in paths.items()}
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


def over_speed_fmus(units: Mapping[str, FmuUnit], wiring: Mapping[str, Sequence[str]] | None = None) -> Linearised:
    """The coupled FMUs, without coupling error, linearised as a function of speeds (n,) in m/s.

    Raises InputError when not exactly one of them has an input `speed`.
    """
    moving = [name for name, unit in units.items() if "speed" in unit.inputs]
    if len(moving) != 1:
        raise InputError(f"modes over speed need one FMU with an input speed, not {len(moving)} ({', '.join(moving) or 'none'})")
    vehicle = units[moving[0]]
    # Nothing but the vehicle changes with its speed.
    models: dict[str, Unit] = {name: unit if unit is vehicle else LinearUnit(unit.linearised()) for name, unit in units.items()}
    network = Network(models, join(units) if wiring is None else wiring)

    def linearised(speeds: np.ndarray) -> StateSpace:
        spaces = []
        for speed in speeds:
            vehicle.set("speed", float(speed))
            spaces.append(network.linearised())
        first = spaces[0]
        A, B, C, D = (np.stack([getattr(space, matrix) for space in spaces]) for matrix in "ABCD")
        return StateSpace(A, B, C, D, first.states, first.inputs, first.outputs)

    return linearised


def errors_by_mode(named: Mapping[str, complex], prediction: Prediction) -> dict[str, dict[str, float]]:
    """The coupling's errors of every oscillatory mode by its name, from `mode_names`; one without a name goes by its frequency."""
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


def mode_names(units: Mapping[str, FmuUnit]) -> dict[str, complex]:
    """The eigenvalues [1/s] of the named modes of the units where they are; none for what has no speed."""
    vehicle = units["vehicle"]
    if "speed" not in vehicle.inputs:
        return {}
    speed = float(vehicle.present_inputs[vehicle.inputs.index("speed")])
    try:
        found = modes(over_speed_fmus(units), np.array([speed]))
    finally:
        vehicle.set("speed", speed)
    return {mode: complex(found[mode].eigenvalue[0]) for mode in MODES}
