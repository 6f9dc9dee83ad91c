"""The explore page of a study of modes, and the address in it that reproduces a run.

In an address B is the run: its vehicle, its devices with the values of the run, the mode and the speed. A is the same
vehicle and devices with their own values, or the vehicle alone where the run changes no value.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

from fmus.declaration.component import Component
from fmus.support.errors import InputError, MissingToolError
from motofmi.workflows.components import COMPONENTS, EFFECTS
from motofmi.workflows.explore import device_names, explore_page, shown_name
from motofmi.workflows.sweep.populations import RIDER
from vehicle_fmu.ridden import by_name

FILE = "explore.html"
SPEEDS = (1.0, 60.0)  # m/s, of the page
Held = Sequence[Component] | None  # the devices of a set, the rider first; None where the page cannot show them


@dataclass(frozen=True)
class StudyPage:
    """The vehicles and sets of devices of a study; those that the page cannot show are None."""

    vehicles: Sequence[Component | None]
    sets: Sequence[Held]
    description: Mapping[str, Any]

    @classmethod
    def of(cls, description: Mapping[str, Any]) -> "StudyPage":
        """The parts of a study from its description."""
        rider = description["rider"]
        first = [] if rider is None else [component_of({**rider, "name": _population(description)})]
        sets = [[*first, *map(component_of, held)] for held in description["device"]]
        able = [None if None in held else [part for part in held if part] for held in sets]
        return cls([component_of(v) for v in description["vehicle"]], able, description)

    def write(self, path: Path) -> str:
        """Write the page; the reason where it cannot be, otherwise an empty text."""
        vehicles = [part for part in self.vehicles if part]
        sets = [held for held in self.sets if held is not None]
        if not vehicles or not sets:
            return "its vehicle or devices are FMUs of other tools, or components that do not ship"
        different: dict[str, Component] = {}
        for part in (*vehicles, *(part for held in sets for part in held)):
            if different.setdefault(shown_name(part), part).values != part.values:
                return f"two of its parts have the name {shown_name(part)}"
        try:
            explore_page(path, vehicles, [[], *sets])
        except (InputError, MissingToolError) as error:
            return str(error)
        return ""

    def address(self, row: Mapping[str, Any], mode: str, speed: float) -> str:
        """What follows the page's path for the run of a row of the table; empty where the page cannot show it."""
        labels = self.description["labels"]
        vehicle = self.vehicles[labels["vehicle"].index(row["vehicle"])]
        held = self.sets[labels["device"].index(row["device"])]
        if vehicle is None or held is None:
            return ""
        values = [f"{part}.{name}:{value!r}" for (part, name), value in self._changes(row, vehicle, held).items()]
        devices = device_names(held)
        own = f"{shown_name(vehicle)};{devices if values else 'none'}"
        run = ";".join([shown_name(vehicle), devices, *values])
        low, high = SPEEDS
        state = {"view": "locus", "speed": f"{min(max(speed, low), high):g}", "edit": "B", "side": "B", "mode": mode,
                 "A": own, "B": run}  # fmt: skip
        return "#" + "&".join(f"{key}={quote(text, safe=';:,')}" for key, text in state.items())

    def _changes(
        self, row: Mapping[str, Any], vehicle: Component, held: Sequence[Component]
    ) -> dict[tuple[str, str], float]:
        """The values of a run that differ from those of the parts, by the page's name of the part and by parameter."""
        parts = {"vehicle": vehicle, **by_name(held)}
        rides = self.description["rider"] is not None
        in_page = dict(zip([*([RIDER] if rides else []), *by_name(held[rides:])], by_name(held), strict=True))
        changes = {}
        for key in self.description["varied"]:
            part, _, name = key.partition(".")
            value, place = float(row[key if key in row else name]), in_page.get(part, part)
            if parts[place].values[name] != value:
                changes[place, name] = value
        return changes


def component_of(contents: Mapping[str, Any]) -> Component | None:
    """The component that a study's description identifies; None for an FMU, and for a class or effect of a user."""
    kind = COMPONENTS.get(contents.get("component", ""))
    if kind is None:
        return None
    known = {effect.__name__: effect for effect in EFFECTS.get(kind.__name__, ())}
    if not set(contents["effects"]) <= known.keys():
        return None
    return kind(contents["name"], "", [known[name]() for name in contents["effects"]], **contents["values"])


def _population(description: Mapping[str, Any]) -> str:
    """The name of the population, under which the page shows a member."""
    return Path(description["set"][RIDER].lstrip("~")).stem
