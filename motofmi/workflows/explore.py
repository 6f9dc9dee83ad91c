"""One page that works offline: root loci with sliders, the mode animated, and the compiled components themselves.

The page holds the WebAssembly of every class of components that it offers. From that come the linear systems (the
exact Jacobian) and the live co-simulation; parameters are set in the compiled component.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from math import isinf
from pathlib import Path
from typing import Any, TypeVar

from fmus.declaration.component import Component
from fmus.support.errors import InputError
from fmus.support.files import writable
from fmus.support.progress import track
from fmus.support.published import table
from motofmi.reports.explore import LARGEST, write_page
from motofmi.reports.shown import FRAME
from motofmi.version import __version__
from motofmi.workflows import components, explore_modules
from motofmi.workflows.components import ComponentLike, DeviceSet
from motofmi.workflows.explore_fmus import LinearisedFmu, linearised_fmu
from motofmi.workflows.titles import displayed
from vehicle_fmu import motorcycles, ridden
from vehicle_fmu.published import MEIJAARD_2007_EIGENVALUES, MODES_2011, SHARP_1971_EIGENVALUES

VEHICLE = "sharp_1971"
DEVICES: tuple[ComponentLike | None, ...] = (None, "rider:mean_2011")
Device = Component | LinearisedFmu
Part = TypeVar("Part", bound=Device)
FOOT = 0.3048  # m
HEIGHT = 900  # px, of the page in a notebook


@dataclass(frozen=True)
class ExplorePage:
    """The page that was written: its path, its size in bytes, and the names of what it offers; `explore` shows
    an example.

    A notebook displays the page itself.
    """

    path: Path
    size: int
    vehicles: tuple[str, ...]
    devices: tuple[str, ...]

    def _repr_html_(self) -> str:
        return FRAME.format(escape(self.path.read_text("utf-8")), HEIGHT, "motofmi explore")

    def to_dict(self) -> dict[str, Any]:
        """The keys of `motofmi explore --json`."""
        return {
            "page": str(self.path),
            "bytes": self.size,
            "vehicles": list(self.vehicles),
            "devices": list(self.devices),
        }


def explore(
    vehicle: ComponentLike = VEHICLE, device: ComponentLike | Sequence[DeviceSet] | None = DEVICES,
    out: str | Path = "explore.html", *, set: Mapping[str, float] | None = None,
) -> ExplorePage:  # fmt: skip
    """Write one HTML page of at most 2 MB that opens from a file, without a network.

    vehicle and the first two entries of device are the configurations A and B that it opens with; a single device is B,
    beside A without a device. An entry is a device, several that act together (a tuple or a comma list), or the path of
    a device's FMU, which is linearised at its start values. Every shipped vehicle and device can be chosen in the page.
    out is its path. set changes parameters of vehicle and devices by name, in SI units. Raises InputError for an
    unknown name, an FMU of a vehicle, and devices that do not go together, MissingToolError where the WebAssembly of a
    component is not installed and cannot be compiled.

        >>> page = mf.explore("sharp_1971", ["rider:mean_2011", "damper:7.5"], "page.html")
        >>> page.size < 2e6, page.to_dict()["page"]
        (True, 'page.html')
    """
    path = writable(Path(out))
    sets = [[part for each in given if (part := device_of(each)) is not None] for given in compared(device)]
    whole = components.vehicle(vehicle)
    flat: dict[str, Component | None] = {"vehicle": whole}
    flat |= {f"device_{k}_{i}": d if isinstance(d, Component) else None
             for k, held in enumerate(sets) for i, d in enumerate(held)}  # fmt: skip
    changed = dict(zip(flat, components.with_settings(flat, set or {}), strict=True))
    chosen = [[changed[f"device_{k}_{i}"] or d for i, d in enumerate(held)] for k, held in enumerate(sets)]
    return explore_page(path, [changed["vehicle"] or whole], chosen)


def explore_page(path: Path, vehicles: Sequence[Component], sets: Sequence[Sequence[Device]]) -> ExplorePage:
    """Write the page that offers vehicles and sets of devices beside those that ship; it opens with the first vehicle
    and the first two sets. Raises InputError for devices that do not go together, and for a page that is too large."""
    for held in sets:
        ridden(vehicles[0], *(part for part in held if isinstance(part, Component)))
    shipped = [motorcycles.load(name) for name in motorcycles.names()]
    offered_vehicles = offered(vehicles, shipped)
    devices = offered([part for held in sets for part in held], list(shipped_devices()))
    whole = [c for c in (*offered_vehicles.values(), *devices.values()) if isinstance(c, Component)]
    compiled = modules(whole)
    linearised = {d.name: d.module for d in devices.values() if isinstance(d, LinearisedFmu)}
    data = {
        "version": __version__,
        "vehicle": shown_name(vehicles[0]),
        "devices": [device_names(held) for held in sets[:2]],
        "modules": {**{key: description for key, description, _ in compiled}, **linearised},
        "vehicles": {n: described(c, compiled) for n, c in offered_vehicles.items()},
        "choices": {n: described(c, compiled) for n, c in devices.items()},
        "published": [*published_eigenvalues(), *published_features()],
    }
    write_page(path, data, f"{shown_name(vehicles[0])}: modes")
    size = path.stat().st_size
    if size > LARGEST:
        path.unlink()
        raise InputError(
            f"{path} would have {size} bytes, more than {LARGEST}: give fewer devices with effects of their own"
        )
    return ExplorePage(path, size, tuple(offered_vehicles), ("none", *devices))


def compared(device: ComponentLike | Sequence[DeviceSet] | None) -> list[list[ComponentLike | None]]:
    """The given sets of devices, those of A and B first; a single one is B, compared with A without a device."""
    given = list(device) if isinstance(device, Sequence) and not isinstance(device, str) else [device]
    sets = [components.together(each) for each in given]
    if len(sets) > 1:
        return sets
    alone = not any(each not in (None, "none") for held in sets for each in held)
    return [components.together(each) for each in DEVICES] if alone else [[], *sets]


def device_of(given: ComponentLike | None) -> Device | None:
    """A device by its name, or the linearised FMU at a path; None for none."""
    if isinstance(given, str | Path) and Path(given).suffix == ".fmu":
        return linearised_fmu(given)
    return components.device(given)


def shown_name(part: Device) -> str:
    """The name of a vehicle or device in the page, without the characters that separate names in its address."""
    return displayed(part.name).translate(dict.fromkeys(map(ord, ",;:"), "_"))


def device_names(held: Sequence[Device]) -> str:
    """A set of devices as the page writes it."""
    return ",".join(map(shown_name, held)) or "none"


def offered(given: Sequence[Part], shipped: Sequence[Part]) -> dict[str, Part]:
    """Components by the name that the page shows; those given come first and replace a shipped one of their name."""
    found: dict[str, Part] = {}
    for each in (*given, *shipped):
        found.setdefault(shown_name(each), each)
    return found


def shipped_devices() -> Iterator[Component]:
    """The shipped riders and dampers."""
    for name in components.every_name():
        if name.partition(":")[0] in ("rider", "damper"):
            yield components.component(name)


Compiled = tuple[str, dict[str, Any], Any]  # key in the page, description with the module, structure


def modules(every: Sequence[Component]) -> list[Compiled]:
    """One module for each class of components in use, with its effects."""
    of_structure: dict[Any, Component] = {}
    for each in every:
        of_structure.setdefault(each.structure, each)
    found: list[Compiled] = []
    for structure, each in track(list(of_structure.items()), "WebAssembly", len(of_structure)):
        found.append((f"{each.title} {len(found)}", module_of(each), structure))
    return found


def module_of(component: Component) -> dict[str, Any]:
    """The module of a component for the page, with the declaration of its parameters."""
    return {
        "title": component.title,
        **explore_modules.module_of(component),
        "parameters": {
            name: {
                "unit": row.unit,
                "description": row.description,
                "min": None if isinf(row.min) else row.min,
                "max": None if isinf(row.max) else row.max,
            }
            for name, row in component.rows("parameter").items()
        },
    }


def described(part: Device, compiled: Sequence[Compiled]) -> dict[str, Any]:
    """The values of a component and the key of its module."""
    if isinstance(part, LinearisedFmu):
        return {"module": part.name, "values": {}, "title": part.name, "source": part.source}
    key = next(key for key, _, structure in compiled if structure == part.structure)
    return {"module": key, "values": dict(part.values), "title": part.title, "source": part.source}


def published_eigenvalues() -> Iterator[dict[str, Any]]:
    """Printed eigenvalues of vehicles without a device: vehicle, source, and [speed, real, imaginary part] by mode."""
    sharp, bicycle = (
        {"weave": [], "wobble": [], "capsize": []},  # type: ignore[var-annotated]
        {"weave": [], "capsize": []},  # type: ignore[var-annotated]
    )
    for row in table(SHARP_1971_EIGENVALUES):
        speed = float(row["speed_ft_per_s"]) * FOOT
        for mode in ("weave", "wobble"):
            sharp[mode].append([speed, float(row[f"{mode}_real"]), float(row[f"{mode}_imag"])])
        sharp["capsize"].append([speed, float(row["capsize"]), 0.0])
    for row in table(MEIJAARD_2007_EIGENVALUES):
        speed = float(row["speed_m_per_s"])
        bicycle["weave"].append([speed, float(row["weave_real"]), float(row["weave_imag"])])
        bicycle["capsize"].append([speed, float(row["capsize"]), 0.0])
    yield {"vehicle": "sharp_1971", "device": "none", "source": "Sharp 1971", "eigenvalues": sharp}
    yield {"vehicle": "benchmark_bicycle", "device": "none", "source": "Meijaard et al. 2007", "eigenvalues": bicycle}


def published_features() -> Iterator[dict[str, Any]]:
    """Printed frequencies of the reference motorcycle: [speed, low, high] in Hz by mode."""
    devices = {"reference": "none", "rider": "mean_2011"}
    for model, device in devices.items():
        modes: dict[str, list[list[float]]] = {}
        for row in table(MODES_2011):
            if row["model"] == model and row["feature"] == "frequency":
                modes.setdefault(row["mode"], []).append([float(row[c]) for c in ("speed_m_per_s", "lo", "hi")])
        yield {"vehicle": "reference_2011", "device": device, "source": "Cossalter et al. 2011", "frequencies": modes}
