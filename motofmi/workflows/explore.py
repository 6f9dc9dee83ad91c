"""One page that works offline: root loci with sliders, the mode animated, and the compiled components themselves.

The page holds the WebAssembly of every class of components that it offers. From that come the linear systems (the
exact Jacobian) and the live co-simulation; parameters are set in the compiled component.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from math import isinf
from pathlib import Path
from typing import Any

from fmus.declaration.component import Component
from fmus.interfaces.handlebar import TORQUES
from fmus.interfaces.posture_inertia import POSTURE
from fmus.support.errors import InputError
from fmus.support.files import writable
from fmus.support.progress import track
from fmus.support.published import table
from motofmi.reports.explore import LARGEST, write_page
from motofmi.reports.shown import FRAME
from motofmi.version import __version__
from motofmi.workflows import components, explore_modules
from motofmi.workflows.components import ComponentLike
from motofmi.workflows.titles import displayed
from vehicle_fmu import motorcycles
from vehicle_fmu.published import MEIJAARD_2007_EIGENVALUES, MODES_2011, SHARP_1971_EIGENVALUES

VEHICLE = "sharp_1971"
DEVICES: tuple[ComponentLike | None, ...] = (None, "rider:mean_2011")
FOOT = 0.3048  # m
HEIGHT = 900  # px, of the page in a notebook


@dataclass(frozen=True)
class ExplorePage:
    """The page that was written: its path, its size in bytes, and the names of what it offers; `explore` shows an example.

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
    vehicle: ComponentLike = VEHICLE, device: ComponentLike | Sequence[ComponentLike | None] | None = DEVICES,
    out: str | Path = "explore.html", *, set: Mapping[str, float] | None = None,
) -> ExplorePage:  # fmt: skip
    """Write one HTML page of at most 2 MB that opens from a file, without a network.

    vehicle and the first two entries of device are the configurations A and B that it opens with; a single device is B,
    beside A without a device. Every shipped vehicle and handlebar device can be chosen in it. out is the path of the
    page. set changes parameters of vehicle and devices by name, in SI units. Raises InputError for an unknown name and
    a device that is not at the handlebar alone, MissingToolError where the WebAssembly of a component is not installed
    and cannot be compiled.

        >>> page = mf.explore("sharp_1971", ["rider:mean_2011", "damper:7.5"], "page.html")
        >>> page.size < 2e6, page.to_dict()["page"]
        (True, 'page.html')
    """
    path = writable(Path(out))
    given = compared(device)
    whole, *chosen = components.with_settings(
        {"vehicle": components.vehicle(vehicle), **{f"device_{k}": components.device(d) for k, d in enumerate(given)}},
        set or {},
    )
    assert whole is not None
    shipped = [motorcycles.load(name) for name in motorcycles.names()]
    vehicles = offered([whole], shipped)
    devices = offered([d for d in chosen if d], list(shipped_devices()))
    for each in devices.values():
        refuse_other_ports(each)
    compiled = modules([*vehicles.values(), *devices.values()])
    names = {id(c): name for name, c in (*vehicles.items(), *devices.items())}
    selected = [names[id(d)] if d is not None else "none" for d in chosen]
    data = {
        "version": __version__,
        "vehicle": names[id(whole)],
        "devices": selected[:2],
        "modules": {key: description for key, description, _ in compiled},
        "vehicles": {n: described(c, compiled) for n, c in vehicles.items()},
        "choices": {n: described(c, compiled) for n, c in devices.items()},
        "published": [*published_eigenvalues(), *published_features()],
    }
    write_page(path, data, f"{displayed(whole.name)}: modes")
    size = path.stat().st_size
    if size > LARGEST:
        raise InputError(f"{path} has {size} bytes, more than {LARGEST}: give fewer devices with effects of their own")
    return ExplorePage(path, size, tuple(vehicles), ("none", *devices))


def compared(device: ComponentLike | Sequence[ComponentLike | None] | None) -> list[ComponentLike | None]:
    """The given devices, those of A and B first; a single one is B, compared with A without a device."""
    given = list(device) if isinstance(device, Sequence) and not isinstance(device, str) else [device]
    devices = [None if each == "none" else each for each in given]
    if len(devices) > 1:
        return devices
    return list(DEVICES) if devices in ([], [None]) else [None, *devices]


def offered(given: Sequence[Component], shipped: Sequence[Component]) -> dict[str, Component]:
    """Components by the name that the page shows; those given come first and replace a shipped one of their name."""
    found: dict[str, Component] = {}
    for each in (*given, *shipped):
        found.setdefault(displayed(each.name), each)
    return found


def shipped_devices() -> Iterator[Component]:
    """The shipped riders and dampers whose port is the handlebar alone."""
    for name in components.every_name():
        kind, _, _ = name.partition(":")
        if kind in ("rider", "damper"):
            each = components.component(name)
            if not other_ports(each):
                yield each


def other_ports(device: Component) -> str:
    """What a device has beside the handlebar port, or lacks of it; empty where the page can connect it."""
    if not set(TORQUES) <= set(device.outputs):
        return "does not have the handlebar port"
    return "changes the inertia of the handlebar with its posture" if set(POSTURE) <= set(device.outputs) else ""


def refuse_other_ports(device: Component) -> None:
    reason = other_ports(device)
    if reason:
        raise InputError(
            f"{device.name} {reason}: explore takes passive riders and dampers; motofmi modes takes every device"
        )


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


def described(component: Component, compiled: Sequence[Compiled]) -> dict[str, Any]:
    """The values of a component and the key of its module."""
    key = next(key for key, _, structure in compiled if structure == component.structure)
    return {"module": key, "values": dict(component.values), "title": component.title, "source": component.source}


def published_eigenvalues() -> Iterator[dict[str, Any]]:
    """Printed eigenvalues of vehicles without a device: vehicle, source, and [speed, real, imaginary part] by mode."""
    sharp, bicycle = {"weave": [], "wobble": [], "capsize": []}, {"weave": [], "capsize": []}  # type: ignore[var-annotated]
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
