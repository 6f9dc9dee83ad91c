"""An estimated frequency response function: the inertance over bands of frequency, with its uncertainty."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import pi
from typing import Any

import numpy as np

from fmus.support.errors import InputError
from fmus.support.notebook import html, new_axes
from motofmi.frequency_response.figures import draw_amplitude_and_phase, draw_modulus
from motofmi.recordings.channels import STEER_TORQUE

NODES = np.cos(pi * np.arange(8, -1, -1) / 8)  # in a band, at which a model is evaluated; exact to degree 8
CENTRE = np.eye(9, dtype=complex)[4]  # the weights of a measurement at one frequency


@dataclass(frozen=True, repr=False)
class FRF:
    """An estimated inertance over n bands.

    frequency (n,) [Hz], inertance (n,) complex [(rad/s2)/(N.m)], variance (n,) of the apparent inertia
    1/inertance, E|error|^2 [kg2.m4], coherence (n,), weights (n, 9) complex of the apparent inertia at
    `nodes` (n, 9) [Hz]. modulus_deviation and phase_deviation [rad] (n,) over the `runs` that it is the mean
    of, NaN for fewer than two.
    """

    name: str
    frequency: np.ndarray
    inertance: np.ndarray
    variance: np.ndarray
    coherence: np.ndarray
    nodes: np.ndarray
    weights: np.ndarray
    modulus_deviation: np.ndarray
    phase_deviation: np.ndarray
    runs: np.ndarray
    reference: str = ""
    warnings: tuple[str, ...] = ()

    @property
    def omega(self) -> np.ndarray:
        """Angular frequency (n,) [rad/s]."""
        return 2 * pi * self.frequency

    @property
    def receptance(self) -> np.ndarray:
        """Angle over torque [rad/(N.m)]."""
        return self.inertance / -(self.omega**2)

    @property
    def impedance(self) -> np.ndarray:
        """Torque over rate [N.m.s/rad]."""
        return 1j * self.omega / self.inertance

    @property
    def apparent_inertia(self) -> np.ndarray:
        """Torque over acceleration [kg.m2]."""
        return 1 / self.inertance

    @property
    def standard_error(self) -> np.ndarray:
        """Of the inertance's modulus, and relative to it of the phase [rad] (n,)."""
        return np.abs(self.inertance) ** 2 * np.sqrt(self.variance / 2)

    def confidence(self, factor: float = 1.96) -> tuple[np.ndarray, np.ndarray]:
        """Half widths (n,) of the modulus [(rad/s2)/(N.m)] and of the phase [rad]; 1.96 is 95 %."""
        return factor * self.standard_error, factor * self.standard_error / np.abs(self.inertance)

    @property
    def repeated(self) -> np.ndarray:
        """Which bands (n,) are means of two runs or more."""
        return np.isfinite(self.modulus_deviation)

    @property
    def deviation(self) -> tuple[np.ndarray, np.ndarray]:
        """Of the modulus [(rad/s2)/(N.m)] and of the phase [rad] (n,): standard deviations over the runs, for a single
        one 95 % confidence."""
        modulus, phase = self.confidence()
        return np.where(self.repeated, self.modulus_deviation, modulus), np.where(
            self.repeated, self.phase_deviation, phase
        )

    def between(self, low: float, high: float) -> "FRF":
        """The bands from low to high [Hz], both included. Raises InputError when none is left."""
        kept = (self.frequency >= low - 1e-9) & (self.frequency <= high + 1e-9)
        if not kept.any():
            raise InputError(
                f"{self.name}: nothing between {low:g} and {high:g} Hz (measured: {self.frequency[0]:g} to "
                f"{self.frequency[-1]:g} Hz)"
            )
        arrays: dict[str, Any] = {
            key: value[kept] for key, value in vars(self).items() if isinstance(value, np.ndarray)
        }
        return replace(self, **arrays)

    def __repr__(self) -> str:
        ends = f"{self.frequency[0]:g} to {self.frequency[-1]:g} Hz" if len(self.frequency) else "none"
        doubts = f", {len(self.warnings)} warning{'s' if len(self.warnings) > 1 else ''}" if self.warnings else ""
        return f"FRF({self.name!r}: inertance at {len(self.frequency)} frequencies, {ends}{doubts})"

    def _repr_html_(self) -> str:
        frame = self.to_dataframe()
        rows = [tuple(f"{value:.4g}" for value in row) for row in frame.to_numpy()]
        return html(
            ". ".join([repr(self), *self.warnings]), list(frame.columns), rows, lambda axes: draw_modulus(axes, self)
        )

    def plot(self, axes: Any = None) -> Any:
        """Modulus above phase over frequency, each with its band: two axes of matplotlib, which are returned;
        new ones unless given."""
        axes = new_axes(2, sharex=True, figsize=(7.5, 6.5)) if axes is None else axes
        draw_amplitude_and_phase(axes, self)
        return axes

    def to_dict(self) -> dict[str, Any]:
        """Arrays by name: frequency [Hz], inertance [(rad/s2)/(N.m)] complex, its standard error, coherence; name,
        reference, warnings."""
        return {"name": self.name, "reference": self.reference, "frequency": self.frequency,
                "inertance": self.inertance, "standard_error": self.standard_error, "coherence": self.coherence,
                "warnings": list(self.warnings)}  # fmt: skip

    def to_dataframe(self) -> Any:
        """One row for each band (pandas.DataFrame); the unit is in the name of every column."""
        import pandas as pd  # noqa: PLC0415 - imported on use

        phase_error = np.degrees(self.standard_error / np.abs(self.inertance))
        return pd.DataFrame({"frequency [Hz]": self.frequency, "modulus [(rad/s2)/(N.m)]": np.abs(self.inertance),
                             "modulus standard error [(rad/s2)/(N.m)]": self.standard_error,
                             "phase [deg]": np.degrees(np.angle(self.inertance)),
                             "phase standard error [deg]": phase_error, "coherence [1]": self.coherence})  # fmt: skip

    def to_control(self) -> Any:
        """The inertance as python-control's FRD over rad/s, from `steer_torque` [N.m] to
        `steer_acceleration` [rad/s2]."""
        import control  # noqa: PLC0415 - imported on use

        return control.frd(self.inertance, self.omega, inputs=[STEER_TORQUE], outputs=["steer_acceleration"])


