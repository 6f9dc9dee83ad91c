"""Effects found by folder: every class with a family that a file of the folder declares.

A new effect needs no entry elsewhere.
"""

import inspect
from collections.abc import Iterable
from dataclasses import fields
from pathlib import Path
from types import ModuleType

from fmus.declaration.component import RECORDED, Component, Scope
from fmus.declaration.elements import Element
from fmus.effects.effect import Effect
from fmus.equations.sympy_form import symbolic
from fmus.support.errors import InputError, NotApplicableError, unknown
from fmus.support.modules import load_module, modules_in

WORDS = tuple(f.name for f in fields(Element))


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
    """Those of the effects that apply to the component. Raises InputError as `obstacle` does."""
    return [effect for effect in effects if not obstacle(component, effect)]


def obstacle(component: Component, effect: type[Effect]) -> str:
    """Why an effect does not apply to a component: the target, element or variable that it lacks; empty where it does.

    Raises InputError with the effect, its file and the name where its terms read what no component has.
    """
    try:
        symbolic(component.with_effects(effect()))
    except NotApplicableError as error:
        return str(error)
    except AttributeError as error:
        if isinstance(error.obj, Scope) and error.name:
            if error.name.removesuffix(RECORDED) in {*_declared_names(Component), *_words_of(effect)}:
                return str(error)
            valid = {*effect.declared, *_words_at(component, effect), *component.table}
            reason = str(unknown("name in its terms", error.name, valid))
        else:
            reason = f"{type(error).__name__}: {error}"
        raise InputError(f"effect {effect.family}.{effect.form} of {_file(effect)}: {reason}") from error
    return ""


def _declared_names(kind: type[Component]) -> set[str]:
    """The variables that a class of components and its subclasses declare."""
    return set(kind.declared).union(*map(_declared_names, kind.__subclasses__()))


def _words_of(effect: type[Effect]) -> set[str]:
    """The words for the variables of the elements of an effect."""
    return {word + end for word in WORDS for end in ("", *(f"_{alone.element}" for alone in effect.at_one))}


def _words_at(component: Component, effect: type[Effect]) -> Iterable[str]:
    return effect.words_at(component, effect.element) if effect.element and not effect.at_one else ()


def _file(effect: type[Effect]) -> str:
    """The file of the class: modules of a user's folder are in no table of modules."""
    functions = (member.__code__ for member in vars(effect).values() if inspect.isfunction(member))
    return next((code.co_filename for code in functions), effect.__module__)
