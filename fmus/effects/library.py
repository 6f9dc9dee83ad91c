"""Effects by the folder: every file in it may declare some, and dropping a file into it is all that adding one takes."""

import importlib
import importlib.util
import inspect
import pkgutil
from collections.abc import Iterable
from pathlib import Path
from types import ModuleType

from fmus.component import Component
from fmus.effects.effect import Effect
from fmus.errors import InputError
from fmus.symbolic import symbolic


def effects_in(package: ModuleType) -> list[type[Effect]]:
    """The effects with a family that the modules of a package declare, in the order of their families and files."""
    modules = [importlib.import_module(f"{package.__name__}.{found.name}") for found in pkgutil.iter_modules(package.__path__)]
    return [effect for module in modules for effect in declared_by(module)]


def load_folder(folder: str | Path) -> list[type[Effect]]:
    """The effects in the Python files of a folder. Raises InputError when there is none, or a file cannot be loaded."""
    found = []
    for path in sorted(Path(folder).glob("*.py")):
        found += declared_by(load_module(path))
    if not found:
        raise InputError(f"no effect in {folder}: expected Python files with classes of fmus.Effect that have a family")
    return found


def load_module(path: str | Path) -> ModuleType:
    """The Python file as a module. Raises InputError when it cannot be loaded."""
    path = Path(path)
    spec = importlib.util.spec_from_file_location(path.stem, path)
    try:
        module = importlib.util.module_from_spec(spec)  # type: ignore[arg-type]
        spec.loader.exec_module(module)  # type: ignore[union-attr]
    except Exception as error:  # whatever a user's file may raise
        raise InputError(f"cannot load {path}: {type(error).__name__}: {error}") from None
    return module


def declared_by(module: ModuleType) -> list[type[Effect]]:
    """The effects with a family that a module declares itself."""
    return [c for _, c in inspect.getmembers(module, inspect.isclass)
            if issubclass(c, Effect) and c.family and c.__module__ == module.__name__]  # fmt: skip


def joining(component: Component, effects: Iterable[type[Effect]]) -> list[type[Effect]]:
    """Those of the effects for which the component has the words that they say."""
    found = []
    for effect in effects:
        try:
            symbolic(component.with_effects(effect()))
        except (InputError, AttributeError):  # a target, an element or a quantity that it lacks
            continue
        found.append(effect)
    return found
