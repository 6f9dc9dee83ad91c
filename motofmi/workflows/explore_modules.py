"""The WebAssembly of the components in an explore page: modules that ship, and those compiled for a user's components.

A class of components has one module for all its values. The modules of the classes below ship, so that no installation
needs a compiler for them. A shipped module is used where the class has the same variables and gives the same numbers
(rates and outputs at points away from the start values) as when the module was made; otherwise it is compiled again.

    python -m motofmi.workflows.explore_modules      # writes all of them again, with ziglang
"""

import base64
import json
import tempfile
import zipfile
import zlib
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from math import isclose
from pathlib import Path
from typing import Any

import fmpy
import numpy as np

from fmus.declaration.component import Component
from fmus.export.build import build, source_contents
from fmus.export.interface import Interface
from fmus.support.errors import MissingToolError
from fmus.support.files import write_text
from fmus.support.progress import track
from motofmi.reports.explore import MODULES
from motofmi.workflows import components

IN_ARCHIVE = "binaries/wasm32-unknown-unknown/"
GENERATORS = ("sympy", "jinja2", "fmpy", "ziglang")  # packages on whose versions the bytes of a module depend
KEYS = ("token", "wasm", "states", "inputs", "outputs", "references")
POINTS, SPREAD = 2, 0.1  # of the numbers that identify equations: so many points, values changed by up to this share
TOLERANCE = 1e-9  # relative; the numbers of one expression differ by less between versions of NumPy and machines

Module = dict[str, Any]


def module_of(component: Component) -> Module:
    """The module of a component's class and effects, compressed and in base64, with the names of its variables.

    Raises MissingToolError where it neither ships nor can be compiled.
    """
    found = shipped(component)
    if found is None:
        try:
            found = compiled(component)
        except MissingToolError:
            raise MissingToolError(
                f"the WebAssembly of {component.name} is not in this installation and there is no compiler for it: "
                "pip install 'motofmi[platforms]'"
            ) from None
    return {key: found[key] for key in KEYS}


def shipped(component: Component) -> Module | None:
    """The module that ships; None where there is none or its equations or variables are others."""
    path = path_of(component.title)
    if component.effects or classes().get(component.title) is not type(component) or not path.is_file():
        return None
    found: Module = json.loads(path.read_text("utf-8"))
    return found if is_of(found, component) else None


def classes() -> dict[str, type[Component]]:
    """The classes whose modules ship, by name: those of the riders, motorcycles and dampers with value files."""
    return {each.title: type(each) for each in map(components.component, components.every_name())}


def path_of(title: str) -> Path:
    """Where the module of a class ships."""
    return MODULES / f"{title}.json"


def is_of(module: Module, component: Component) -> bool:
    """Whether a module has a component's variables and, at the module's points, its numbers."""
    same = all(set(module[kind]) == set(getattr(component, kind)) for kind in ("states", "inputs", "outputs"))
    if not same or module["bounds"] != bounds(component):
        return False
    for point in module["points"]:
        now = numbers(component, point["values"])
        if not all(isclose(now[name], then, rel_tol=TOLERANCE) for name, then in point["numbers"].items()):
            return False
    return True


def bounds(component: Component) -> dict[str, list[str]]:
    """Role, unit, least and largest value of every variable, as text."""
    return {name: [row.role, row.unit, repr(row.min), repr(row.max)] for name, row in component.table.items()}


def points(component: Component) -> list[dict[str, Any]]:
    """Values of parameters, inputs and states around the start values, and the numbers there."""
    rows, start = component.rows("parameter", "input", "state"), component.start_values()

    def drawn_value(name: str, rng: np.random.Generator) -> float:
        value = start[name] * rng.uniform(1 - SPREAD, 1 + SPREAD) if start[name] else rng.uniform(0, SPREAD)
        return float(np.clip(value, rows[name].min, rows[name].max))

    chosen = [{name: drawn_value(name, np.random.default_rng(seed)) for name in rows} for seed in range(POINTS)]
    return [{"values": values, "numbers": numbers(component, values)} for values in chosen]


def numbers(component: Component, values: Mapping[str, float]) -> dict[str, float]:
    """Rates, as der(state), and outputs at values of parameters, inputs and states."""
    changed = component.with_values(**{name: values[name] for name in component.values})
    state, inputs = (np.array([values[n] for n in names]) for names in (component.states, component.inputs))
    rates, outputs = changed.derivatives(state, inputs)
    named = [*(f"der({name})" for name in component.states), *component.outputs]
    return dict(zip(named, [*map(float, rates), *map(float, outputs)], strict=True))


def compiled(component: Component) -> Module:
    """The module of a component, compiled or from the cache of archives. Raises MissingToolError without a compiler."""
    with tempfile.TemporaryDirectory() as folder:
        path = build(component, folder, fmi=3, platforms="wasm").path
        token = fmpy.read_model_description(path).guid
        with zipfile.ZipFile(path) as archive:
            (name,) = (n for n in archive.namelist() if n.startswith(IN_ARCHIVE))
            code = archive.read(name)
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)  # without a header: `deflate-raw` of browsers
    return {
        "token": token,
        "states": list(component.states),
        "inputs": list(component.inputs),
        "outputs": list(component.outputs),
        "references": Interface(component).references,
        "wasm": base64.b64encode(packer.compress(code) + packer.flush()).decode(),
    }


def unpacked(module: Module) -> bytes:
    """The WebAssembly itself."""
    return zlib.decompress(base64.b64decode(module["wasm"]), -15)


def made_with() -> dict[str, str]:
    """The versions of the packages that generate a module."""
    return {name: version(name) for name in GENERATORS}


def token_now(component: Component) -> str:
    """The token that the module of a component would have if it were compiled now: a digest of its source code."""
    contents = source_contents(Interface(component), 3)
    return contents["modelDescription.xml"].split(b'instantiationToken="')[1].split(b'"')[0].decode()


def write(titles: Sequence[str]) -> list[Path]:
    """Compile the modules of these classes and write them to where they ship. Raises MissingToolError without
    ziglang."""
    written = []
    for title in track(titles, "WebAssembly", len(titles)):
        component = first(title)
        known = {"bounds": bounds(component), "points": points(component), "made with": made_with()}
        write_text(path_of(title), json.dumps({**compiled(component), **known}) + "\n")
        written.append(path_of(title))
    return written


def first(title: str) -> Component:
    """The first component of a class among those that ship."""
    return next(each for each in map(components.component, components.every_name()) if each.title == title)


if __name__ == "__main__":
    for path in write(sorted(p.stem for p in MODULES.glob("*.json"))):
        print(path)
