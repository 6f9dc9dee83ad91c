"""The named modes of a vehicle with devices at its ports over speed: of components, of FMUs, or of a
system of FMUs (SSP)."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fmus.declaration.component import Component, in_bounds
from fmus.linear_analysis.linearisation import StateSpace
from fmus.linear_analysis.participation import participation
from fmus.support.errors import InputError, unknown
from fmus.support.notebook import html, new_axes
from motofmi.reports.root_locus import root_locus
from motofmi.reports.shown import Interactive
from motofmi.workflows.components import ComponentLike
from motofmi.workflows.parts import Part, assumed, parts
from motofmi.workflows.ridden_fmus import over_speed_fmus, ridden_fmus
from motofmi.workflows.ssp_system import open_system, whole_system
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

        >>> found = mf.modes("sharp_1971", "damper:7.5", speed=[20, 30])
        >>> found.title, found["wobble"].frequency.shape
        ('sharp_1971 with damper_7.5', (2,))
        >>> found.to_dataframe().columns[1]
        'weave real [1/s]'
        >>> found.to_xarray().frequency.units
        'Hz'
        >>> axes = found.plot(label="damper")
        >>> path = found.show().save("locus.html")
        >>> sorted(found.to_dict())[:3]
        ['assumed', 'device', 'eigenvalues']
    """

    vehicle: str = ""
    device: str = "none"
    assumed: Mapping[str, str] | None = None
    participation: Mapping[str, Mapping[str, Sequence[float | None]]] | None = None

    @property
    def title(self) -> str:
        return system_title(self.vehicle, self.device)

    def show(self) -> Interactive:
        """The root locus of the named modes, interactive in a notebook."""
        return Interactive(root_locus({self.title: self}), self.title)

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
    """The modes of one vehicle with different devices, by the name of the device.

        >>> found = mf.compare_modes("sharp_1971", {"alone": None, "damped": mf.damper(7.5)}, speed=[20, 30])
        >>> list(found.by_device)
        ['alone', 'damped']
        >>> found["damped"].device
        'damper_7.5'
        >>> len(found.to_dataframe()), list(found.to_dict())
        (4, ['vehicle', 'devices'])
        >>> axes = found.plot()
        >>> path = found.show().save("loci.html")
    """

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

    def show(self) -> Interactive:
        """The root loci, one colour for each device, interactive in a notebook."""
        return Interactive(root_locus(self.by_device), displayed(self.vehicle))

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


def modes(vehicle: ComponentLike | None = None, device: Devices = None, speed: ArrayLike = SPEEDS, *,
          set: Mapping[str, float] | None = None, ssp: str | Path | None = None,
          units: Mapping[str, str] | None = None) -> VehicleModes:  # fmt: skip
    """Eigenvalues and named modes of a vehicle at ascending `speed` (n,) [m/s], alone or with devices at its ports.

    vehicle and device are components, names, paths of value files (.toml) or of FMUs; `ssp` is the path of a whole
    system in their place. set changes parameters by name, or by `vehicle.name`, `device.name` where both have it, those
    of an FMU in the units that it states. units states the unit of variables that have none in their FMU. Raises
    InputError for an unknown name, a component without the port, and speeds outside the vehicle's bounds.

        >>> found = mf.modes("sharp_1971", "rider:mean_2011", speed=[20, 30, 40])
        >>> found["weave"].damping_ratio.round(2)
        array([ 0.2 ,  0.02, -0.02])
    """
    speeds = np.atleast_1d(np.asarray(speed, float))
    if whole_system(ssp, vehicle, device):
        return _of_ssp(ssp, speeds, set, units)
    whole, devices = parts(vehicle, device, set)
    with _linearised(whole, devices, speeds, units) as linearised:
        found = modes_of(linearised, speeds)
    return VehicleModes(
        **vars(found),
        vehicle=whole.name,
        device=", ".join(d.name for d in devices) or "none",
        assumed=assumed(whole, devices),
    )