def mean_frf(frfs: Sequence[FRF], name: str = "mean") -> FRF:
    """The mean of several FRFs, of modulus and phase each (as both papers take it), with their deviations.

    The mean rider is identified from this mean, not from averaged parameters. The mean of one FRF is that FRF.
    """
    if len(frfs) == 1:
        return frfs[0]
    frequency = np.unique(np.round(np.concatenate([f.frequency for f in frfs]), 9))

    def table(values: Callable[[FRF], np.ndarray]) -> np.ndarray:
        rows = np.full((len(frfs), len(frequency)), np.nan, complex)
        for row, frf in zip(rows, frfs, strict=True):
            row[np.searchsorted(frequency, np.round(frf.frequency, 9))] = values(frf)
        return rows

    inertance = table(lambda f: f.inertance)
    here = ~np.isnan(inertance)
    runs = here.sum(axis=0)
    direction = np.nansum(np.exp(1j * np.angle(inertance)), axis=0)
    turn = np.angle(inertance / direction)  # phases around their mean direction, where none of them wraps
    modulus, phase = np.nanmean(np.abs(inertance), axis=0), np.angle(direction) + np.nanmean(turn, axis=0)
    mean = modulus * np.exp(1j * phase)

    def deviation(values: np.ndarray) -> np.ndarray:
        squares = np.nansum((values - np.nanmean(values, axis=0)) ** 2, axis=0)
        return np.where(runs > 1, np.sqrt(squares / np.maximum(runs - 1, 1)), np.nan)

    own = np.nansum(np.abs(table(lambda f: np.sqrt(f.variance))) ** 2, axis=0) / runs**2
    spread = (deviation(np.abs(inertance)) ** 2 + (modulus * deviation(turn)) ** 2) / modulus**4 / runs
    return FRF(name, frequency, mean, np.fmax(own, spread), np.real(np.nanmean(table(lambda f: f.coherence), axis=0)),
               frequency[:, None] + 0 * NODES, np.tile(CENTRE, (len(frequency), 1)),
               deviation(np.abs(inertance)), deviation(turn), runs, frfs[0].reference,
               tuple(f"{f.name}: {w}" for f in frfs for w in f.warnings))  # fmt: skip


def exact_frf(frequency: np.ndarray, inertance: np.ndarray, name: str = "exact") -> FRF:
    """An FRF that was not estimated: one from a model, from a paper's figure, or from another program.

    frequency (n,) [Hz], inertance (n,) complex [(rad/s2)/(N.m)]; all points have the same weight.
    """
    frequency, inertance = np.asarray(frequency, float), np.asarray(inertance, complex)
    ones, none = np.ones(len(frequency)), np.full(len(frequency), np.nan)
    return FRF(name, frequency, inertance, np.abs(1 / inertance) ** 2 * 1e-4, ones, frequency[:, None] + 0 * NODES,
               np.tile(CENTRE, (len(frequency), 1)), none, none, ones)  # fmt: skip
