"""The modes of a single-track vehicle over speed: eigenvalues, frequencies, damping ratios, unstable intervals."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fmus.linear_analysis.eigenvalue_tracking import track_eigenvalues, unstable_intervals
from fmus.support.errors import InputError, unknown
from fmus.support.notebook import html, new_axes
from vehicle_fmu.mode_curves import factors_of, mode_curves
from vehicle_fmu.mode_names import FINE, MODES, masks, name_modes
from vehicle_fmu.mode_shapes import Linearised, ModeShapes

REFERENCE_SPEED = 60.0  # m/s
LOWEST_SPEED = 1.0  # m/s: lower end of the internal grid, unless lower speeds are requested
UNSTABLE_HALF = "unstable half-plane"


@dataclass(frozen=True, repr=False)
class Mode:
    """One mode over speeds (n,). eigenvalue (n,) complex with Im >= 0 [1/s], NaN where the mode is absent."""

    eigenvalue: np.ndarray

    @property
    def frequency(self) -> np.ndarray:
        """Damped frequency Im / 2 pi (n,) [Hz]; 0 where the mode has split into real roots, NaN where it is absent."""
        return self.eigenvalue.imag / (2 * np.pi)

    @property
    def damping_ratio(self) -> np.ndarray:
        """-Re / |lambda| (n,) [1]; NaN where the mode does not oscillate."""
        ratio = np.full(self.eigenvalue.shape, np.nan)
        return np.divide(-self.eigenvalue.real, np.abs(self.eigenvalue), out=ratio, where=self.eigenvalue.imag > 0)

    def to_dict(self) -> dict[str, Any]:
        """eigenvalue [1/s], frequency [Hz] and damping_ratio [1]: the keys of a mode in JSON."""
        return {"eigenvalue": list(self.eigenvalue), "frequency": self.frequency, "damping_ratio": self.damping_ratio}

    def __repr__(self) -> str:
        present = self.eigenvalue[~np.isnan(self.eigenvalue)]
        if not len(present):
            return "Mode(absent)"
        low, high = present.imag.min() / (2 * np.pi), present.imag.max() / (2 * np.pi)
        where = f"{len(present)} of {len(self.eigenvalue)} speeds"
        return f"Mode({where}, {low:.2f} to {high:.2f} Hz, largest real part {present.real.max():.3g} 1/s)"


@dataclass(frozen=True, repr=False)
class Modes:
    """The spectrum over speeds (n,) [m/s]: all eigenvalues (n, nx) [1/s], the named modes, and where each is unstable.

    unstable maps every present mode to its intervals [from, to] in m/s. mixed holds the intervals of speed in
    which rider-wobble and rear wobble have exchanged so much character that either name applies.

        found = modes(over_speed(ridden(motorcycles.load("sharp_1971"))), np.arange(1, 60))
        found["weave"].damping_ratio, found.unstable["weave"]
    """

    speed: np.ndarray
    eigenvalues: np.ndarray
    named: dict[str, Mode]
    unstable: dict[str, list[list[float]]]
    mixed: list[list[float]]

    def __getitem__(self, mode: str) -> Mode:
        """The mode of that name. Raises InputError with the valid names for any other."""
        if mode not in self.named:
            raise unknown("mode", mode, self.named)
        return self.named[mode]

    @property
    def title(self) -> str:
        """What a figure or a table of the modes is called."""
        return "modes"

    def __repr__(self) -> str:
        speeds = f"{len(self.speed)} speeds, {self.speed[0]:g} to {self.speed[-1]:g} m/s"
        return f"{type(self).__name__}({self.title}: {speeds}; {', '.join(self.unstable)})"

    def _repr_html_(self) -> str:
        rows = [
            (mode, _hertz(self[mode]), ", ".join(f"{a:.1f} to {b:.1f}" for a, b in bands) or "none")
            for mode, bands in self.unstable.items()
        ]
        return html(
            f"{self.title}, {self.speed[0]:g} to {self.speed[-1]:g} m/s",
            ("mode", "damped frequency [Hz]", "unstable at [m/s]"),
            rows,
            self.plot,
        )

    def plot(self, axes: Any = None, label: str = "") -> Any:
        """The root locus of the named modes on axes of matplotlib, which are returned; new ones unless given.

        Real roots lie on the axis Im = 0; the unstable half-plane is shaded. With a label all modes have one colour
        and the legend shows the label, so that several spectra fit into one figure.
        """
        axes = new_axes() if axes is None else axes
        (colour,) = {line.get_color() for line in axes.plot([], [], ".-", label=label)} if label else (None,)
        for mode in self.unstable:
            values = self[mode].eigenvalue
            (line,) = axes.plot(
                values.real,
                values.imag,
                ".-",
                markersize=3,
                linewidth=0.8,
                color=colour,
                label="" if label else mode.replace("_", "-"),
            )
            end = np.flatnonzero(~np.isnan(values))[-1:]
            if label and len(end):
                axes.annotate(
                    mode.replace("_", "-"),
                    (values[end[0]].real, values[end[0]].imag),
                    fontsize="small",
                    color=line.get_color(),
                )
        if all(patch.get_gid() != UNSTABLE_HALF for patch in axes.patches):
            limits = axes.dataLim.frozen()
            axes.axvspan(0.0, 1e6, color="#f4d6d6", zorder=0, gid=UNSTABLE_HALF)
            axes.dataLim.set(limits)  # the shaded half must not set the limits of the axis
            axes.autoscale_view()
        axes.set(xlabel="real part [1/s]", ylabel="imaginary part [rad/s]", title=self.title)
        axes.legend()
        return axes

    def to_dict(self) -> dict[str, Any]:
        """speed, eigenvalues, modes, unstable, mixed: the keys that `motofmi modes --json` writes."""
        return {
            "speed": self.speed,
            "eigenvalues": self.eigenvalues,
            "modes": {name: mode.to_dict() for name, mode in self.named.items()},
            "unstable": self.unstable,
            "mixed": self.mixed,
        }

    def to_dataframe(self) -> Any:
        """One row for each speed (pandas.DataFrame); the unit is in the name of every column."""
        import pandas as pd  # noqa: PLC0415 - imported on use

        columns = {"speed [m/s]": self.speed}
        for mode in self.unstable:
            found = self[mode]
            columns |= {f"{mode} real [1/s]": found.eigenvalue.real, f"{mode} imag [rad/s]": found.eigenvalue.imag,
                        f"{mode} frequency [Hz]": found.frequency,
                        f"{mode} damping ratio [1]": found.damping_ratio}  # fmt: skip
        return pd.DataFrame(columns)

    def to_xarray(self) -> Any:
        """eigenvalue, frequency and damping_ratio over mode and speed (xarray.Dataset), units as attributes."""
        import xarray as xr  # noqa: PLC0415 - imported on use

        def over(quantity: str, unit: str) -> Any:
            return (
                ("mode", "speed"),
                np.array([getattr(self[mode], quantity) for mode in self.unstable]),
                {"units": unit},
            )

        units = {"eigenvalue": "1/s", "frequency": "Hz", "damping_ratio": "1"}
        return xr.Dataset(
            {quantity: over(quantity, unit) for quantity, unit in units.items()},
            {"mode": list(self.unstable), "speed": ("speed", self.speed, {"units": "m/s"})},
        )


def _hertz(mode: Mode) -> str:
    """The range of a mode's damped frequency as text."""
    present = mode.frequency[~np.isnan(mode.frequency)]
    return f"{present.min():.2f} to {present.max():.2f}" if len(present) else "-"


