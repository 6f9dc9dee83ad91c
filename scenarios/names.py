"""From what a user writes (`rider:mean_2011`, `damper:7.5`, `mine.toml`, `arm_damping=20`) to components and values."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

import fmus.effects.channel
import rider_fmu.effects
import rider_fmu.effects_on_vehicles
import vehicle_fmu.effects
from fmus.component import Component
from fmus.effects import effects_in
from fmus.effects.library import declared_by, load_module
from fmus.effects.places import laws_at
from fmus.errors import InputError, unknown
from fmus.library import Library, component_from, read_values
from fmus.mechanisms import COMPONENTS as MECHANISMS
from fmus.mechanisms import mechanisms
from fmus.ports import TORQUES
from fmus.resisted import with_a_place
from fmus.roll_port import FLOWS
from rider_fmu import COMPONENTS as RIDER_COMPONENTS
from rider_fmu import riders
from vehicle_fmu import DAMPERS, VEHICLES, LinearDamper, dampers, motorcycles
from vehicle_fmu.given_matrices import from_matrices, holds_matrices

LIBRARIES: dict[str, Library] = {library.kind: library for library in (riders, motorcycles, dampers, mechanisms)}
COMPONENTS: dict[str, type[Component]] = {**RIDER_COMPONENTS, **VEHICLES, **DAMPERS, **MECHANISMS}
VEHICLE_EFFECTS = [*effects_in(vehicle_fmu.effects), *effects_in(rider_fmu.effects_on_vehicles)]
EFFECTS = {**dict.fromkeys(RIDER_COMPONENTS, effects_in(rider_fmu.effects)), **dict.fromkeys(VEHICLES, VEHICLE_EFFECTS)}
MOST = 1e6  # values in one range: beyond it is a slip of the keyboard


def component(spec: str) -> Component:
    """The component that `kind:NAME`, `damper:VALUE`, a bare NAME that is unique, or the path of a .toml names.

    Raises InputError with the valid names for anything else.
    """
    kind, colon, name = spec.partition(":")
    if colon and kind in LIBRARIES:
        return _damper(name) if kind == "damper" else LIBRARIES[kind].load(name)
    if spec.endswith(".toml"):
        if holds_matrices(Path(spec)):
            return from_matrices(Path(spec))
        contents = read_values(Path(spec))
        title, file = str(contents.get("component", "")), contents.get("component_file")
        known: dict[str, Any] = {**COMPONENTS, title: _of_a_user(f"{Path(spec).parent / file}:{title}")} if file else COMPONENTS
        effects = laws_at(known[title]()) if file or title in MECHANISMS else EFFECTS.get(title, ())
        return component_from(contents, known, Path(spec).stem, spec, effects)
    if colon:
        raise unknown("kind of component", kind, LIBRARIES)
    holders = [library for library in LIBRARIES.values() if spec in library.names()]
    if len(holders) > 1:
        raise InputError(f"{spec!r} is the name of several: {', '.join(f'{h.kind}:{spec}' for h in holders)}")
    if not holders:
        raise unknown("component", spec, every_name())
    return holders[0].load(spec)


def _of_a_user(spec: str) -> Callable[..., Component]:
    """What makes a component of a user's class, with a place for effects where it names none."""
    kind = component_class(spec)

    def make(name: str = "", source: str = "", effects: Iterable[Any] = (), **values: float) -> Component:
        return with_a_place(kind(name, source)).with_effects(*effects).with_values(**values)

    return make


def component_class(spec: str) -> type[Component]:
    """The class that `PATH.py:CLASS` names. Raises InputError with the classes of the file for anything else."""
    path, _, title = spec.rpartition(":")
    if not path.endswith(".py"):
        raise InputError(f"{spec!r} is not PATH.py:CLASS, as in bench.py:Gearbox")
    if not Path(path).is_file():
        raise InputError(f"cannot read {path}: there is no such file")
    module = load_module(path)
    found = {n: c for n, c in vars(module).items() if isinstance(c, type) and issubclass(c, Component) and c.__module__ == module.__name__}
    if title not in found:
        raise unknown(f"component in {path}", title, found)
    return found[title]


def every_name() -> list[str]:
    """Every `kind:NAME` that ships."""
    return [f"{kind}:{name}" for kind, library in LIBRARIES.items() for name in library.names()]


