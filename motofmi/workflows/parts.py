"""The parts of a system: a vehicle and devices at its ports, each a component or an archive of any tool with the port."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from fmus.cosimulation.subsystems.fmu_subsystem import model_description
from fmus.declaration.component import Component
from fmus.interfaces.handlebar import MOTION, TORQUES
from fmus.interfaces.roll import FLOWS, ROLL
from fmus.support.errors import InputError
from motofmi.workflows import components
from motofmi.workflows.components import ComponentLike
from vehicle_fmu.ridden import by_name

LEANING = "leaning rider"
PORTS = {
    "device": (MOTION, TORQUES),
    LEANING: (tuple(n for n in ROLL if n not in FLOWS), FLOWS),
}  # role: inputs, outputs


@dataclass(frozen=True)
class GivenFmu:
    """The archive of an FMU, with values of its parameters by name, in the units that it states."""

    path: Path
    values: Mapping[str, float] = field(default_factory=dict)

    @property
    def name(self) -> str:
        return self.path.name


Part = Component | GivenFmu  # a component of which an FMU is built, or an FMU


def parts(
    vehicle: ComponentLike | None, device: ComponentLike | Sequence[ComponentLike | None] | None = None,
    settings: Mapping[str, float] | None = None
) -> tuple[Part, list[Part]]:
    """Vehicle and devices as components or archives, with parameters set by name.

    Raises InputError for a name that is unknown, a component that is no vehicle or no device, and an
    archive without the port.
    """
    if vehicle is None:
        raise InputError("no vehicle is given: give its name, or ssp with the path of a system of FMUs (.ssp)")
    given = device if isinstance(device, Sequence) and not isinstance(device, str) else [device]
    devices = [_archive(each, PORTS) or components.device(each) for each in given]
    named: dict[str, Part] = {
        "vehicle": _archive(vehicle, ("vehicle",)) or components.vehicle(vehicle),
        **by_name([d for d in devices if d is not None]),
    }
    changed = components.by_part({name: _parameters(part) for name, part in named.items()}, settings or {})
    whole, *rest = (_with_values(part, changed[name]) for name, part in named.items())
    return whole, rest


def with_archives(
    vehicle: ComponentLike | None,
    devices: Sequence[ComponentLike | None] | None,
    archives: Sequence[str | Path],
    usual: tuple[ComponentLike, Sequence[ComponentLike | None]],
) -> tuple[ComponentLike, list[ComponentLike | None]]:
    """Vehicle and devices as they are given, with archives in the places that their ports fit; `usual` are vehicle and
    devices where None is given and no archive has their port.

    Raises InputError for two vehicles, and for an archive without a port.
    """
    given: dict[bool, list[ComponentLike | None]] = {True: [], False: []}  # whether it is a vehicle
    for path in archives:
        given[role_of(path) == "vehicle"].append(Path(path))
    vehicles = [*([] if vehicle is None else [vehicle]), *given[True]]
    if len(vehicles) > 1:
        raise InputError(f"two vehicles are given, {vehicles[0]} and {vehicles[1]}: leave out one of them")
    held = [*(devices or []), *given[False]]
    whole, *_ = [*vehicles, usual[0]]
    assert whole is not None
    return whole, held or list(usual[1])


def assumed(vehicle: Part, devices: Sequence[Part]) -> dict[str, str]:
    """The parameters of vehicle and devices with assumed values: the reason by parameter."""
    return {
        k: reason for part in (vehicle, *devices) if isinstance(part, Component) for k, reason in part.assumed.items()
    }


def _parameters(part: Part) -> Collection[str]:
    """The names of the parameters of a part."""
    if isinstance(part, Component):
        return part.rows("parameter")
    return [v.name for v in model_description(part.path).modelVariables if v.causality == "parameter"]


def _with_values(part: Part, values: Mapping[str, float]) -> Part:
    return part.with_values(**values) if isinstance(part, Component) else replace(part, values=values)


def _archive(given: ComponentLike | None, roles: Collection[str]) -> GivenFmu | None:
    """An archive; None for anything else. Raises InputError for an archive whose port
    does not fit the roles."""
    if isinstance(given, Component) or given is None or Path(given).suffix != ".fmu":
        return None
    role = role_of(given)
    if role not in roles:
        raise InputError(f"{given} has the port of a {role}, not of a {' or '.join(roles)}")
    return GivenFmu(Path(given))


def role_of(path: str | Path) -> str:
    """`device` for an archive whose outputs are the handlebar port's torques, `leaning rider` for one whose outputs are
    the roll port's, `vehicle` for one whose inputs are the handlebar port's torques.

    Raises InputError that lists what the archive lacks of the port.
    """
    description = model_description(path)
    inputs, outputs = ({v.name for v in description.modelVariables if v.causality == c} for c in ("input", "output"))
    wanted = {**PORTS, "vehicle": (TORQUES, MOTION)}
    missing = {role: [f"input {n}" for n in needed if n not in inputs]
               + [f"output {n}" for n in given if n not in outputs]
               for role, (needed, given) in wanted.items()}  # fmt: skip
    for role, lacking in missing.items():
        if not lacking:
            return role
    role = min(missing, key=lambda r: len(missing[r]))
    raise InputError(
        f"{path} does not have the {'roll' if role == LEANING else 'handlebar'} port: as a {role} it lacks "
        f"{', '.join(missing[role])}"
    )
