"""The figures of the papers: amplitude and phase of the inertance with the band mu +- sigma, and the Nyquist plane."""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from fmus.support.errors import InputError
from fmus.support.files import write_atomically
from motofmi.frequency_response.figures import INERTANCE, Curve, draw_amplitude_and_phase
from motofmi.frequency_response.frf import FRF
from motofmi.frequency_response.response import Response
from motofmi.frequency_response.roll_motion import RollFRF
from motofmi.identification.parameter_fit import Identification
from motofmi.reports.figures import COLOURS, new_figure

SUFFIXES = (".png", ".svg", ".pdf")


def fitted_curve(found: Identification, model: Response) -> Curve:
    """The identified model on a fine grid over the measured frequencies."""
    frequency = np.linspace(min(f.frequency[0] for f in found.frfs), max(f.frequency[-1] for f in found.frfs), 400)
    return frequency, model(2 * np.pi * frequency, found.values)


def amplitude_and_phase(mean: FRF, fitted: Curve | None = None) -> Figure:
    """Modulus and phase over frequency, measured with its band, and the fitted curve (2011, Fig. 3)."""
    figure, axes = new_figure(1, 2, width=7.5, height=6.5, sharex=True)
    draw_amplitude_and_phase(axes, mean, fitted)
    return figure


def identification(found: Identification, mean: FRF, curve: Curve) -> Figure:
    """Amplitude, phase and Nyquist plane side by side."""
    figure, axes = new_figure(3, width=13.0, height=4.2)
    draw_identification(axes, found, mean, curve)
    return figure


def draw_identification(axes: Any, found: Identification, mean: FRF, curve: Curve) -> None:
    """The same on three axes."""
    draw_amplitude_and_phase(axes[:2], mean, curve)
    axes[0].set_xlabel("frequency [Hz]")
    draw_nyquist(axes[2], found, curve)


def nyquist(found: Identification, curve: Curve) -> Figure:
    """Measured points against the fitted curve in the Nyquist plane (2011, Fig. 5)."""
    figure, axis = new_figure(width=5.5, height=5.5)
    draw_nyquist(axis, found, curve)
    return figure


def draw_nyquist(axis: Any, found: Identification, curve: Curve) -> None:
    """The same on given axes."""
    measured, seen = np.concatenate([f.inertance for f in found.frfs]), np.concatenate(found.fitted)
    for a, b in zip(measured, seen, strict=True):
        axis.plot([a.real, b.real], [a.imag, b.imag], color=COLOURS["reference"], linewidth=0.7)
    axis.plot(measured.real, measured.imag, ".", color="black", markersize=4, label="measured")
    frequency, value = curve
    axis.plot(value.real, value.imag, color=COLOURS["damper"], label="fitted")
    for f in (1, 2, 3, 4, 6, 8, 12):
        if frequency[0] <= f <= frequency[-1]:
            at = value[np.argmin(np.abs(frequency - f))]
            axis.annotate(f"{f} Hz", (at.real, at.imag), textcoords="offset points", xytext=(5, 4), fontsize=8)
    middle = complex(value.real.max() + value.real.min(), value.imag.max() + value.imag.min()) / 2
    extent = 0.65 * max(np.ptp(value.real), np.ptp(value.imag))
    axis.set_xlim(middle.real - extent, middle.real + extent)
    axis.set_ylim(middle.imag - extent, middle.imag + extent)
    axis.set_xlabel(f"real part {INERTANCE}")
    axis.set_ylabel(f"imaginary part {INERTANCE}")
    axis.legend(loc="upper right")


def roll(frf: RollFRF) -> Figure:
    """Amplitude and phase of FRF_i and rFRF_i at waist, shoulders and head (2008, Figs 16 to 23)."""
    figure, axes = new_figure(2, 2, width=9.0, height=6.5, sharex=True)
    draw_roll(axes, frf)
    return figure


def draw_roll(axes: Any, frf: RollFRF) -> None:
    """The same on axes (2, 2)."""
    for column, (name, curves) in enumerate((("FRF", frf.absolute), ("rFRF", frf.relative))):
        for marker, (point, curve) in zip("os^", curves.items(), strict=False):
            phase = np.degrees(np.unwrap(np.angle(curve)))
            axes[0, column].plot(frf.frequency, np.abs(curve), marker + "-", markersize=3, linewidth=1, label=point)
            axes[1, column].plot(frf.frequency, phase, marker + "-", markersize=3, linewidth=1)
        axes[0, column].set_ylabel(f"|{name}| [1]")
        axes[1, column].set_ylabel(f"phase of {name} [deg]")
        axes[1, column].set_xlabel("frequency [Hz]")
    axes[0, 0].legend()


def save(figure: Figure, path: str | Path) -> Path:
    """Write the figure as .png, .svg or .pdf; its path. Raises InputError for another suffix."""
    if Path(path).suffix.lower() not in SUFFIXES:
        raise InputError(f"{path}: figures are written as {', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}")
    return write_atomically(path, partial(figure.savefig, dpi=150))
