"""The catalogue of shipped components, riders, motorcycles, dampers, mechanisms and effects."""

import inspect
from dataclasses import dataclass
from typing import Any

import fmus.effects.measuring_channel
import rider_fmu.effects
from fmus.composition.value_files import Library
from fmus.declaration.component import Component
from fmus.effects import effects_in
from fmus.effects.library import declared_by
from fmus.support.errors import unknown
from fmus.support.notebook import html
from motofmi.workflows.components import COMPONENTS, LIBRARIES, VEHICLE_EFFECTS


@dataclass(frozen=True, repr=False)
class Catalogue:
    """Entries by kind (`components`, `riders`, `motorcycles`, `dampers`, `mechanisms`, `effects`), each with name,
    description and parameters.

    The parameters by name hold symbol, unit, value and bounds: their names are those that every `set` takes.

        >>> found = mf.catalogue()
        >>> sorted(found["mechanisms"])
        ['driven_joint', 'mass_spring_damper', 'pendulum', 'two_mass']
        >>> found.named("sharp_1971")
        Catalogue(0 components, 0 riders, 1 motorcycles, 0 dampers, 0 mechanisms, 0 effects)
        >>> sorted(found.to_dict())
        ['components', 'dampers', 'effects', 'mechanisms', 'motorcycles', 'riders']
        >>> list(found.to_dataframe().columns[:4])
        ['kind', 'name', 'form', 'parameter']
    """

    entries: dict[str, list[dict[str, Any]]]

    def __getitem__(self, kind: str) -> dict[str, dict[str, Any]]:
        """The entries of a kind by their names. Raises InputError for a kind that does not exist."""
        if kind not in self.entries:
            raise unknown("kind", kind, self.entries)
        return {entry["name"]: entry for entry in self.entries[kind]}

    def named(self, name: str) -> "Catalogue":
        """The entries of this name alone, as `mean_2011` or `rider:mean_2011`, of an effect in all its forms. Raises
        InputError where nothing has it."""
        of, colon, bare = name.partition(":")
        found = {kind: [e for e in entries if e["name"] == name or (colon and f"{of}s" == kind and e["name"] == bare)]
                 for kind, entries in self.entries.items()}  # fmt: skip
        if not any(found.values()):
            raise unknown("name", name, sorted({e["name"] for entries in self.entries.values() for e in entries}))
        return Catalogue(found)

    def __repr__(self) -> str:
        return f"Catalogue({', '.join(f'{len(found)} {kind}' for kind, found in self.entries.items())})"

    def _repr_html_(self) -> str:
        return html(
            "What ships",
            ("kind", "names"),
            [(kind, ", ".join(dict.fromkeys(e["name"] for e in found))) for kind, found in self.entries.items()],
        )

    def to_dict(self) -> dict[str, Any]:
        """The keys of `motofmi list --json`."""
        return self.entries

    def to_dataframe(self) -> Any:
        """One row for each parameter of a shipped component or effect (pandas.DataFrame)."""
        import pandas as pd  # noqa: PLC0415 - imported on use

        return pd.DataFrame([
            {"kind": kind, "name": entry["name"], "form": entry.get("form", ""), "parameter": name, **row}
            for kind, found in self.entries.items() for entry in found for name, row in entry["parameters"].items()
        ])  # fmt: skip


def catalogue() -> Catalogue:
    """The shipped components and effects, by kind; values and bounds in SI units.

        >>> mf.catalogue()["riders"]["mean_2011"]["parameters"]["arm_damping"]["unit"]
        'N.m.s/rad'
    """
    return Catalogue({
        "components": [_class(c) for c in COMPONENTS.values()],
        **{f"{kind}s": [_instance(library, name) for name in library.names()] for kind, library in LIBRARIES.items()},
        "effects": effects(),
    })


def effects() -> list[dict[str, Any]]:
    """The effects of riders, vehicles and measuring channels that ship: name, form, sentence, parameters and
    where each is declared."""
    return [{"name": e.family, "form": e.form, "description": e.sentence(), "element": e.element,
             "source": e.__module__, "parameters": {n: {"unit": r.unit, "symbol": r.symbol, "value": r.start,
                                                        "min": r.min, "max": r.max, "description": r.description}
                            for n, r in e.parameters().items()}}
            for e in [*effects_in(rider_fmu.effects), *VEHICLE_EFFECTS,
                      *declared_by(fmus.effects.measuring_channel)]]  # fmt: skip


def _class(kind: type[Component]) -> dict[str, Any]:
    component = kind()
    return {"name": kind.__name__, "description": (inspect.getdoc(kind) or "").splitlines()[0],
            "parameters": _parameters(component), "inputs": list(component.inputs), "outputs": list(component.outputs),
            "states": list(component.states)}  # fmt: skip


def _instance(library: Library, name: str) -> dict[str, Any]:
    component, contents = library.load(name), library.contents(name)
    return {"name": name, "component": component.title, "description": contents.get("description", ""),
            "source": component.source, "assumed": component.assumed, "parameters": _parameters(component)}  # fmt: skip


def _parameters(component: Component) -> dict[str, Any]:
    return {
        name: {"value": component.values[name], "unit": row.unit, "symbol": row.symbol, "min": row.min, "max": row.max,
               "description": row.description, "assumed": component.assumed.get(name)}
        for name, row in component.rows("parameter").items()
    }  # fmt: skip
