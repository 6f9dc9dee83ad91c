"""Public names of a package that are imported when they are first used, so that to import the package is fast."""

import sys
from collections.abc import Callable, Mapping, Sequence
from difflib import get_close_matches
from importlib import import_module
from typing import Any


def on_use(
    package: str, names: Mapping[str, Sequence[str]]
) -> tuple[list[str], Callable[[str], Any], Callable[[], list[str]]]:
    """`__all__`, `__getattr__` and `__dir__` of a package whose names are those of other modules, by module."""
    module_of = {name: module for module, found in names.items() for name in found}
    every = sorted(module_of)

    def get(name: str) -> Any:
        if name not in module_of:
            near = get_close_matches(name, every, n=1)
            hint = f", did you mean {near[0]!r}?" if near else ""
            raise AttributeError(f"module {package!r} has no name {name!r}{hint} (valid: {', '.join(every)})")
        found = getattr(import_module(module_of[name]), name)
        setattr(sys.modules[package], name, found)
        return found

    return every, get, lambda: sorted({*vars(sys.modules[package]), *every})
