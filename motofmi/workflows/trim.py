"""Steady turning of a motorcycle at a speed, lean angles and accelerations: equilibrium, and the named modes about
it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fmus.support.errors import InputError, unknown
from fmus.support.notebook import html, new_axes
from motofmi.reports.charts import SEQUENCE, Axis, Chart, Curve, Line, Panel
from motofmi.reports.shown import Interactive
from motofmi.workflows.components import ComponentLike
from motofmi.workflows.corner import LARGEST_LEAN, checked, in_corner
from motofmi.workflows.modes import Devices
from motofmi.workflows.parts import assumed
from motofmi.workflows.titles import system_title
from vehicle_fmu import Mode
from vehicle_fmu.large_motion.applied_forces import INPUTS
from vehicle_fmu.large_motion.corner_modes import corner_modes
from vehicle_fmu.large_motion.equations import ENDS
from vehicle_fmu.large_motion.steady_turning import Equilibrium, SteadyTurning
from vehicle_fmu.large_motion.suspension import FRONT, REAR

LARGEST_ACCELERATION = 30.0  # m/s2: above what any tyre transmits
QUANTITIES = {  # of an equilibrium, with their units
    "steer_angle": "rad",
    "steer_torque": "N.m",
    "yaw_rate": "rad/s",
    "lateral_acceleration": "m/s2",
    "drive_torque": "N.m",
    "front_wheel_torque": "N.m",
    "front_suspension": "m",
    "rear_suspension": "rad",
    **{
        f"{end}_{name}": unit
        for name, unit in (
            ("load", "N"),
            ("side_force", "N"),
            ("longitudinal_force", "N"),
            ("longitudinal_slip", "1"),
            ("slip_angle", "rad"),
            ("camber_angle", "rad"),
            ("tyre_deflection", "m"),
            ("grip_used", "1"),
        )
        for end in ENDS
    },
    "residual": "N, N.m",
}


@dataclass(frozen=True, repr=False)
class Trim:
    """Steady turning of a vehicle at a speed [m/s], lean angles (n,) [deg], to the right positive, and longitudinal
    accelerations (n,) [m/s2], with devices at its port.

    quantities holds arrays (n,) by name in SI units (angles in rad): steer_torque is the torque between frame and
    front frame that the rider has to apply; drive_torque acts on the rear wheel, front_wheel_torque on the front wheel,
    and both brake where negative; front_suspension and rear_suspension are the travel of the lower fork and the angle
    of the swingarm from standstill, positive in compression; grip_used is the root of the squared side and longitudinal
    force of a tyre, each per the greatest one at its load; residual is the largest force or moment that is left.
    eigenvalues (n, nx) [1/s] and named modes are those about each equilibrium.

        >>> found = mf.trim("tum_2020", speed=30, lean=[0, 30])
        >>> found
        Trim(tum_2020 without a device at 30 m/s: lean 0 to 30 deg; weave, wobble, capsize, rear_wobble, bounce, pitch,
        front_hop, rear_hop, fork_bending)
        >>> found["yaw_rate"][1:].round(3), found["weave"].eigenvalue.real.round(1)
        (array([0.153]), array([-3.8, -3.7]))
        >>> found.to_dataframe().columns[3]
        'steer_torque [N.m]'
        >>> list(found.to_dict())[:5], found.title
        (['vehicle', 'device', 'assumed', 'speed', 'longitudinal_acceleration'], 'tum_2020 without a device')
        >>> axes, page = found.plot(), found.show().save("corner.html")
    """

    vehicle: str
    device: str
    assumed: Mapping[str, str]
    speed: float
    longitudinal_acceleration: np.ndarray
    lean: np.ndarray
    quantities: Mapping[str, np.ndarray]
    eigenvalues: np.ndarray
    named: Mapping[str, Mode]

    def __getitem__(self, name: str) -> Any:
        """A quantity (n,), or the mode of that name. Raises InputError with the valid names for any other."""
        if name in self.quantities:
            return self.quantities[name]
        if name not in self.named:
            raise unknown("quantity or mode", name, [*self.quantities, *self.named])
        return self.named[name]

    @property
    def title(self) -> str:
        """Vehicle and devices, as in figures."""
        return system_title(self.vehicle, self.device)

    def __repr__(self) -> str:
        return f"Trim({self.title} at {self.speed:g} m/s: {self._points()}; {', '.join(self.named)})"

    def _points(self) -> str:
        points = f"lean {_range(self.lean)} deg"
        if self.longitudinal_acceleration.any():
            points += f", acceleration {_range(self.longitudinal_acceleration)} m/s2"
        return points

    def _repr_html_(self) -> str:
        shown = ("steer_angle", "steer_torque", "yaw_rate", "front_load", "rear_load")
        points = enumerate(zip(self.lean, self.longitudinal_acceleration, strict=True))
        rows = [(f"{lean:g}", f"{a:g}", *(f"{self[name][k]:.4g}" for name in shown)) for k, (lean, a) in points]
        return html(
            f"{self.title}, {self.speed:g} m/s",
            ("lean [deg]", "acceleration [m/s2]", *(f"{n} [{QUANTITIES[n]}]" for n in shown)),
            rows,
            self.plot,
        )

    def plot(self, axes: Any = None) -> Any:
        """The root locus of the named modes over lean angle and acceleration on axes of matplotlib, which are
        returned; new ones unless given.
        """
        axes = new_axes() if axes is None else axes
        for mode, found in self.named.items():
            (line,) = axes.plot(found.eigenvalue.real, found.eigenvalue.imag, ".-", label=mode.replace("_", "-"))
            axes.plot(found.eigenvalue.real[-1:], found.eigenvalue.imag[-1:], "o", color=line.get_color())
        axes.axvline(0.0, color="0.5", linewidth=0.8)
        axes.set(
            xlabel="real part [1/s]",
            ylabel="imaginary part [rad/s]",
            title=f"{self.title}, {self.speed:g} m/s, {self._points()}",
        )
        axes.legend()
        return axes

    def show(self) -> Interactive:
        """The root locus of the named modes over the lean angle, interactive in a notebook."""
        words = [f"lean {lean:g} deg" for lean in self.lean]
        curves = []
        for k, (mode, found) in enumerate(self.named.items()):
            color, root = SEQUENCE[k % len(SEQUENCE)], found.eigenvalue
            curves.append(Curve(mode.replace("_", "-"), root.real, root.imag, color, "both", text=words))
        axes = Axis("real part", "1/s"), Axis("imaginary part", "rad/s")
        panel = Panel(*axes, curves, lines=[Line(0.0, across="x")], hover="point", height=380)
        return Interactive(Chart([panel]), f"{self.title}, {self.speed:g} m/s, {self._points()}")

    def to_dict(self) -> dict[str, Any]:
        """The keys of `motofmi trim --json`."""
        return {
            "vehicle": self.vehicle,
            "device": self.device,
            "assumed": dict(self.assumed),
            "speed": self.speed,
            "longitudinal_acceleration": self.longitudinal_acceleration,
            "lean": self.lean,
            **self.quantities,
            "eigenvalues": self.eigenvalues,
            "modes": {name: mode.to_dict() for name, mode in self.named.items()},
        }

    def to_dataframe(self) -> Any:
        """One row for each point (pandas.DataFrame); the unit is in the name of every column."""
        import pandas as pd  # noqa: PLC0415 - imported on use

        points = {"lean [deg]": self.lean, "longitudinal_acceleration [m/s2]": self.longitudinal_acceleration}
        columns = {**points, **{f"{n} [{QUANTITIES[n]}]": x for n, x in self.quantities.items()}}
        for mode, found in self.named.items():
            columns |= {
                f"{mode} real [1/s]": found.eigenvalue.real,
                f"{mode} imag [rad/s]": found.eigenvalue.imag,
                f"{mode} frequency [Hz]": found.frequency,
                f"{mode} damping ratio [1]": found.damping_ratio,
            }
        return pd.DataFrame(columns)


def trim(
    vehicle: ComponentLike = "tum_2020",
    device: Devices = None,
    *,
    speed: float,
    lean: ArrayLike,
    longitudinal_acceleration: ArrayLike = 0.0,
    set: Mapping[str, float] | None = None,
) -> Trim:
    """Steady turning of a vehicle at `speed` [m/s] and `lean` angles (n,) or one [deg], with the modes about it.

    With a longitudinal_acceleration (n,) or one [m/s2], a quasi-equilibrium: drive or brakes change the speed so slowly
    that nothing else changes; the modes are those at constant speed. vehicle and device are components, names, or paths
    of value files (.toml); device acts at the handlebar port. set changes parameters by name, the supplement of its
    value file among them: suspensions, deflection and longitudinal slip of the tyres are locked by front_suspension,
    rear_suspension, fork_lengthwise_bending, front_tyre_deflection, rear_tyre_deflection, front_longitudinal_slip and
    rear_longitudinal_slip = 0. Equations: `vehicle_fmu.large_motion`. Raises InputError for a vehicle without them, for
    a device with another port, and, with speed, lean angle, acceleration and reason, where there is no equilibrium.

        >>> found = mf.trim("tum_2020", "rider:mean_2011", speed=20, lean=20)
        >>> found["steer_torque"].round(1), found["wobble"].frequency.round(1)
        (array([-3.7]), array([11.]))
        >>> mf.trim("tum_2020", speed=30, lean=20, longitudinal_acceleration=[-3, 0, 3])["front_load"].round()
        array([1349., 1052.,  760.])
        >>> mf.trim("tum_2020", speed=20, lean=65)
        Traceback (most recent call last):
        fmus.support.errors.InputError: no steady turning at 20 m/s and a lean angle of 65 deg: ...
    """
    leans = checked("lean angles", "deg", lean, LARGEST_LEAN)
    accelerations = checked("longitudinal accelerations", "m/s2", longitudinal_acceleration, LARGEST_ACCELERATION)
    if len(leans) != len(accelerations) and 1 not in (len(leans), len(accelerations)):
        raise InputError(
            f"{len(leans)} lean angles and {len(accelerations)} accelerations: give as many, or one of them"
        )
    leans, accelerations = (np.array(each) for each in np.broadcast_arrays(leans, accelerations))
    if np.ndim(speed):
        raise InputError(f"trim takes one speed [m/s], not {np.size(speed)}; lean can be several")
    corner = in_corner(vehicle, device, set, speed)
    whole, devices, turning = corner.whole, corner.devices, corner.turning
    found = [turning.at(*point) for point in zip(np.radians(leans), accelerations, strict=True)]
    rows = [_quantities(turning, each) for each in found]
    modes = corner_modes(turning, whole, devices, np.radians(leans), accelerations)
    return Trim(
        whole.name,
        ", ".join(d.name for d in devices) or "none",
        assumed(whole, devices),
        turning.speed,
        accelerations,
        leans,
        {name: np.array([row[name] for row in rows]) for name in QUANTITIES},
        modes.eigenvalues,
        modes.named,
    )


def _range(values: np.ndarray) -> str:
    return f"{values[0]:g}" if (values == values[0]).all() else f"{values.min():g} to {values.max():g}"


def _quantities(turning: SteadyTurning, at: Equilibrium) -> dict[str, float]:
    """QUANTITIES at an equilibrium."""
    found, place = at.found, turning.motion.place
    side = dict(zip(ENDS, turning.motion.by_tyres(found, at.multipliers[:2])[:2], strict=True))
    used = turning.grip_used(at)
    yaw_rate, u = float(found.w[place["yaw"]]), dict(zip(INPUTS, at.u.tolist(), strict=True))
    tyres = {
        f"{end}_{name}": float(value)
        for end in ENDS
        for name, value in (
            ("load", at.load[end]),
            ("side_force", side[end]),
            ("longitudinal_force", at.longitudinal_force[end]),
            ("longitudinal_slip", found.ratio[end]),
            ("slip_angle", found.slip[end]),
            ("camber_angle", found.wheels[end].camber),
            ("tyre_deflection", found.wheels[end].deflection),
            ("grip_used", used[end]),
        )
    }
    return {
        "steer_angle": float(found.q[place["steer"]]),
        "steer_torque": u["steer_torque"],
        "yaw_rate": yaw_rate,
        "lateral_acceleration": yaw_rate * turning.speed,
        "drive_torque": u["drive_torque"],
        "front_wheel_torque": u["front_wheel_torque"],
        **{name: float(found.q[place[name]]) if name in place else 0.0 for name in (FRONT, REAR)},
        **tyres,
        "residual": at.residual,
    }
