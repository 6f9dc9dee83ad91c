"""The gap as one HTML report: the verdict, where the model missed, and recording, harmonics, Nyquist plane, whiteness."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from identification.gap.data.runs import Run
from identification.gap.naming.decide import Verdict
from identification.gap.naming.fitting import Fit
from identification.gap.reporting.harmonic_places import cells
from identification.gap.reporting.locating import FALSE_DISCOVERIES, locate
from scenarios.gap_map import gap_map
from scenarios.gap_tables import before_and_after, modes_over_speed, places, verdict_section
from scenarios.report import COLOURS, Report, Section, new_figure

FILE = "report.html"


def write_report(verdict: Verdict, result: dict[str, Any], held: list[Run], folder: Path) -> str:
    """Write the report into the folder; its name there."""
    missed = locate(verdict.base, cells)
    sections = [
        verdict_section(result),
        Section("Where the base model misses", [f"Places that pass a false-discovery rate of {FALSE_DISCOVERIES:.0%} (Benjamini and Hochberg), in red."],
                [(gap_map(verdict.base, missed, i, k), f"{r.name}, {output.column}: recording, response, and what the base leaves by order, band, amplitude and direction.")
                 for i, r in enumerate(verdict.base.runs) for k, output in enumerate(r.outputs)],
                [places(result)]),
        Section("Before and after", [f"Held out: {', '.join(r.name for r in held) or 'none'}."], [(_harmonics(verdict), "First harmonic of the torque over frequency: measured, base, with what was found."),
                                         (_nyquist(verdict), "The same as impedance in the Nyquist plane."),
                                         (whiteness(verdict), "Residuals in units of the noise: before and after, against the normal distribution.")],
                [before_and_after(result)]),
        modes_over_speed(result),
    ]  # fmt: skip
    Report("The gap between model and recordings", f"Verdict: {result['verdict']}", sections).write(folder / FILE)
    return FILE


def _first(fit: Fit, index: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Frequency (w,), measured and modelled complex first harmonics (w,) of the effort in a run's windows."""
    run = fit.runs[index]
    start = sum(len(r.data) for r in fit.runs[:index])
    data = run.effort.data
    modelled = data + fit.residuals[start : start + len(data)] * run.effort.deviation
    angle = run.reduction.reduce(run.moved(run.recording.time)[0])
    places = [i for i, c in enumerate(run.reduction.columns) if c.order == 1 and c.degree == 0]
    pairs = np.array(places).reshape(-1, 2)
    moved = angle[pairs[:, 0]] - 1j * angle[pairs[:, 1]]
    frequency = np.array([run.reduction.columns[i].frequency for i in pairs[:, 0]])
    return frequency, *((y[pairs[:, 0]] - 1j * y[pairs[:, 1]]) / moved for y in (data, modelled))


def _harmonics(verdict: Verdict):
    figure, (size, phase) = new_figure(rows=2, sharex=True)
    for fit, colour, label in ((verdict.base, COLOURS["damper"], "base"), (verdict.best, COLOURS["rider"], "with what was found")):
        f, measured, modelled = _first(fit, 0)
        if fit is verdict.base:
            size.plot(f, np.abs(measured), ".", color=COLOURS["reference"], label="measured")
            phase.plot(f, np.angle(measured, deg=True), ".", color=COLOURS["reference"])
        size.plot(f, np.abs(modelled), color=colour, label=label)
        phase.plot(f, np.angle(modelled, deg=True), color=colour)
    size.set_ylabel("|T/angle| [N.m/rad]")
    phase.set_ylabel("phase [deg]")
    phase.set_xlabel("frequency [Hz]")
    size.legend()
    return figure


def _nyquist(verdict: Verdict):
    figure, axes = new_figure()
    _, measured, _ = _first(verdict.base, 0)
    axes.plot(measured.real, measured.imag, ".", color=COLOURS["reference"], label="measured")
    for fit, colour, label in ((verdict.base, COLOURS["damper"], "base"), (verdict.best, COLOURS["rider"], "with what was found")):
        _, _, modelled = _first(fit, 0)
        axes.plot(modelled.real, modelled.imag, color=colour, label=label)
    axes.set_xlabel("Re T/angle [N.m/rad]")
    axes.set_ylabel("Im T/angle [N.m/rad]")
    axes.legend()
    return figure


def whiteness(verdict: Verdict) -> Figure:
    """Residuals in units of the noise, before and after."""
    figure, axes = new_figure()
    bins = np.linspace(-6, 6, 61)
    for fit, colour, label in ((verdict.base, COLOURS["damper"], "base"), (verdict.best, COLOURS["rider"], "with what was found")):
        axes.hist(np.clip(fit.residuals[: fit.count], -6, 6), bins, density=True, histtype="step", color=colour, label=label)
    axes.plot(bins, np.exp(-(bins**2) / 2) / np.sqrt(2 * np.pi), color=COLOURS["reference"], label="noise alone")
    axes.set_xlabel("residual over noise")
    axes.legend()
    return figure