def state_space(vehicle: ComponentLike | None = None, device: Devices = None, speed: ArrayLike = SPEEDS, *,
                set: Mapping[str, float] | None = None, ssp: str | Path | None = None,
                units: Mapping[str, str] | None = None) -> StateSpace:  # fmt: skip
    """A vehicle, alone or with devices, linearised at one speed [m/s], or at speeds (n,) with stacked matrices.

    The arguments are those of `modes`. Raises InputError as it does.

        state_space("sharp_1971", "rider:mean_2011", speed=[20, 30, 40]).save_matlab("bike.mat")
    """
    speeds = np.atleast_1d(np.asarray(speed, float))
    if whole_system(ssp, vehicle, device):
        with open_system(ssp, set, units) as system:
            found = over_speed_fmus(system.subsystems, system.wiring)(speeds)
    else:
        with _linearised(*parts(vehicle, device, set), speeds, units) as linearised:
            found = linearised(speeds)
    return found if np.ndim(speed) else _first(found)


def compare_modes(vehicle: ComponentLike, devices: Mapping[str, Devices] | Sequence[Devices], speed: ArrayLike = SPEEDS,
                  *, set: Mapping[str, float] | None = None,
                  units: Mapping[str, str] | None = None) -> ModesComparison:  # fmt: skip
    """The modes of a vehicle with one device after the other, as by `modes` at `speed` (n,) [m/s].

    devices are given by labels, or as a list; set and units as in `modes`. Raises InputError as `modes` does, and for
    two devices of the same name.

        >>> found = mf.compare_modes("sharp_1971", [None, "damper:7.5"], speed=[30])
        >>> bool(found["damper_7.5"]["wobble"].damping_ratio > found["none"]["wobble"].damping_ratio)
        True
    """
    given = devices if isinstance(devices, Mapping) else dict(enumerate(devices))
    found = {label: modes(vehicle, device, speed, set=set, units=units) for label, device in given.items()}
    named = {label if isinstance(label, str) else each.device: each for label, each in found.items()}
    if len(named) < len(found):
        raise InputError("two of the devices have the same name; give them as a dictionary with labels of your own")
    return ModesComparison(next((each.vehicle for each in named.values()), str(vehicle)), named)


@contextmanager
def _linearised(whole: Part, devices: Sequence[Part], speeds: np.ndarray,
                units: Mapping[str, str] | None) -> Iterator[Linearised]:  # fmt: skip
    """The linearisation over speed. Raises InputError for speeds outside the vehicle's bounds."""
    if isinstance(whole, Component):
        for end in (speeds[0], speeds[-1]):
            in_bounds(end, whole.table["speed"], whole.name)
    held = [d for d in devices if isinstance(d, Component)]
    with ExitStack() as opened:
        if isinstance(whole, Component) and len(held) == len(devices):
            yield over_speed(ridden(whole, *held))
        else:
            fmus = ridden_fmus(whole, devices, units=units)
            yield over_speed_fmus({n: opened.enter_context(fmu) for n, fmu in fmus.items()})


def _of_ssp(path: str | Path, speeds: np.ndarray, changed: Mapping[str, float] | None,
            units: Mapping[str, str] | None) -> VehicleModes:  # fmt: skip
    """The modes of the FMUs of an SSP archive, with their shares in each mode."""
    with open_system(path, changed, units) as system:
        linearised = over_speed_fmus(system.subsystems, system.wiring)
        found = modes_of(linearised, speeds)
        at_speeds = [participation(_at(linearised, speed)) for speed in speeds]
    shares = {mode: {name: [_share(name, found[mode].eigenvalue[k], *each) for k, each in enumerate(at_speeds)]
                     for name in system.fmus} for mode in found.unstable}  # fmt: skip
    return VehicleModes(**vars(found), vehicle=Path(path).name, assumed={}, participation=shares)


def _share(
    fmu: str, value: complex, eigenvalues: np.ndarray, participating: Mapping[str, np.ndarray]
) -> float | None:
    """The share of an FMU's states in the mode with an eigenvalue; None where the mode is absent."""
    if np.isnan(value):
        return None
    return float(participating[fmu][int(np.abs(eigenvalues - value).argmin())]) if fmu in participating else 0.0


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