def modes(linearised: Linearised, speeds: np.ndarray, reference_speed: float = REFERENCE_SPEED) -> Modes:
    """The named modes of a vehicle at ascending speeds (n,) [m/s]; names do not depend on the requested speeds.

    linearised maps speeds (m,) to stacked state spaces with outputs, as `over_speed` returns it. Raises InputError for
    speeds that are not finite, not negative and ascending. Modes: Sharp, J. Mech. Eng. Sci. 13(5) (1971).
    """
    speeds = ascending_speeds(speeds)

    def matrices(v: np.ndarray) -> np.ndarray:
        return linearised(v).A

    branches = track_eigenvalues(matrices, _grid(speeds, reference_speed))
    names = name_modes(linearised, branches, reference_speed)
    where = np.searchsorted(branches.parameter, speeds)
    inside = slice(where[0], where[-1] + 1)
    width = branches.eigenvalues.shape[1]

    def shapes(at: np.ndarray) -> ModeShapes:
        return ModeShapes.at(branches.parameter[at], linearised, branches)

    def typical(at: np.ndarray) -> np.ndarray:
        distinct = ModeShapes.at(np.array([names.speed]), linearised, branches)
        return np.repeat(factors_of(distinct, masks([names.above], width)), len(at), axis=0)

    found = mode_curves(branches.eigenvalues, names.masks(branches.parameter, width), shapes, typical)
    curves = dict(zip(MODES, found, strict=True))
    named = {mode: Mode(curve[where]) for mode, curve in curves.items()}
    unstable = {mode: unstable_intervals(matrices, branches.parameter[inside], curves[mode].real[inside])
                for mode in names.present}  # fmt: skip
    return Modes(speeds, branches.eigenvalues[where], named, unstable, names.mixed)


def ascending_speeds(given: ArrayLike) -> np.ndarray:
    """Speeds (n,) [m/s]. Raises InputError for speeds that are not finite, not negative and ascending."""
    speeds = np.atleast_1d(np.asarray(given, float))
    fine = speeds.ndim == 1 and np.isfinite(speeds).all() and (speeds >= 0).all() and (np.diff(speeds) > 0).all()
    if not fine:
        raise InputError(
            f"speeds must be finite, not negative and ascending [m/s], not {np.array2string(speeds, threshold=6)}"
        )
    return speeds


def _grid(speeds: np.ndarray, reference_speed: float) -> np.ndarray:
    """The internal grid: tenths of m/s from the lowest to the naming speed, and the requested speeds."""
    low, high = min(speeds[0], LOWEST_SPEED), max(speeds[-1], reference_speed)
    tenths = FINE * np.arange(int(np.ceil(low / FINE - 1e-9)), int(np.floor(high / FINE + 1e-9)) + 1)
    nearest = np.abs(tenths[np.searchsorted(tenths, speeds - FINE / 2).clip(max=len(tenths) - 1)] - speeds)
    return np.sort(np.concatenate([tenths, speeds[nearest > 1e-9]]))
