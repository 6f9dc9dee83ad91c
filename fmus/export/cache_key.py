"""The cache key of a component's archives, computed without generating them.

An archive is determined by the source text of the modules that the component's classes use, by the component's data
(values, table, structure), and by the versions of the packages that generate the archive.
"""

import sys
import sysconfig
import zlib
from collections.abc import Iterator
from hashlib import sha256
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

from fmus.declaration.component import Component

GENERATORS = ("sympy", "jinja2", "fmpy", "pythonfmu")
LIBRARIES = tuple(Path(sysconfig.get_path(kind)) for kind in ("stdlib", "platstdlib", "purelib", "platlib"))


def cache_key(component: Component) -> str | None:
    """A digest of everything that determines the component's archives, except the compilers.

    None where it cannot be determined: equations without a source file, defined inside a function, or depending on
    objects other than text and numbers.
    """
    structure = _structure_text(component.structure)
    classes = {c for c in _classes(component.structure) if c is not object}
    sources = _sources(classes)
    if structure is None or sources is None:
        return None
    methods = sorted(
        f"{c.__module__}.{c.__qualname__}.{n} {f.__qualname__} {f.__code__.co_firstlineno}"
        for c in classes
        for n, f in _functions(c)
    )
    held = (component.name, component.source, list(component.table.items()), component.values)
    versions = [sys.version, zlib.ZLIB_RUNTIME_VERSION, *map(version, GENERATORS)]
    digest = sha256(repr((structure, methods, held, versions)).encode())
    for path in sorted({*sources, *_of_this_package()}):
        digest.update(path.name.encode() + sha256(path.read_bytes()).digest())
    return digest.hexdigest()


def _of_this_package() -> Iterator[Path]:
    """All files that generate archives: this package's Python, C and templates."""
    return (p for p in Path(str(files("fmus"))).rglob("*") if p.suffix in (".py", ".in", ".c", ".h"))


def _structure_text(structure: Any) -> str | None:
    """A component's structure as text; None where a part has no text that identifies it."""
    if isinstance(structure, type):
        return f"{structure.__module__}.{structure.__qualname__}"
    if isinstance(structure, tuple):
        parts = [_structure_text(part) for part in structure]
        return None if None in parts else f"({', '.join(map(str, parts))})"
    return repr(structure) if isinstance(structure, (str, int, float, type(None))) else None


def _classes(structure: Any) -> Iterator[type]:
    if isinstance(structure, type):
        yield from structure.__mro__
    elif isinstance(structure, tuple):
        for part in structure:
            yield from _classes(part)


def _functions(owner: type) -> Iterator[tuple[str, FunctionType]]:
    for name, member in vars(owner).items():
        plain = getattr(member, "fget", None) or getattr(member, "__func__", None) or member
        if isinstance(plain, FunctionType):
            yield name, plain


def _sources(classes: set[type]) -> set[Path] | None:
    """The source files that the methods of the classes reach through the names in their modules, libraries left out."""
    found: set[Path] = set()
    own = {c.__module__.partition(".")[0] for c in classes}
    pending: list[dict[str, Any] | None] = []
    for each in classes:
        functions = [f for _, f in _functions(each)]
        if any(set(f.__code__.co_freevars) - {"__class__"} for f in functions):
            return None  # values of an enclosing function are not in any file
        pending += [f.__globals__ for f in functions] or [_namespace(each)]
    seen: set[int] = set()
    while pending:
        names = pending.pop()
        if names is None:
            return None
        if id(names) in seen:
            continue
        seen.add(id(names))
        path, ours = Path(names.get("__file__") or ""), names.get("__name__", "").partition(".")[0] in own
        if ours and path.suffix != ".py":
            return None
        if ours or (path.suffix == ".py" and not any(path.is_relative_to(folder) for folder in LIBRARIES)):
            found.add(path)
            pending += [reached for value in list(names.values()) if (reached := _namespace(value)) is not None]
    return found


def _namespace(value: Any) -> dict[str, Any] | None:
    """The names of the module that a value is, or is from."""
    if isinstance(value, ModuleType):
        return vars(value)
    if isinstance(value, FunctionType):
        return value.__globals__
    module = sys.modules.get(getattr(value, "__module__", None) or type(value).__module__)
    return None if module is None else vars(module)