def effects() -> list[dict[str, Any]]:
    """The effects of riders, vehicles and measuring channels that ship: name, form, sentence, parameters and where each is declared."""
    return [{"name": e.family, "form": e.form, "description": e.sentence(), "element": e.element, "source": e.__module__,
             "parameters": {n: {"unit": r.unit, "symbol": r.symbol, "value": r.start, "min": r.min, "max": r.max, "description": r.description}
                            for n, r in e.parameters().items()}}
            for e in [*effects_in(rider_fmu.effects), *VEHICLE_EFFECTS, *declared_by(fmus.effects.channel)]]  # fmt: skip


def _damper(name: str) -> Component:
    try:
        value = float(name)
    except ValueError:
        return dampers.load(name)
    return LinearDamper(f"damper_{name}", "Given on the command line", damping=value)


def vehicle(spec: str) -> Component:
    """The vehicle of that name. Raises InputError when it is something else."""
    found = component(spec) if ":" in spec or spec.endswith(".toml") else motorcycles.load(spec)
    if "speed" not in found.inputs:
        raise InputError(f"{spec!r} is a {found.title}, not a vehicle (valid: {', '.join(motorcycles.names())})")
    return found


def devices(specs: str) -> list[Component]:
    """The devices at a vehicle's ports, a comma list of names; none for `none`. Raises InputError for what is no device."""
    found = [device(spec.strip()) for spec in specs.split(",")]
    return [each for each in found if each is not None]


def device(spec: str) -> Component | None:
    """The device at the handlebar or at the saddle of that name; None for `none`. Raises InputError when it is something else."""
    if spec == "none":
        return None
    found = component(spec)
    if not answers_a_port(found.outputs):
        choices = [f"rider:{n}" for n in riders.names() if answers_a_port(COMPONENTS[riders.contents(n)["component"]]().outputs)] + [f"damper:{n}" for n in dampers.names()]
        raise InputError(f"{spec!r} is a {found.title}, not a device of a vehicle (valid: none, damper:VALUE, {', '.join(choices)})")
    return found


def answers_a_port(outputs: Iterable[str]) -> bool:
    """Whether something answers the torques of the handlebar port or of the roll port."""
    return set(TORQUES) <= set(outputs) or set(FLOWS) <= set(outputs)


def assignments(texts: Iterable[str]) -> dict[str, float]:
    """`NAME=VALUE` texts as a dictionary. Raises InputError for what is not one."""
    values = {}
    for text in texts:
        name, equals, value = text.partition("=")
        try:
            values[name.strip()] = float(value)
        except ValueError:
            equals = ""
        if not equals:
            raise InputError(f"{text!r} is not NAME=VALUE with a number, as in arm_damping=20")
    return values


def with_settings(parts: dict[str, Component | None], settings: dict[str, float]) -> list[Component | None]:
    """The parts with parameters set by name, or by `part.name` where several parts have it."""
    changed: dict[str, dict[str, float]] = {part: {} for part in parts}
    parameters = {part: c.rows("parameter") if c else {} for part, c in parts.items()}
    for key, value in settings.items():
        part, dot, name = key.partition(".")
        owners = [part] if dot and part in parts and name in parameters[part] else []
        owners = owners or [p for p in parts if key in parameters[p]]
        if not owners:
            raise unknown("parameter", key, {n for rows in parameters.values() for n in rows})
        if len(owners) > 1:
            raise InputError(f"{key!r} is a parameter of {' and '.join(owners)}: write {owners[-1]}.{key}={value:g}")
        changed[owners[0]][name if dot else key] = value
    return [c.with_values(**changed[part]) if c else None for part, c in parts.items()]


def numbers(text: str, what: str, unit: str) -> np.ndarray:
    """`A:B:STEP` with both ends, one value, or a comma list, as ascending positive numbers.

    Raises InputError that says what was expected.
    """
    form = f"{what} {text!r} is not A:B:STEP, one value or a comma list of positive ascending numbers [{unit}], as in 1:60:0.5"
    try:
        given = [float(part) for part in text.split(":" if ":" in text else ",")]
    except ValueError:
        raise InputError(form) from None
    values = np.array(given)
    if ":" in text:
        if not (len(given) == 3 and np.isfinite(given).all() and given[2] > 0 and given[1] >= given[0]):
            raise InputError(form)
        first, last, step = given
        if (last - first) / step > MOST:
            raise InputError(f"{what} {text!r} has more than {MOST:g} values; take a larger step")
        values = first + step * np.arange(int((last - first) / step + 1e-9) + 1)
        values = np.append(values, last) if values[-1] < last - 1e-9 * step else values
    if not (np.isfinite(values).all() and (values > 0).all() and (np.diff(values) > 0).all()):
        raise InputError(form)
    return values
