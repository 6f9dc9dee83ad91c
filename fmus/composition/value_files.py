"""Values from files: a `.toml` names a component, gives its parameters with units, and says where they are from.

    component = "PassiveRider"
    component_file = "mine.py"                  # where its class is, relative to this file, if it does not ship
    effects = ["coulomb_friction.coulomb"]      # family.form, if any; their parameters are "family.name"
    effects_folder = "mine"                     # where those are that do not ship, relative to this file
    description = "..."
    source = "..."
    [parameters]
    arm_stiffness = { value = 1053.4, unit = "N.m/rad" }     # or a bare number in the declared unit
    arm_damping = { value = 30.0, unit = "N.m.s/rad", assumed = "only bounded from below" }
    waist_damping = { value = 4.8, unit = "N.m.s/rad", standard_error = 0.1 }
    [correlation.arm_stiffness]
    waist_damping = -0.3         # of the errors, where the values were identified together
    [printed]    numbers of the source to compare with
    [about]      anything else that is known
"""

import json
import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from fmus.component import Component
from fmus.effects import Effect, load_folder
from fmus.errors import InputError, unknown
from fmus.units import convert
from fmus.variables import Variable

SECTIONS = ("component", "component_file", "effects", "effects_folder", "description", "source", "parameters", "correlation", "printed", "about")
ENTRY = ("value", "unit", "assumed", "standard_error")


@dataclass(frozen=True)
class Library:
    """A folder of value files and the components that they may name, under one word (`rider`)."""

    kind: str
    folder: Path
    components: Mapping[str, type[Component]]

    def names(self) -> list[str]:
        """The names in the folder, numbers in numerical order."""
        return sorted((p.stem for p in self.folder.glob("*.toml")),
                      key=lambda n: [(not t.isdigit(), int(t) if t.isdigit() else 0, t) for t in reversed(n.split("_"))])  # fmt: skip

    def contents(self, name: str | Path) -> dict[str, Any]:
        """The file of that name, or at that path, as it stands. Raises InputError when there is none."""
        path = Path(name)
        if path.suffix != ".toml":
            path = self.folder / f"{name}.toml"
            if path.stem not in self.names():
                raise unknown(self.kind, name, self.names())
        return read_values(path)

    def load(self, name: str | Path, **values: float) -> Component:
        """The component with the file's values, some of them replaced. Its name is `kind_name`."""
        contents = self.contents(name)
        return component_from(contents, self.components, f"{self.kind}_{Path(name).stem}", str(name)).with_values(**values)


@lru_cache(maxsize=256)
def _parsed(path: Path, modified: float) -> dict[str, Any]:
    try:
        contents = tomllib.loads(path.read_text("utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path} is not a valid TOML file: {error}") from None
    for key in contents:
        if key not in SECTIONS:
            raise InputError(str(unknown("key", key, SECTIONS)) + f" in {path.name}")
    if not isinstance(contents.get("parameters", {}), dict):
        raise InputError(f"{path.name}: parameters is not a table, as in [parameters] and then a line for each")
    return contents


def read_values(path: Path) -> dict[str, Any]:
    """The contents of a value file. Raises InputError for a file that is missing, broken or has unknown keys."""
    try:
        return _parsed(path, path.stat().st_mtime)
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from None


def value_file(component: str, parameters: Mapping[str, tuple[float, float | None, str]], description: str, source: str,
               effects: Sequence[type[Effect]] = (), component_file: str | None = None, effects_folder: str | None = None) -> str:  # fmt: skip
    """The text of a value file. parameters hold (value, standard error if known, unit); folders are written as absolute paths."""
    words = {"component": component, "component_file": _absolute(component_file), "effects_folder": _absolute(effects_folder),
             "description": description, "source": source}  # fmt: skip
    lines = [f"{key} = {_quoted(text)}" for key, text in words.items() if text is not None]
    if effects:
        lines.append(f"effects = {json.dumps([f'{e.family}.{e.form}' for e in effects])}")
    lines += ["", "[parameters]"]
    for name, (value, error, unit) in parameters.items():
        known = f", standard_error = {float(error)!r}" if error is not None and math.isfinite(error) else ""
        lines.append(f"{_quoted(name)} = {{ value = {float(value)!r}, unit = {_quoted(unit)}{known} }}")
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    """A string of TOML, which has JSON's escapes but bars one more character."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _absolute(path: str | None) -> str | None:
    return None if path is None else Path(path).resolve().as_posix()


def component_from(contents: Mapping[str, Any], components: Mapping[str, type[Component]], name: str, file: str,
                   effects: Sequence[type[Effect]] = ()) -> Component:  # fmt: skip
    """The component that the contents of a value file describe, with effects from those that are given."""
    if contents.get("component") not in components:
        raise unknown(f"component in {file}", contents.get("component"), components)
    kind = components[contents["component"]]
    values, assumed, errors = {}, {}, {}
    joined = _effects(contents, effects, file)
    table = kind(name, "", joined).rows("parameter")
    parameters = list(table)
    for key, entry in contents.get("parameters", {}).items():
        if key not in parameters:
            raise InputError(f"{file}: {unknown('parameter', key, parameters)}")
        row = table[key]
        if not isinstance(entry, Mapping):
            entry = {"value": entry}
        for word in entry:
            if word not in ENTRY:
                raise InputError(f"{file}: {unknown(f'key of {key}', word, ENTRY)}")
        values[key] = _number(entry, "value", row, file)
        if "assumed" in entry:
            assumed[key] = entry["assumed"]
        if "standard_error" in entry:
            errors[key] = _number(entry, "standard_error", row, file)
    component = kind(name, contents.get("source", ""), joined, **values)
    component.assumed, component.standard_error = assumed, errors
    component.correlation = _correlation(contents.get("correlation", {}), errors, file)
    return component


def _effects(contents: Mapping[str, Any], effects: Sequence[type[Effect]], file: str) -> tuple[Effect, ...]:
    if contents.get("effects_folder"):
        effects = [*effects, *load_folder(Path(file).parent / contents["effects_folder"])]
    known = {f"{e.family}.{e.form}": e for e in effects}
    for name in contents.get("effects", []):
        if name not in known:
            raise InputError(f"{file}: {unknown('effect', name, known)}")
    return tuple(known[name]() for name in contents.get("effects", []))


def _number(entry: Mapping[str, Any], word: str, row: Variable, file: str) -> float:
    """One of the numbers of a parameter's entry, in the declared unit."""
    if type(entry.get(word)) not in (int, float):  # true is a number to Python, not to physics
        raise InputError(f"{file}: {row.name} needs a number [{row.unit}], as in {row.name} = {{ value = 1.0, unit = \"{row.unit}\" }}")
    try:
        return convert(entry[word], str(entry.get("unit", row.unit)), row.unit)
    except InputError as error:
        raise InputError(f"{file}: {row.name}: {error}") from None


def _correlation(given: Mapping[str, Mapping[str, float]], errors: Mapping[str, float], file: str) -> dict[str, dict[str, float]]:
    """The correlations of the errors by pairs of parameters, as they stand, once they are known to make sense."""
    for first, row in given.items():
        for second, value in row.items():
            for name in (first, second):
                if name not in errors:
                    raise InputError(f"{file}: {unknown('parameter with a standard_error in [correlation]', name, errors)}")
            if not (isinstance(value, (int, float)) and -1 <= value <= 1):
                raise InputError(f"{file}: correlation of {first} and {second} is {value!r}, expected a number from -1 to 1")
    return {first: dict(row) for first, row in given.items()}
