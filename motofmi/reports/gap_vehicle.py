"""Figures of a vehicle's gap: eigenvalues over speed, and spectra of the residuals of recorded runs."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.preprocessing.predicted_run import PredictedRun
from motofmi.gap.preprocessing.weak_form import WeakFormRun
from motofmi.gap.selection.model_selection import Verdict
from motofmi.reports.figures import COLOURS, new_figure


def eigenvalues_of(found: Fit, speeds: np.ndarray) -> np.ndarray:
    """The eigenvalues (n, nx) of a fit at speeds (n,)."""
    model: Any = found.model
    return np.linalg.eigvals(model.linearised(found.shared, speeds)[0].A)


def eigenvalues_over_speed(verdict: Verdict) -> Figure:
    """Measured eigenvalues with their errors, and those of the base and of the best fit."""
    figure, axes = new_figure(columns=2, width=11.0, sharex=True)
    for run in verdict.base.runs:
        seen = run.oscillates
        axes[0].errorbar(run.over, run.value.real, run.real_error, fmt=".", color=COLOURS["reference"])
        axes[1].errorbar(
            run.over[seen],
            run.value[seen].imag / (2 * np.pi),
            run.imag_error[seen] / (2 * np.pi),
            fmt=".",
            color=COLOURS["reference"],
        )
        speeds = np.linspace(run.over.min(), run.over.max(), 200)
        for fit, colour in ((verdict.base, COLOURS["damper"]), (verdict.best, COLOURS["rider"])):
            spectra = eigenvalues_of(fit, speeds)
            kept = (spectra.imag >= 0) & (spectra.real > 1.3 * run.value.real.min() - 1)
            over = np.broadcast_to(speeds[:, None], spectra.shape)
            axes[0].plot(over[kept], spectra[kept].real, ",", color=colour)
            kept &= spectra.imag > 0
            axes[1].plot(over[kept], spectra[kept].imag / (2 * np.pi), ",", color=colour)
    top = max(run.value.imag.max() for run in verdict.base.runs) / (2 * np.pi)
    axes[0].set(xlabel="speed [m/s]", ylabel="real part [1/s]")
    axes[1].set(xlabel="speed [m/s]", ylabel="frequency [Hz]", ylim=(0, 1.2 * top + 0.1))
    for colour, label in (
        (COLOURS["reference"], "measured"),
        (COLOURS["damper"], "base"),
        (COLOURS["rider"], "with the effects found"),
    ):
        axes[0].plot([], [], "o", markersize=3, color=colour, label=label)
    axes[0].legend()
    return figure


def weak_form_spectra(verdict: Verdict, given: Fit) -> Figure:
    """Spectra of measured accelerations and of each fit's residuals in the first run, one panel per equation.

    given is the vehicle without a fit.
    """
    run: WeakFormRun = verdict.best.runs[0]
    figure, axes = new_figure(columns=len(run.rates), width=11.0, sharex=True)
    fits = [
        (given, COLOURS["changed"], "as given"),
        (verdict.base, COLOURS["damper"], "base, refitted"),
        (verdict.best, COLOURS["rider"], "with the effects found"),
    ]
    for i, (name, ax) in enumerate(zip(run.rates, axes, strict=True)):
        ax.semilogy(
            run.frequency, np.sqrt(np.mean(run.measured[i] ** 2, axis=0)), color=COLOURS["reference"], label="measured"
        )
        for each, colour, label in fits:
            model: Any = each.model
            left = run.measured[i] - run.tested(model.accelerations(run, each.shared))[i]
            left = left - (left @ run.nuisance) @ np.linalg.pinv(run.nuisance.T @ run.nuisance) @ run.nuisance.T
            ax.semilogy(run.frequency, np.sqrt(np.mean(left**2, axis=0)), color=colour, label=label)
        ax.semilogy(run.frequency, np.sqrt(run.densities[i](run.frequency)), "k--", linewidth=0.8, label="disturbance")
        ax.set(xlabel="frequency [Hz]", ylabel=f"{name.replace('_', ' ')}: derivative [rad/s2]")
    axes[0].legend()
    return figure


def prediction_spectra(verdict: Verdict) -> Figure:
    """Spectra of measured outputs and of each fit's prediction errors in the first run, one panel per output."""
    run: PredictedRun = verdict.best.runs[0]
    figure, axes = new_figure(columns=len(run.outputs), width=4.0 + 3.0 * len(run.outputs), sharex=True, squeeze=False)
    shape = (len(run.outputs), len(run.blocks), len(run.frequency))
    floor = np.stack([np.sqrt(d(run.frequency)) for d in run.densities])
    assert run.mixing is not None
    measured = np.sqrt(
        np.mean(np.einsum("ij,jbk->ibk", np.linalg.inv(run.mixing), run.cosines(run.measured)) ** 2, axis=1)
    )
    own = np.linalg.inv(run.mixing)
    lines: list[tuple[Any, str, str]] = [
        (verdict.base, COLOURS["damper"], "base, refitted"),
        (verdict.best, COLOURS["rider"], "with the effects found"),
    ]
    for i, (name, ax) in enumerate(zip(run.outputs, axes.flat, strict=True)):
        ax.loglog(run.frequency, measured[i], color=COLOURS["reference"], label="measured")
        for each, colour, label in lines:
            left = each.residuals[: int(np.prod(shape))].reshape(shape) * floor[:, None]
            ax.loglog(
                run.frequency,
                np.sqrt(np.mean(np.einsum("ij,jbk->ibk", own, left)[i] ** 2, axis=0)),
                color=colour,
                label=label,
                linewidth=0.9,
            )
        ax.loglog(run.frequency, np.sqrt((own[i] ** 2) @ floor**2), "k--", linewidth=0.8, label="best prediction")
        ax.set(xlabel="frequency [Hz]", ylabel=f"{name.replace('_', ' ')} [{run.recording.units[name]}]")
    axes.flat[0].legend()
    return figure
