"""Value files: a `.toml` names a component class and gives its parameters with units and their source.

    component = "PassiveRider"
    component_file = "mine.py"                  # file of a class of your own, relative to this file
    effects = ["coulomb_friction.coulomb"]      # family.form; their parameters are "family.name"
    effects_folder = "mine"                     # folder of effects of your own, relative to this file
    description = "..."
    source = "..."
    [parameters]
    arm_stiffness = { value = 1053.4, unit = "N.m/rad" }     # or a bare number in the declared unit
    arm_damping = { value = 30.0, unit = "N.m.s/rad", assumed = "only bounded from below" }
    waist_damping = { value = 4.8, unit = "N.m.s/rad", standard_error = 0.1 }
    [correlation.arm_stiffness]
    waist_damping = -0.3         # of the errors of parameters that were identified together
    [supplement]    numbers for analyses beyond the component's equations, as under [parameters], in SI units
    [printed]    numbers of the source to compare with
    [about]      anything else that is known

Reading a file with `component_file` executes that Python file, and reading one that names `effects` executes every
Python file of its `effects_folder` (SECURITY.md). Without these two keys nothing is executed.
"""

import json
import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from fmus.declaration.component import Component
from fmus.declaration.units import convert
from fmus.declaration.variables import Variable
from fmus.effects import Effect, load_folder
from fmus.support.errors import InputError, unknown

SECTIONS = (
    "component",
    "component_file",
    "effects",
    "effects_folder",
    "description",
    "source",
    "parameters",
    "correlation",
    "supplement",
    "printed",
    "about",
)
ENTRY = ("value", "unit", "assumed", "standard_error")


@dataclass(frozen=True, repr=False)
class Library:
    """A folder of value files, the component classes that they may name, and the kind of these (`rider`).

        riders.load("mean_2011", arm_damping=20.0)
    """

    kind: str
    folder: Path
    components: Mapping[str, type[Component]]

    def __repr__(self) -> str:
        return f"Library({self.kind!r}, {len(self.names())} names: {', '.join(self.names())})"

    def names(self) -> list[str]:
        """The names of the files, numbers in numerical order."""

        def by_number(name: str) -> list[tuple[bool, int, str]]:
            return [(not t.isdigit(), int(t) if t.isdigit() else 0, t) for t in reversed(name.split("_"))]

        return sorted((p.stem for p in self.folder.glob("*.toml")), key=by_number)

    def contents(self, name: str | Path) -> dict[str, Any]:
        """The parsed file of that name or path. Raises InputError when there is none, or the file is invalid."""
        path = Path(name)
        if path.suffix != ".toml":
            path = self.folder / f"{name}.toml"
            if path.stem not in self.names():
                raise unknown(self.kind, name, self.names())
        return read_values(path)

    def load(self, name: str | Path, **values: float) -> Component:
        """The component with the values of the file, some of them replaced (SI). Its name is `kind_name`.

        Raises InputError for an unknown name, key or parameter and for a value outside its bounds.
        """
        contents = self.contents(name)
        return component_from(contents, self.components, f"{self.kind}_{Path(name).stem}", str(name)).with_values(
            **values
        )


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
        raise InputError(
            f"{path.name}: parameters is not a table; write [parameters] and below it one line for each parameter"
        )
    return contents


def read_values(path: Path) -> dict[str, Any]:
    """The parsed value file. Raises InputError for a file that is missing, is not TOML, or has unknown keys."""
    try:
        return _parsed(path, path.stat().st_mtime)
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from None


def value_file(component: str, parameters: Mapping[str, tuple[float, float | None, str]], description: str, source: str,
               effects: Sequence[type[Effect]] = (), component_file: str | None = None,
               effects_folder: str | None = None) -> str:  # fmt: skip
    """The text of a value file. parameters maps names to (value, standard error or None, unit); paths are written
    absolute.
    """
    words = {"component": component, "component_file": _absolute(component_file),
             "effects_folder": _absolute(effects_folder), "description": description, "source": source}  # fmt: skip
    lines = [f"{key} = {_quoted(text)}" for key, text in words.items() if text is not None]
    if effects:
        lines.append(f"effects = {json.dumps([f'{e.family}.{e.form}' for e in effects])}")
    lines += ["", "[parameters]"]
    for name, (value, error, unit) in parameters.items():
        known = f", standard_error = {float(error)!r}" if error is not None and math.isfinite(error) else ""
        lines.append(f"{_quoted(name)} = {{ value = {float(value)!r}, unit = {_quoted(unit)}{known} }}")
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    """A TOML string: a JSON string with DEL escaped as well."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _absolute(path: str | None) -> str | None:
    return None if path is None else Path(path).resolve().as_posix()


def component_from(contents: Mapping[str, Any], components: Mapping[str, type[Component]], name: str, file: str,
                   effects: Sequence[type[Effect]] = ()) -> Component:  # fmt: skip
    """The component that a parsed value file describes. `effects` are those that the file may name.

    Raises InputError, with the name of the file, for everything that is unknown or out of bounds.
    """
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
    component.supplement = {key: _plain(key, entry, file) for key, entry in contents.get("supplement", {}).items()}
    component.correlation = _correlation(contents.get("correlation", {}), errors, file)
    return component


def _plain(name: str, entry: Any, file: str) -> float:
    """A number under [supplement], which no component declares."""
    number: Any = entry.get("value") if isinstance(entry, Mapping) else entry
    if type(number) not in (int, float) or not math.isfinite(number):
        raise InputError(f"{file}: {name} under [supplement] needs a finite number, not {number!r}")
    return float(number)


def _effects(contents: Mapping[str, Any], effects: Sequence[type[Effect]], file: str) -> tuple[Effect, ...]:
    # A fitted model has the folder of the search even if no effect was found: nothing in it is needed then.
    if contents.get("effects") and contents.get("effects_folder"):
        effects = [*effects, *load_folder(Path(file).parent / contents["effects_folder"])]
    known = {f"{e.family}.{e.form}": e for e in effects}
    for name in contents.get("effects", []):
        if name not in known:
            raise InputError(f"{file}: {unknown('effect', name, known)}")
    return tuple(known[name]() for name in contents.get("effects", []))


def _number(entry: Mapping[str, Any], word: str, row: Variable, file: str) -> float:
    """One number of a parameter's entry, converted to the declared unit."""
    if type(entry.get(word)) not in (int, float):  # bool is a subclass of int
        raise InputError(
            f'{file}: {row.name} needs a number [{row.unit}], as in {row.name} = {{ value = 1.0, unit = "{row.unit}" }}'
        )
    try:
        return convert(entry[word], str(entry.get("unit", row.unit)), row.unit)
    except InputError as error:
        raise InputError(f"{file}: {row.name}: {error}") from None


def _correlation(
    given: Mapping[str, Mapping[str, Any]], errors: Mapping[str, float], file: str
) -> dict[str, dict[str, float]]:
    """The correlations by pairs of parameters, after a check of names and range."""
    for first, row in given.items():
        for second, value in row.items():
            for name in (first, second):
                if name not in errors:
                    raise InputError(
                        f"{file}: {unknown('parameter with a standard_error in [correlation]', name, errors)}"
                    )
            if not (isinstance(value, (int, float)) and -1 <= value <= 1):
                raise InputError(
                    f"{file}: correlation of {first} and {second} is {value!r}, expected a number from -1 to 1"
                )
    return {first: dict(row) for first, row in given.items()}
