"""What an archive follows from, without deriving anything: the key under which it is kept.

The equations in an archive are those of classes, so they follow from the source text of the modules that these
classes reach, from what the component holds (values, table, structure), and from the versions of what renders them.
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

from fmus.component import Component

RENDERERS = ("sympy", "jinja2", "fmpy", "pythonfmu")
LIBRARIES = tuple(Path(sysconfig.get_path(kind)) for kind in ("stdlib", "platstdlib", "purelib", "platlib"))


def origin(component: Component) -> str | None:
    """A digest of all that the component's archives follow from but the tools that compile them.

    None where that cannot be told: equations without a source file, made inside a function, or depending on more than
    text and numbers.
    """
    written = _written(component.structure)
    classes = {c for c in _classes(component.structure) if c is not object}
    sources = _sources(classes)
    if written is None or sources is None:
        return None
    methods = sorted(f"{c.__module__}.{c.__qualname__}.{n} {f.__qualname__} {f.__code__.co_firstlineno}" for c in classes for n, f in _functions(c))
    held = (component.name, component.source, list(component.table.items()), component.values)
    versions = [sys.version, zlib.ZLIB_RUNTIME_VERSION, *map(version, RENDERERS)]
    digest = sha256(repr((written, methods, held, versions)).encode())
    for path in sorted({*sources, *_of_this_package()}):
        digest.update(path.name.encode() + sha256(path.read_bytes()).digest())
    return digest.hexdigest()


def _of_this_package() -> Iterator[Path]:
    """All that renders: this package's own code and its C."""
    return (p for p in Path(str(files("fmus"))).rglob("*") if p.suffix in (".py", ".in", ".c", ".h"))


def _written(structure: Any) -> str | None:
    """A component's structure as text; None when something in it has no text that stands for it."""
    if isinstance(structure, type):
        return f"{structure.__module__}.{structure.__qualname__}"
    if isinstance(structure, tuple):
        parts = [_written(part) for part in structure]
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
            return None  # what the function around them held is nowhere to be read
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
