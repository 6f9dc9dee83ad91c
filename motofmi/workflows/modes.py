"""The named modes of a vehicle with devices at its ports over speed: of components, of FMUs, or of a
system of FMUs (SSP)."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fmus.cosimulation.ssp import read_ssp
from fmus.declaration.component import Component, in_bounds
from fmus.linear_analysis.linearisation import StateSpace
from fmus.linear_analysis.participation import participation
from fmus.support.errors import InputError, unknown
from fmus.support.notebook import html, new_axes
from motofmi.workflows.components import ComponentLike
from motofmi.workflows.ridden_fmus import Part, assumed, over_speed_fmus, parts, ridden_fmus
from motofmi.workflows.titles import displayed, system_title
from vehicle_fmu import Modes, over_speed, ridden
from vehicle_fmu import modes as modes_of
from vehicle_fmu.mode_shapes import Linearised

SPEEDS = np.arange(1.0, 61.0)  # m/s
Devices = ComponentLike | Sequence[ComponentLike | None] | None  # one device, several or none


@dataclass(frozen=True, repr=False)
class VehicleModes(Modes):
    """The modes of a named vehicle with named devices.

    assumed holds the reason by parameter for values that no source gives. participation, of a system of FMUs only,
    holds by mode and FMU the shares (n,) of the FMU's states in the mode, None where the mode is absent.
    """

    vehicle: str = ""
    device: str = "none"
    assumed: Mapping[str, str] | None = None
    participation: Mapping[str, Mapping[str, Sequence[float | None]]] | None = None

    @property
    def title(self) -> str:
        return system_title(self.vehicle, self.device)

    def to_dict(self) -> dict[str, Any]:
        """The keys of `motofmi modes --json`."""
        found = {
            "vehicle": self.vehicle,
            "device": self.device,
            "assumed": dict(self.assumed or {}),
            **super().to_dict(),
        }
        return found if self.participation is None else {**found, "participation": self.participation}


@dataclass(frozen=True, repr=False)
class ModesComparison:
    """The modes of one vehicle with different devices, by the name of the device."""

    vehicle: str
    by_device: Mapping[str, VehicleModes]

    def __getitem__(self, device: str) -> VehicleModes:
        if device not in self.by_device:
            raise unknown("device", device, self.by_device)
        return self.by_device[device]

    def __repr__(self) -> str:
        return f"ModesComparison({displayed(self.vehicle)!r} with {', '.join(self.by_device)})"

    def _repr_html_(self) -> str:
        present = dict.fromkeys(mode for found in self.by_device.values() for mode in found.unstable)
        rows = [(name, *(_bands(found, mode) for mode in present)) for name, found in self.by_device.items()]
        return html(f"{displayed(self.vehicle)}: unstable speeds [m/s]", ("device", *present), rows, self.plot)

    def plot(self, axes: Any = None) -> Any:
        """Root loci, one colour for each device; the axes of matplotlib."""
        axes = new_axes() if axes is None else axes
        for name, found in self.by_device.items():
            found.plot(axes, label=name)
        axes.set_title(displayed(self.vehicle))
        return axes

    def to_dict(self) -> dict[str, Any]:
        """`vehicle`, and under `devices` the keys of `motofmi modes --json` by device."""
        return {"vehicle": self.vehicle, "devices": {name: found.to_dict() for name, found in self.by_device.items()}}

    def to_dataframe(self) -> Any:
        """The tables of all devices below each other, with a column `device` (pandas.DataFrame)."""
        import pandas as pd  # noqa: PLC0415 - imported on use

        return (
            pd.concat({name: found.to_dataframe() for name, found in self.by_device.items()}, names=["device"])
            .reset_index("device")
            .reset_index(drop=True)
        )


def modes(
    vehicle: ComponentLike, device: Devices = None, speed: ArrayLike = SPEEDS, *, set: Mapping[str, float] | None = None
) -> VehicleModes:
    """Eigenvalues at ascending speeds (n,) [m/s] and the named modes of a vehicle, alone or with devices at its ports.

    vehicle and device are components, names, paths of value files (.toml) or of FMUs; the path of an .ssp stands for
    the whole. set changes parameters by name, or by `vehicle.name`, `device.name` where both have it. Raises InputError
    for an unknown name, a component without the port, and speeds outside the vehicle's bounds.

        modes("sharp_1971", "rider:mean_2011", speed=[20, 30, 40])["weave"].damping_ratio
    """
    speeds = np.atleast_1d(np.asarray(speed, float))
    archive = _ssp(vehicle, device, set)
    if archive:
        return _of_ssp(archive, speeds)
    whole, devices = parts(vehicle, device, set)
    with _linearised(whole, devices, speeds) as linearised:
        found = modes_of(linearised, speeds)
    return VehicleModes(
        **vars(found),
        vehicle=whole.name,
        device=", ".join(d.name for d in devices) or "none",
        assumed=assumed(whole, devices),
    )


def state_space(
    vehicle: ComponentLike, device: Devices = None, speed: ArrayLike = SPEEDS, *, set: Mapping[str, float] | None = None
) -> StateSpace:
    """A vehicle, alone or with devices, linearised at one speed [m/s], or at speeds (n,) with stacked matrices.

    The arguments are those of `modes`. Raises InputError as it does.

        state_space("sharp_1971", "rider:mean_2011", speed=[20, 30, 40]).save_matlab("bike.mat")
    """
    speeds = np.atleast_1d(np.asarray(speed, float))
    archive = _ssp(vehicle, device, set)
    if archive:
        fmus, wiring = read_ssp(archive)
        with ExitStack() as opened:
            for fmu in fmus.values():
                opened.enter_context(fmu)
            found = over_speed_fmus(fmus, wiring)(speeds)
    else:
        with _linearised(*parts(vehicle, device, set), speeds) as linearised:
            found = linearised(speeds)
    return found if np.ndim(speed) else _first(found)


def compare_modes(vehicle: ComponentLike, devices: Mapping[str, Devices] | Sequence[Devices], speed: ArrayLike = SPEEDS,
                  *, set: Mapping[str, float] | None = None) -> ModesComparison:  # fmt: skip
    """The modes of a vehicle with one device after the other, as by `modes`; devices by labels, or a
    list.

        compare_modes("sharp_1971", [None, "rider:mean_2011", "damper:7.5"]).plot()
    """  # fmt: skip
    given = devices if isinstance(devices, Mapping) else dict(enumerate(devices))
    found = {label: modes(vehicle, device, speed, set=set) for label, device in given.items()}
    named = {label if isinstance(label, str) else each.device: each for label, each in found.items()}
    if len(named) < len(found):
        raise InputError("two of the devices have the same name; give them as a dictionary with labels of your own")
    return ModesComparison(next((each.vehicle for each in named.values()), str(vehicle)), named)


@contextmanager
def _linearised(whole: Part, devices: Sequence[Part], speeds: np.ndarray) -> Iterator[Linearised]:
    """The linearisation over speed. Raises InputError for speeds outside the vehicle's bounds."""
    if isinstance(whole, Component):
        for end in (speeds[0], speeds[-1]):
            in_bounds(end, whole.table["speed"], whole.name)
    held = [d for d in devices if isinstance(d, Component)]
    with ExitStack() as opened:
        if isinstance(whole, Component) and len(held) == len(devices):
            yield over_speed(ridden(whole, *held))
        else:
            yield over_speed_fmus({n: opened.enter_context(fmu) for n, fmu in ridden_fmus(whole, devices).items()})


