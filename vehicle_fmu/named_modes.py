"""The modes of a single-track vehicle over speed: eigenvalues, frequencies, damping ratios, unstable bands."""

from dataclasses import dataclass

import numpy as np

from fmus.errors import InputError
from fmus.modes import crossings, follow
from vehicle_fmu.mode_names import FINE, MODES, Columns, Linearised, name

NAMING_SPEED = 60.0  # m/s
ABSENT = complex(np.nan, np.nan)
LOWEST_SPEED = 1.0  # m/s: the internal grid goes down to here, or lower where that is asked for


@dataclass(frozen=True)
class Mode:
    """One mode over speeds (n,). eigenvalue (n,) complex with Im >= 0, NaN where the mode is absent [1/s]."""

    eigenvalue: np.ndarray

    @property
    def frequency(self) -> np.ndarray:
        """Damped frequency Im / 2 pi [Hz]; 0 where the mode has split into real roots, NaN where it is absent."""
        return self.eigenvalue.imag / (2 * np.pi)

    @property
    def damping_ratio(self) -> np.ndarray:
        """-Re / |lambda|; NaN where the mode does not oscillate."""
        ratio = np.full(self.eigenvalue.shape, np.nan)
        return np.divide(-self.eigenvalue.real, np.abs(self.eigenvalue), out=ratio, where=self.eigenvalue.imag > 0)


@dataclass(frozen=True)
class Modes:
    """The spectrum over speeds (n,): all eigenvalues (n, nx), the named modes, and where each is unstable.

    unstable maps every present mode to its intervals [from, to] in m/s. mixed holds the intervals of speed in
    which rider-wobble and rear wobble share their character, so that either name would do.
    """

    speed: np.ndarray
    eigenvalues: np.ndarray
    named: dict[str, Mode]
    unstable: dict[str, list[list[float]]]
    mixed: list[list[float]]

    def __getitem__(self, mode: str) -> Mode:
        return self.named[mode]


def modes(linearised: Linearised, speeds: np.ndarray, naming_speed: float = NAMING_SPEED) -> Modes:
    """The named modes of a vehicle at ascending speeds [m/s]; names do not depend on the speeds asked for.

    linearised: from an array of speeds to stacked state spaces, outputs included.
    Raises InputError for speeds that are not finite, positive and ascending.
    """
    speeds = np.atleast_1d(np.asarray(speeds, float))
    if not (np.isfinite(speeds).all() and (speeds > 0).all() and (np.diff(speeds) > 0).all()):
        raise InputError(f"speeds must be finite, positive and ascending [m/s], not {np.array2string(speeds, threshold=6)}")

    def matrices(v: np.ndarray) -> np.ndarray:
        return linearised(v).A

    branches = follow(matrices, _grid(speeds, naming_speed))
    names = name(linearised, branches, naming_speed)
    where = np.searchsorted(branches.parameter, speeds)
    inside = slice(where[0], where[-1] + 1)
    curves = {mode: _curve(branches.eigenvalues, columns) for mode, columns in names.above.items()}
    for below, columns_by_mode in names.below:
        part = branches.parameter <= below + 1e-9
        for mode, columns in columns_by_mode.items():
            curves.setdefault(mode, np.full(len(part), ABSENT))[part] = _curve(branches.eigenvalues[part], columns)
    absent = Mode(np.full(len(speeds), ABSENT))
    named = {mode: Mode(curves[mode][where]) if mode in curves else absent for mode in MODES}
    unstable = {mode: crossings(matrices, branches.parameter[inside], curves[mode].real[inside])
                for mode in MODES if mode in curves}  # fmt: skip
    return Modes(speeds, branches.eigenvalues[where], named, unstable, names.mixed)


def _grid(speeds: np.ndarray, naming_speed: float) -> np.ndarray:
    """The internal grid: tenths of m/s from the lowest to the naming speed, and the speeds asked for."""
    low, high = min(speeds[0], LOWEST_SPEED), max(speeds[-1], naming_speed)
    tenths = FINE * np.arange(np.ceil(low / FINE - 1e-9), np.floor(high / FINE + 1e-9) + 1)
    nearest = np.abs(tenths[np.searchsorted(tenths, speeds - FINE / 2).clip(max=len(tenths) - 1)] - speeds)
    return np.sort(np.concatenate([tenths, speeds[nearest > 1e-9]]))


def _curve(eigenvalues: np.ndarray, columns: Columns) -> np.ndarray:
    """From a mode's branches its eigenvalue (n,): the oscillatory one, else the least stable; NaN without branches.

    Before a mode's own pair is born one of its roots may be of a pair with another mode's; the other root counts then.
    """
    if not columns:
        return np.full(len(eigenvalues), ABSENT)
    own = eigenvalues[:, list(columns)]
    folded = own.real + 1j * np.abs(own.imag)
    apart = np.abs(own[:, :, None] - own[:, None, :].conj()).min(axis=2) > 1e-6 * np.abs(own)
    growth, swing = np.where(apart, -np.inf, folded.real), np.where(apart, -1.0, folded.imag)
    best = np.where((swing > 0).any(axis=1), swing.argmax(axis=1), growth.argmax(axis=1))
    return np.take_along_axis(folded, best[:, None], axis=1)[:, 0]
