"""Amplitude and phase of an inertance over frequency, measured with its band, as the papers show it
(2011, Fig. 3). `frf` is an FRF."""

from typing import Any

import numpy as np

INERTANCE = "[(rad/s$^2$)/(N m)]"
BAND, FITTED = "#888888", "#c55a11"

Curve = tuple[np.ndarray, np.ndarray]  # frequency [Hz], inertance


def draw_amplitude_and_phase(axes: Any, frf: Any, fitted: Curve | None = None) -> None:
    """Modulus on the first and phase [deg] on the second of two axes of matplotlib, with a fitted
    curve if there is one."""
    upper, lower = axes
    phase = np.degrees(np.unwrap(np.angle(frf.inertance)))
    phase -= 360 * np.round(np.median(phase - 90) / 360)
    draw_modulus(upper, frf)
    _with_band(lower, frf.frequency, phase, np.degrees(frf.deviation[1]), "")
    if fitted is not None:
        upper.plot(fitted[0], np.abs(fitted[1]), color=FITTED, label="fitted")
        lower.plot(fitted[0], np.degrees(np.angle(fitted[1])), color=FITTED)
    lower.set_ylim(-30, 210)
    lower.set_ylabel("phase [deg]")
    lower.set_xlabel("frequency [Hz]")
    upper.set_xlabel("")
    upper.legend(loc="best")


def draw_modulus(axes: Any, frf: Any) -> None:
    """Modulus over frequency with its band on axes of matplotlib."""
    modulus = np.abs(frf.inertance)
    label = r"$\mu \pm \sigma$ over runs" if frf.repeated.any() else "95 % confidence"
    _with_band(axes, frf.frequency, modulus, frf.deviation[0], label)
    axes.set_ylim(0, 1.3 * np.percentile(modulus, 98))
    axes.set(xlabel="frequency [Hz]", ylabel=f"|inertance| {INERTANCE}")


def _with_band(axes: Any, frequency: np.ndarray, value: np.ndarray, half: np.ndarray, label: str) -> None:
    # A band without information shall not determine the scale of the axis.
    half = np.minimum(half, 10 * np.nanmedian(np.abs(value)))
    axes.fill_between(frequency, value - half, value + half, color=BAND, alpha=0.35, linewidth=0, label=label)
    axes.plot(frequency, value, ".", color="black", markersize=4, label="measured")