def _ssp(vehicle: ComponentLike, device: Devices, set: Mapping[str, float] | None) -> Path | None:
    """The path of an SSP archive. Raises InputError for one with a device or settings."""
    if isinstance(vehicle, Component) or Path(vehicle).suffix != ".ssp":
        return None
    if device is not None or set:
        raise InputError(
            f"{vehicle} is a whole system: it takes neither device nor set; change the FMUs or the values in it"
        )
    return Path(vehicle)


def _of_ssp(path: Path, speeds: np.ndarray) -> VehicleModes:
    """The modes of the FMUs of an SSP archive, with their shares in each mode."""
    fmus, wiring = read_ssp(path)
    with ExitStack() as opened:
        for fmu in fmus.values():
            opened.enter_context(fmu)
        linearised = over_speed_fmus(fmus, wiring)
        found = modes_of(linearised, speeds)
        shares: dict[str, dict[str, list[float | None]]] = {
            mode: {name: [] for name in fmus} for mode in found.unstable
        }
        for k, speed in enumerate(speeds):
            eigenvalues, participating = participation(_at(linearised, speed))
            for mode, by_fmu in shares.items():
                value = found[mode].eigenvalue[k]
                nearest = int(np.abs(eigenvalues - value).argmin())
                for name, column in by_fmu.items():
                    column.append(
                        None
                        if np.isnan(value)
                        else float(participating[name][nearest])
                        if name in participating
                        else 0.0
                    )
    return VehicleModes(**vars(found), vehicle=path.name, assumed={}, participation=shares)


def _at(linearised: Linearised, speed: float) -> StateSpace:
    """The state space at one speed [m/s]."""
    return _first(linearised(np.array([speed])))


def _first(space: StateSpace) -> StateSpace:
    """The state space at the first of its points."""
    return replace(space, A=space.A[0], B=space.B[0], C=space.C[0], D=space.D[0])


def _bands(found: Modes, mode: str) -> str:
    """The unstable speeds of a mode as text."""
    if mode not in found.unstable:
        return "-"
    return ", ".join(f"{low:.1f} to {high:.1f}" for low, high in found.unstable[mode]) or "none"
