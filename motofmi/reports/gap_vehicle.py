"""Figures of a vehicle's gap: eigenvalues over speed, and spectra of the residuals of recorded runs."""

from typing import Any

import numpy as np

from fmus.linear_analysis.eigenvalue_tracking import track_eigenvalues
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.preprocessing.predicted_run import PredictedRun
from motofmi.gap.preprocessing.weak_form import WeakFormRun
from motofmi.gap.selection.model_selection import Verdict
from motofmi.reports.charts import Axis, Chart, Curve, Panel

FOUND = "with the effects found"
HERTZ = 2 * np.pi


def eigenvalues_of(found: Fit, speeds: np.ndarray) -> np.ndarray:
    """The eigenvalues (n, nx) of a fit at speeds (n,)."""
    model: Any = found.model
    return np.linalg.eigvals(model.linearised(found.shared, speeds)[0].A)


def eigenvalues_over_speed(verdict: Verdict) -> Chart:
    """Measured eigenvalues with their standard errors, and those of the base and of the best fit."""
    real, frequency = [], []
    fits = [(verdict.base, "base", "dashed", "base"), (verdict.best, "found", "line", FOUND)]
    for run in verdict.base.runs:
        seen, value = run.oscillates, run.value
        text = [f"{mode or 'eigenvalue'}, {run.name}" for mode in run.mode]
        real.append(
            Curve(
                "measured",
                run.over,
                value.real,
                "measured",
                "errors",
                (value.real - run.real_error, value.real + run.real_error),
                text,
            )
        )
        f, error = value.imag[seen] / HERTZ, run.imag_error[seen] / HERTZ
        frequency.append(
            Curve(
                "measured",
                run.over[seen],
                f,
                "measured",
                "errors",
                (f - error, f + error),
                [t for t, s in zip(text, seen, strict=True) if s],
            )
        )
        speeds = np.linspace(run.over.min(), run.over.max(), 100)
        for fit, colour, style, label in fits if verdict.best.model.effects else fits[:1]:
            for branch in branches(fit, speeds).T:
                shown = np.where((branch.imag >= 0) & (branch.real > 1.3 * value.real.min() - 1), branch, np.nan)
                if np.isfinite(shown.real).any():
                    real.append(Curve(label, speeds, shown.real, colour, style))
                if np.nanmax(shown.imag, initial=0) > 0:
                    frequency.append(
                        Curve(label, speeds, np.where(shown.imag > 0, shown.imag, np.nan) / HERTZ, colour, style)
                    )
    top = float(f"{1.2 * max(run.value.imag.max() for run in verdict.base.runs) / HERTZ + 0.1:.2g}")
    speed = Axis("speed", "m/s")
    return Chart(
        [
            Panel(speed, Axis("real part", "1/s"), real, hover="point", height=360),
            Panel(speed, Axis("frequency", "Hz", low=0.0, high=top), frequency, hover="point", height=360),
        ],
        columns=2,
    )


def branches(found: Fit, speeds: np.ndarray) -> np.ndarray:
    """The eigenvalues (n, nx) of a fit, each column followed over the speeds (n,)."""
    model: Any = found.model
    return track_eigenvalues(lambda v: model.linearised(found.shared, v)[0].A, speeds).eigenvalues


def weak_form_spectra(verdict: Verdict, given: Fit) -> Chart:
    """Spectra of measured accelerations and of each fit's residuals in the first run, one panel per equation.

    given is the vehicle without a fit.
    """
    run: WeakFormRun = verdict.best.runs[0]
    fits = [(given, "changed", "as given"), (verdict.base, "base", "base, refitted"), (verdict.best, "found", FOUND)]
    panels = []
    for i, name in enumerate(run.rates):
        curves = [Curve("measured", run.frequency, np.sqrt(np.mean(run.measured[i] ** 2, axis=0)))]
        for each, colour, label in fits if verdict.best.model.effects else fits[:2]:
            model: Any = each.model
            left = run.measured[i] - run.tested(model.accelerations(run, each.shared))[i]
            left = left - (left @ run.nuisance) @ np.linalg.pinv(run.nuisance.T @ run.nuisance) @ run.nuisance.T
            curves.append(Curve(f"residual, {label}", run.frequency, np.sqrt(np.mean(left**2, axis=0)), colour))
        curves.append(
            Curve("disturbance", run.frequency, np.sqrt(run.densities[i](run.frequency)), "measured", "dashed")
        )
        panels.append(
            Panel(Axis("frequency", "Hz"), Axis(f"{name.replace('_', ' ')}: derivative", "rad/s2", log=True), curves)
        )
    return Chart(panels, columns=min(len(panels), 2))


def prediction_spectra(verdict: Verdict) -> Chart:
    """Spectra of measured outputs and of each fit's prediction errors in the first run, one panel per output."""
    run: PredictedRun = verdict.best.runs[0]
    shape = (len(run.outputs), len(run.blocks), len(run.frequency))
    floor = np.stack([np.sqrt(d(run.frequency)) for d in run.densities])
    assert run.mixing is not None
    own = np.linalg.inv(run.mixing)
    measured = np.sqrt(np.mean(np.einsum("ij,jbk->ibk", own, run.cosines(run.measured)) ** 2, axis=1))
    fits = [(verdict.base, "base", "base, refitted"), (verdict.best, "found", FOUND)]
    panels = []
    for i, name in enumerate(run.outputs):
        curves = [Curve("measured", run.frequency, measured[i])]
        for each, colour, label in fits if verdict.best.model.effects else fits[:1]:
            left = each.residuals[: int(np.prod(shape))].reshape(shape) * floor[:, None]
            errors = np.sqrt(np.mean(np.einsum("ij,jbk->ibk", own, left)[i] ** 2, axis=0))
            curves.append(Curve(f"prediction error, {label}", run.frequency, errors, colour, width=1.2))
        curves.append(Curve("best prediction", run.frequency, np.sqrt((own[i] ** 2) @ floor**2), "measured", "dashed"))
        panels.append(
            Panel(
                Axis("frequency", "Hz", log=True),
                Axis(name.replace("_", " "), run.recording.units[name], log=True),
                curves,
            )
        )
    return Chart(panels, columns=min(len(panels), 2))
