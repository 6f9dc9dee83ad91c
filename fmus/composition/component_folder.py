"""Components found by folder: each public class that a file of the folder defines is registered under its name.

    COMPONENTS = components_in("rider_fmu.components", "rider_fmu.rigs")

A base class that defines no equations, and a class whose name starts with an underscore, are not components.
"""

from types import ModuleType

from fmus.declaration.component import Component
from fmus.support.errors import InputError
from fmus.support.modules import modules_in


def components_in(*packages: str) -> dict[str, type[Component]]:
    """Component classes by name, in the order of the packages, then of their files, then of definition.

    Raises InputError where two files define components of the same name.
    """
    found: dict[str, type[Component]] = {}
    for package in packages:
        for module in modules_in(package):
            for kind in components_of(module):
                if kind.__name__ in found:
                    places = f"{found[kind.__name__].__module__} and in {kind.__module__}"
                    raise InputError(f"component {kind.__name__} is defined in {places}; rename one")
                found[kind.__name__] = kind
    return found


def components_of(module: ModuleType) -> list[type[Component]]:
    """The components that a module defines itself, in the order of definition."""
    return [c for name, c in vars(module).items()
            if isinstance(c, type) and issubclass(c, Component) and c.__module__ == module.__name__
            and not name.startswith("_") and c.equations is not Component.equations]  # fmt: skip
