"""Effects found by folder: every class with a family that a file of the folder declares.

A new effect needs no entry elsewhere.
"""

import inspect
from collections.abc import Iterable
from pathlib import Path
from types import ModuleType

from fmus.declaration.component import Component
from fmus.effects.effect import Effect
from fmus.equations.sympy_form import symbolic
from fmus.support.errors import InputError
from fmus.support.modules import load_module, modules_in


def effects_in(package: ModuleType) -> list[type[Effect]]:
    """The effects that the modules of a package declare, in the order of the files and of the class names."""
    return [effect for module in modules_in(package.__name__) for effect in declared_by(module)]


def load_folder(folder: str | Path) -> list[type[Effect]]:
    """The effects in the Python files of a folder. Raises InputError without any, or when a file cannot be loaded."""
    found = []
    for path in sorted(Path(folder).glob("*.py")):
        found += declared_by(load_module(path))
    if not found:
        raise InputError(
            f"no effect in {folder}: expected Python files with subclasses of fmus.Effect that have a family"
        )
    return found


def declared_by(module: ModuleType) -> list[type[Effect]]:
    """The effects with a family that a module declares itself, by class name."""
    return [c for _, c in inspect.getmembers(module, inspect.isclass)
            if issubclass(c, Effect) and c.family and c.__module__ == module.__name__]  # fmt: skip


def applicable_effects(component: Component, effects: Iterable[type[Effect]]) -> list[type[Effect]]:
    """Those of the effects whose targets, elements and variables the component has."""
    found = []
    for effect in effects:
        try:
            symbolic(component.with_effects(effect()))
        except (InputError, AttributeError):  # the component lacks a target, an element or a variable
            continue
        found.append(effect)
    return found
