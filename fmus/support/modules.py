"""Python modules found by folder, so that a new file in the folder needs no entry elsewhere."""

import importlib
import importlib.util
import pkgutil
import traceback
from pathlib import Path
from types import ModuleType

from fmus.support.errors import InputError


def modules_in(package: str) -> list[ModuleType]:
    """The modules of a package, imported, in alphabetical order. The package is given by its dotted name."""
    path = importlib.import_module(package).__path__
    return [importlib.import_module(f"{package}.{found.name}") for found in pkgutil.iter_modules(path)]


def load_module(path: str | Path) -> ModuleType:
    """A Python file as a module. Raises InputError when the file cannot be loaded."""
    path = Path(path)
    spec = importlib.util.spec_from_file_location(path.stem, path)
    try:
        module = importlib.util.module_from_spec(spec)  # type: ignore[arg-type]
        spec.loader.exec_module(module)  # type: ignore[union-attr]
    except Exception as error:  # whatever a user's file may raise
        raise InputError(f"cannot load {place_in(path, error)}: {type(error).__name__}: {error}") from None
    return module


def place_in(path: str | Path, error: Exception) -> str:
    """A file, with the last of its lines that an exception has passed, if any: `bench.py, line 12`."""
    file, frames = Path(path).resolve(), traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if Path(frame.filename).resolve() == file]
    return f"{path}, line {lines[-1]}" if lines else str(path)
