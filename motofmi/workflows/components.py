"""Components by name: riders, motorcycles, dampers and mechanisms that ship, value files, and classes of a user."""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, SupportsFloat, cast

import rider_fmu.effects
import rider_fmu.effects_on_vehicles
import vehicle_fmu.effects
from fmus.composition.added_force import with_force_element
from fmus.composition.component_folder import components_of
from fmus.composition.value_files import Library, component_from, read_values
from fmus.declaration.component import Component
from fmus.effects import effects_in
from fmus.effects.placement import laws_at
from fmus.expressions.functions import NUMERIC
from fmus.interfaces.device_effect import distinct
from fmus.interfaces.handlebar import TORQUES
from fmus.interfaces.roll import FLOWS
from fmus.mechanisms import COMPONENTS as MECHANISMS
from fmus.mechanisms import mechanisms
from fmus.support.errors import InputError, unknown
from fmus.support.modules import load_module, place_in
from motofmi.workflows.device_effects import device_effects
from rider_fmu import COMPONENTS as RIDER_COMPONENTS
from rider_fmu import riders
from vehicle_fmu import DAMPERS, VEHICLES, LinearDamper, dampers, motorcycles
from vehicle_fmu.components.given_matrices import from_matrices, holds_matrices

LIBRARIES: dict[str, Library] = {library.kind: library for library in (riders, motorcycles, dampers, mechanisms)}
COMPONENTS: dict[str, type[Component]] = {**RIDER_COMPONENTS, **VEHICLES, **DAMPERS, **MECHANISMS}
DEVICE_EFFECTS = device_effects(riders, dampers)
VEHICLE_EFFECTS = distinct(
    [*effects_in(vehicle_fmu.effects), *effects_in(rider_fmu.effects_on_vehicles), *DEVICE_EFFECTS]
)
EFFECTS = {**dict.fromkeys(RIDER_COMPONENTS, effects_in(rider_fmu.effects)), **dict.fromkeys(VEHICLES, VEHICLE_EFFECTS)}

ComponentLike = Component | str | Path  # a component, its name, or the path of its value file
DeviceSet = ComponentLike | Sequence[ComponentLike | None] | None  # devices that act together


def component(given: ComponentLike, **values: float) -> Component:
    """The component that `kind:NAME`, `damper:VALUE`, a NAME that is unique, the path of a .toml, or
    `PATH.py:CLASS` names.

    values replace parameters by name, in SI units. Raises InputError with the valid names for any other name.

        >>> mf.component("rider:mean_2011", arm_damping=20.0).values["arm_damping"]
        20.0
        >>> mf.component("damper:7.5")
        LinearDamper('damper_7.5', 1 parameter, source='Given by its damping')
    """
    found = given if isinstance(given, Component) else _named(str(given))
    return found.with_values(**values) if values else found


def vehicle(given: ComponentLike, **values: float) -> Component:
    """The motorcycle or bicycle of that name, or of a .toml; its input `speed` is in m/s.

    values replace parameters by name, in SI units. Raises InputError for anything else.

        >>> bike = mf.vehicle("sharp_1971", steering_damping=0.0)
        >>> bike.table["steering_damping"].unit, bike.values["steering_damping"]
        ('N.m.s/rad', 0.0)
    """
    found = _of_kind("motorcycle", given, values, called="vehicle")
    if "speed" not in found.inputs:
        raise InputError(
            f"{_shown(given)!r} is a {found.title}, not a vehicle (valid: {', '.join(motorcycles.names())})"
        )
    return found


def rider(given: ComponentLike, **values: float) -> Component:
    """The rider of that name, or of a .toml. values replace parameters by name, in SI units.

    Raises InputError for anything else.

        >>> mf.rider("mean_2011", arm_damping=20.0).states
        ('torso_angle', 'torso_momentum')
    """
    return _of_kind("rider", given, values)


def damper(given: ComponentLike | float, **values: float) -> Component:
    """The steering damper of that name, of a .toml, or with that damping [N.m.s/rad].

    values replace parameters by name, in SI units. Raises InputError for anything else.

        >>> mf.damper(7.5).values
        {'damping': 7.5}
    """
    return _of_kind(
        "damper", f"{float(given):g}" if isinstance(given, SupportsFloat) else cast(ComponentLike, given), values
    )


def mechanism(given: ComponentLike, **values: float) -> Component:
    """The mechanism of that name (`driven_joint`, `pendulum` and others), or of a .toml.

    values replace parameters by name, in SI units. Raises InputError for anything else.

        >>> joint = mf.mechanism("driven_joint", stiffness=20.0)
        >>> joint.inputs, joint.outputs
        (('torque',), ('angle', 'rate'))
    """
    return _of_kind("mechanism", given, values)


def device(given: ComponentLike | None) -> Component | None:
    """The device at the handlebar or at the saddle; None for None and for `none`. Raises InputError for
    any other component."""
    if given is None or given == "none":
        return None
    found = component(given)
    if not has_port(found.outputs):
        choices = [
            f"rider:{n}" for n in riders.names() if has_port(COMPONENTS[riders.contents(n)["component"]]().outputs)
        ]
        choices += [f"damper:{n}" for n in dampers.names()]
        raise InputError(
            f"{_shown(given)!r} is a {found.title}, not a device of a vehicle (valid: none, damper:VALUE, "
            f"{', '.join(choices)})"
        )
    return found


def devices(given: ComponentLike | Sequence[ComponentLike | None] | None) -> list[Component]:
    """The devices at a vehicle's ports: one, several or none. Raises InputError for a component that is no device."""
    every = given if isinstance(given, Sequence) and not isinstance(given, str) else [given]
    return [found for each in every if (found := device(each)) is not None]


