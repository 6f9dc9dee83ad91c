"""The figures of the papers: amplitude and phase of the inertance with the band mu +- sigma, and the Nyquist plane."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from fmus.errors import InputError
from fmus.files import write_beside
from identification.fit import Identification
from identification.frf import FRF
from identification.response import Response
from identification.roll import RollFRF
from scenarios.report import COLOURS, new_figure

INERTANCE = "[(rad/s$^2$)/(N m)]"


Curve = tuple[np.ndarray, np.ndarray]  # frequency [Hz], inertance


def fitted_curve(found: Identification, model: Response) -> Curve:
    """The identified model over the measured frequencies, finely."""
    frequency = np.linspace(min(f.frequency[0] for f in found.frfs), max(f.frequency[-1] for f in found.frfs), 400)
    return frequency, model(2 * np.pi * frequency, found.values)


def amplitude_and_phase(mean: FRF, fitted: Curve | None = None) -> Figure:
    """Modulus and phase over frequency, measured with its band, and the fitted curve (2011, Fig. 3)."""
    figure, (upper, lower) = new_figure(1, 2, width=7.5, height=6.5, sharex=True)
    modulus, phase = np.abs(mean.inertance), np.degrees(np.unwrap(np.angle(mean.inertance)))
    phase -= 360 * np.round(np.median(phase - 90) / 360)
    repeats = np.isfinite(mean.modulus_deviation)
    band, turn = (np.where(repeats, a, b) for a, b in zip((mean.modulus_deviation, mean.phase_deviation), mean.confidence(), strict=True))
    label = r"$\mu \pm \sigma$ over runs" if repeats.any() else "95 % confidence"
    for axis, value, half in ((upper, modulus, band), (lower, phase, np.degrees(turn))):
        half = np.minimum(half, 10 * np.nanmedian(np.abs(value)))  # a band without information does not set the scale
        axis.fill_between(mean.frequency, value - half, value + half, color=COLOURS["reference"], alpha=0.35, linewidth=0, label=label)
        axis.plot(mean.frequency, value, ".", color="black", markersize=4, label="measured")
    if fitted is not None:
        upper.plot(fitted[0], np.abs(fitted[1]), color=COLOURS["damper"], label="fitted")
        lower.plot(fitted[0], np.degrees(np.angle(fitted[1])), color=COLOURS["damper"])
    upper.set_ylim(0, 1.3 * np.percentile(modulus, 98))
    lower.set_ylim(-30, 210)
    upper.set_ylabel(f"|inertance| {INERTANCE}")
    lower.set_ylabel("phase [deg]")
    lower.set_xlabel("frequency [Hz]")
    upper.legend(loc="best")
    return figure


def nyquist(found: Identification, curve: Curve) -> Figure:
    """Measured points against the fitted curve in the Nyquist plane (2011, Fig. 5)."""
    figure, axis = new_figure(width=5.5, height=5.5)
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
    return figure


def roll(frf: RollFRF) -> Figure:
    """Amplitude and phase of FRF_i and rFRF_i at waist, shoulders and head (2008, Figs 16 to 23)."""
    figure, axes = new_figure(2, 2, width=9.0, height=6.5, sharex=True)
    for column, (name, curves) in enumerate((("FRF", frf.absolute), ("rFRF", frf.relative))):
        for marker, (point, curve) in zip("os^", curves.items(), strict=False):
            phase = np.degrees(np.unwrap(np.angle(curve)))
            axes[0, column].plot(frf.frequency, np.abs(curve), marker + "-", markersize=3, linewidth=1, label=point)
            axes[1, column].plot(frf.frequency, phase, marker + "-", markersize=3, linewidth=1)
        axes[0, column].set_ylabel(f"|{name}| [1]")
        axes[1, column].set_ylabel(f"phase of {name} [deg]")
        axes[1, column].set_xlabel("frequency [Hz]")
    axes[0, 0].legend()
    return figure


def save(figures: Sequence[Figure], path: str | Path) -> list[Path]:
    """Write the figures as .png, .svg or .pdf, numbered where there are several. Raises InputError for another suffix."""
    path = Path(path)
    if path.suffix not in (".png", ".svg", ".pdf"):
        raise InputError(f"--plot {path}: figures are written as .png, .svg or .pdf")
    paths = [path if len(figures) == 1 else path.with_stem(f"{path.stem}_{k}") for k in range(1, len(figures) + 1)]
    for figure, place in zip(figures, paths, strict=True):
        write_beside(place, partial(figure.savefig, dpi=150))
    return paths
