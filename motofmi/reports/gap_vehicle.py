"""Figures of a vehicle's gap: eigenvalues over speed, and spectra of the residuals of recorded runs."""

from typing import Any

import numpy as np

from fmus.linear_analysis.eigenvalue_tracking import track_eigenvalues
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.preprocessing.eigenvalues import MeasuredEigenvalues
from motofmi.gap.preprocessing.predicted_run import PredictedRun
from motofmi.gap.preprocessing.weak_form import WeakFormRun
from motofmi.gap.selection.result import Verdict
from motofmi.reports.charts import Axis, Chart, Curve, Panel, Shade
from motofmi.reports.gap_before_after import label_of_best

HERTZ = 2 * np.pi
POINTS = {"dashed": "circles", "line": "points"}  # how differences of a fit are drawn whose curve has that style


def eigenvalues_of(found: Fit, speeds: np.ndarray) -> np.ndarray:
    """The eigenvalues (n, nx) of a fit at speeds (n,)."""
    model: Any = found.model
    return np.linalg.eigvals(model.linearised(found.shared, speeds)[0].A)


def eigenvalues_over_speed(verdict: Verdict) -> Chart:
    """Measured eigenvalues with their standard errors, those of the base and of the best fit, and the differences."""
    panels: dict[str, list[Curve]] = {"real": [], "imag": [], "real difference": [], "imag difference": []}
    fits = [(verdict.base, "base", "dashed", "base"), (verdict.best, "found", "line", label_of_best(verdict))]
    for run in verdict.base.runs:
        over, text = run.labels[0], [f"{mode or 'eigenvalue'}, {run.name}" for mode in run.mode]
        text += [t for t, seen in zip(text, run.oscillates, strict=True) if seen]
        parts = {"real": (slice(0, len(run.value)), 1.0), "imag": (slice(len(run.value), None), HERTZ)}
        for part, (rows, unit) in parts.items():
            value, error = run.data[rows] / unit, run.deviation[rows] / unit
            band = (value - error, value + error)
            panels[part].append(Curve("measured", over[rows], value, "measured", "errors", band, text[rows]))
        speeds = np.linspace(run.over.min(), run.over.max(), 100)
        for fit, colour, style, label in fits if verdict.best.model.effects else fits[:1]:
            for branch in branches(fit, speeds).T:
                shown = np.where((branch.imag >= 0) & (branch.real > 1.3 * run.value.real.min() - 1), branch, np.nan)
                if np.isfinite(shown.real).any():
                    panels["real"].append(Curve(label, speeds, shown.real, colour, style))
                if np.nanmax(shown.imag, initial=0) > 0:
                    swinging = np.where(shown.imag > 0, shown.imag, np.nan)
                    panels["imag"].append(Curve(label, speeds, swinging / HERTZ, colour, style))
            left = differences(fit, run)
            for part, (rows, _) in parts.items():
                points = Curve(label, over[rows], left[rows], colour, POINTS[style], text=text[rows])
                panels[f"{part} difference"].append(points)
    top = float(f"{1.2 * max(run.value.imag.max() for run in verdict.base.runs) / HERTZ + 0.1:.2g}")
    speed, within = Axis("speed", "m/s"), [Shade(-2, 2, "two standard errors", "y", "measured")]
    axes = {"real": Axis("real part", "1/s"), "imag": Axis("frequency", "Hz", low=0.0, high=top),
            "real difference": Axis("real part: model minus measured, over its standard error", "1"),
            "imag difference": Axis("frequency: model minus measured, over its standard error", "1")}  # fmt: skip
    return Chart(
        [
            Panel(speed, axes[part], curves, shades=within if "difference" in part else [], hover="point",
                  height=240 if "difference" in part else 360)
            for part, curves in panels.items()
        ],
        columns=2,
    )  # fmt: skip


def differences(found: Fit, run: MeasuredEigenvalues) -> np.ndarray:
    """The predicted parts minus the measured ones, over their standard errors (m,), in the order of the data."""
    return found.model.reduced(run, found.shared)[0] - run.data / run.deviation


def branches(found: Fit, speeds: np.ndarray) -> np.ndarray:
    """The eigenvalues (n, nx) of a fit, each column followed over the speeds (n,)."""
    model: Any = found.model
    return track_eigenvalues(lambda v: model.linearised(found.shared, v)[0].A, speeds).at(speeds)


def weak_form_spectra(verdict: Verdict, given: Fit) -> Chart:
    """Spectra of measured accelerations and of each fit's residuals in the first run, one panel per equation.

    given is the vehicle without a fit.
    """
    run: WeakFormRun = verdict.best.runs[0]
    fits = [
        (given, "changed", "as given"),
        (verdict.base, "base", "base, refitted"),
        (verdict.best, "found", label_of_best(verdict)),
    ]
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
    fits = [(verdict.base, "base", "base, refitted"), (verdict.best, "found", label_of_best(verdict))]
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