def together(given: DeviceSet) -> list[ComponentLike | None]:
    """The devices that act together; a text is a comma list of them."""
    if isinstance(given, str):
        return [part.strip() for part in given.split(",")]
    if given is None or isinstance(given, Path | Component):
        return [given]
    return list(given)


def has_port(outputs: Iterable[str]) -> bool:
    """Whether the outputs contain the torques of the handlebar port or of the roll port."""
    return set(TORQUES) <= set(outputs) or set(FLOWS) <= set(outputs)


def ships(given: Component) -> bool:
    """Whether a component has the values of one that ships: those of its class or of a value file."""
    kind = COMPONENTS.get(type(given).__name__)
    if kind is not type(given):
        return False
    stems = [
        library.load(n) for library in LIBRARIES.values() for n in library.names()
        if library.contents(n)["component"] == kind.__name__
    ]
    return any(given.values == each.values for each in (kind(), *stems))


def every_name() -> list[str]:
    """Every `kind:NAME` that ships."""
    return [f"{kind}:{name}" for kind, library in LIBRARIES.items() for name in library.names()]


def component_class(spec: str) -> type[Component]:
    """The class that `PATH.py:CLASS` names. Raises InputError with the classes of the file for anything else, and with
    the line at which its equations use what does not exist."""
    path, _, title = spec.rpartition(":")
    if not path.endswith(".py"):
        raise InputError(f"{spec!r} is not PATH.py:CLASS, as in bench.py:Gearbox")
    if not Path(path).is_file():
        raise InputError(f"cannot read {path}: there is no such file")
    found = {c.__name__: c for c in components_of(load_module(path))}
    if title not in found:
        raise unknown(f"component in {path}", title, found)
    made = found[title]()
    try:
        made.complete(made.run(made.start_values(), NUMERIC))
    except (AttributeError, NameError, TypeError, LookupError) as error:
        raise InputError(f"{place_in(path, error)}: {type(error).__name__}: {error}") from None
    return found[title]


def with_settings(parts: Mapping[str, Component | None], settings: Mapping[str, float]) -> list[Component | None]:
    """The parts with parameters set by name, or by `part.name` where several parts have it."""
    changed = by_part({part: c.rows("parameter") if c else {} for part, c in parts.items()}, settings)
    return [c.with_values(**changed[part]) if c else None for part, c in parts.items()]


def by_part(parameters: Mapping[str, Collection[str]], settings: Mapping[str, float]) -> dict[str, dict[str, float]]:
    """The settings of each part, given by the name of a parameter, or by `part.name` where several parts have it.

    Raises InputError for a name that none of the parts has, and for one that several have.
    """
    changed: dict[str, dict[str, float]] = {part: {} for part in parameters}
    for key, value in settings.items():
        part, dot, name = key.partition(".")
        owners = [part] if dot and name in parameters.get(part, ()) else []
        owners = owners or [p for p in parameters if key in parameters[p]]
        if not owners:
            raise unknown("parameter", key, {n for rows in parameters.values() for n in rows})
        if len(owners) > 1:
            raise InputError(f"{key!r} is a parameter of {' and '.join(owners)}: write {owners[-1]}.{key}={value:g}")
        changed[owners[0]][name if owners[0] == part else key] = value
    return changed


def _of_kind(kind: str, given: ComponentLike, values: Mapping[str, float], called: str = "") -> Component:
    """The component; a bare name is one of that kind. Raises InputError for a name of another kind, which says what
    the kind is called."""
    if isinstance(given, Component):
        return component(given, **values)
    name = str(given)
    other = name.partition(":")[0]
    if ":" in name and other in LIBRARIES and other != kind:
        raise InputError(
            f"{name!r} is a {component(name).title}, not a {called or kind} (valid: "
            f"{', '.join(LIBRARIES[kind].names())})"
        )
    return component(name if ":" in name or name.endswith(".toml") else f"{kind}:{name}", **values)


def _shown(given: ComponentLike) -> str:
    return given.name if isinstance(given, Component) else str(given)


def _named(name: str) -> Component:
    kind, colon, rest = name.partition(":")
    if colon and kind in LIBRARIES:
        return _damper(rest) if kind == "damper" else LIBRARIES[kind].load(rest)
    if name.endswith(".toml"):
        return _of_file(Path(name))
    if ".py:" in name:
        return component_class(name)()
    if colon:
        raise unknown("kind of component", kind, LIBRARIES)
    holders = [library for library in LIBRARIES.values() if name in library.names()]
    if len(holders) > 1:
        raise InputError(f"{name!r} is the name of several: {', '.join(f'{h.kind}:{name}' for h in holders)}")
    if not holders:
        raise unknown("component", name, every_name())
    return holders[0].load(name)


def _of_file(path: Path) -> Component:
    """The component of a value file, with effects from those that may act on it."""
    if holds_matrices(path):
        return from_matrices(path)
    contents = read_values(path)
    title, file = str(contents.get("component", "")), contents.get("component_file")
    known: dict[str, Any] = {**COMPONENTS, title: _of_a_user(f"{path.parent / file}:{title}")} if file else COMPONENTS
    effects = laws_at(known[title]()) if file or title in MECHANISMS else EFFECTS.get(title, ())
    return component_from(contents, known, path.stem, str(path), effects)


def _of_a_user(spec: str) -> Callable[..., Component]:
    """What makes a component of a user's class, with a place for effects where it names none."""
    kind = component_class(spec)

    def make(name: str = "", source: str = "", effects: Iterable[Any] = (), **values: float) -> Component:
        return with_force_element(kind(name, source)).with_effects(*effects).with_values(**values)

    return make


def _damper(name: str) -> Component:
    try:
        value = float(name)
    except ValueError:
        return dampers.load(name)
    return LinearDamper(f"damper_{name}", "Given by its damping", damping=value)
