"""Figures of a component's gap: where the base deviates, recording, response, Nyquist plane, whiteness."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from scipy.fft import idct
from scipy.signal import csd, spectrogram, welch

from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.preprocessing.sampled_run import SampledRun
from motofmi.gap.selection.model_selection import Verdict
from motofmi.reports.figures import COLOURS, new_figure
from motofmi.reports.gap_before_after import shown_run, whiteness, without_and_with
from motofmi.reports.gap_report import Pictures
from motofmi.reports.report import Section, Table

MEASURED = "measured"
DRIVEN = 1e-4  # of an input's largest power spectrum, above which the response is shown
LEAST = 0.5  # of the noise; lower end of the map's colour scale
PERIODS, SHORTEST = 3.0, 16  # length of a window of the map: periods of the middle frequency, least number of samples


def pictures(verdict: Verdict) -> Pictures:
    """The figures of a report for a verdict on sampled runs."""
    shown = without_and_with(verdict)
    misses = [(_map(verdict.base), "Residuals of the base over time and frequency, in units of the noise.")]
    whiteness_ = (whiteness(shown), "Residuals in units of the noise against the normal distribution, and their "
                                    "autocorrelation over frequency; "
                  "noise alone stays within the grey lines (95 %).")  # fmt: skip
    recording = (_recording(shown), "The recording and the residuals, before and after.")
    return Pictures(misses, [recording, *_loops(shown), *_responses(shown), whiteness_], shown_run(verdict))


def modes_at_rest(result: dict[str, Any]) -> Section:
    """The modes of the component itself, before and after."""
    modes = [(label, f"{m['frequency'][0]:.4g}",
              "" if m["damping_ratio"][0] is None else f"{m['damping_ratio'][0]:.4g}")
             for label in ("before", "after") for m in result["modes"][label]]  # fmt: skip
    return Section("Modes of the component at rest", [], [], [Table(("", "frequency [Hz]", "damping ratio"), modes)])


def left_over(fit: Fit, output: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time (n,), measured output and residuals of a fit (n,) of the first run, within its band."""
    run: SampledRun = fit.runs[0]
    z = fit.residuals[: len(run.data)] * run.deviation
    time, measured, left, first_row = [], [], [], 0
    for first, last, kept in run.reduction.spans:
        row = first_row + output * kept
        spectrum = np.zeros(last - first)
        spectrum[:kept] = -z[row : row + kept]
        first_row += kept * run.reduction.outputs
        time.append(run.recording.time[first:last])
        measured.append(run.measured[first:last, output])
        left.append(idct(spectrum, norm="ortho"))
    return np.concatenate(time), np.concatenate(measured), np.concatenate(left)


def _outputs(shown: Sequence[tuple[Fit, str, str]]) -> list[tuple[np.ndarray, str, str]]:
    """The first output (n,) with colour and label, measured and by each fit."""
    _, measured, _ = left_over(shown[0][0])
    return [
        (measured, COLOURS["reference"], MEASURED),
        *((measured - left_over(fit)[2], colour, label) for fit, colour, label in shown),
    ]


def _recording(shown: Sequence[tuple[Fit, str, str]]) -> Figure:
    figure, (upper, lower) = new_figure(rows=2, sharex=True)
    run: SampledRun = shown[0][0].runs[0]
    name = run.experiment.outputs[0]
    for fit, colour, label in shown:
        time, measured, left = left_over(fit)
        lower.plot(time, left, color=colour, linewidth=0.8, label=label)
    upper.plot(time, measured, color=COLOURS["reference"], linewidth=0.8)
    unit = run.recording.units[name]
    upper.set_ylabel(f"{name} [{unit}]".replace("_", " "))
    lower.set(xlabel=f"time in {run.name} [s]", ylabel=f"residual [{unit}]")
    lower.legend()
    return figure


def _loops(shown: Sequence[tuple[Fit, str, str]]) -> list[tuple[Figure, str]]:
    """The force over the deflection and the rate of an imposed motion."""
    run: SampledRun = shown[0][0].runs[0]
    if not run.experiment.imposed:
        return []
    component: Any = shown[0][0].model.component
    motion, places = run.inputs(left_over(shown[0][0])[0]), (component.imposed, component.rate)
    figure, axes = new_figure(columns=2, sharey=True)
    for axis, place in zip(axes, places, strict=True):
        for values, colour, label in _outputs(shown):
            axis.plot(motion[place], values, color=colour, linewidth=0.8, label=label)
        axis.set_xlabel(f"{place} [{component.table[place].unit}]".replace("_", " "))
    force = run.experiment.outputs[0]
    axes[0].set_ylabel(f"{force} [{run.recording.units[force]}]".replace("_", " "))
    axes[1].legend(loc="lower right")
    return [(figure, f"{run.name}: the force over deflection and over rate.")]


def _responses(shown: Sequence[tuple[Fit, str, str]]) -> list[tuple[Figure, str]]:
    """Frequency response and Nyquist plane, where a recorded input drives the component."""
    run: SampledRun = shown[0][0].runs[0]
    inputs = [n for n in run.experiment.inputs if np.ptp(run.recording[n]) > 0]
    if not inputs:
        return []
    rate = run.recording.rate
    n = min(len(run.measured) // 4, 2048)
    drive = np.concatenate([run.recording[inputs[0]][first:last] for first, last in run.segments])
    _, power = welch(drive, rate, nperseg=n)
    figure, axes = new_figure()
    plane, on = new_figure()
    for values, colour, label in _outputs(shown):
        style = "." if label == MEASURED else "-"
        frequency, cross = csd(drive, values, rate, nperseg=n)
        response = cross / power
        inside = (frequency > 0) & (frequency < run.reduction_band) & (power > DRIVEN * power.max())
        axes.loglog(frequency[inside], np.abs(response[inside]), style, color=colour, label=label)
        on.plot(response[inside].real, response[inside].imag, style, color=colour, label=label)
    answer, cause = run.experiment.outputs[0], inputs[0]
    ratio, units = (
        f"{answer} / {cause}".replace("_", " "),
        f"{run.recording.units[answer]} / {run.recording.units[cause]}",
    )
    axes.set(xlabel="frequency [Hz]", ylabel=f"|{ratio}| [{units}]")
    on.set(xlabel=f"Re {ratio} [{units}]", ylabel=f"Im {ratio} [{units}]")
    axes.legend()
    on.legend()
    return [
        (figure, "Frequency response of the first output to the first input."),
        (plane, "The same in the Nyquist plane."),
    ]


def _map(fit: Fit) -> Figure:
    figure, axes = new_figure()
    run: SampledRun = fit.runs[0]
    time, _, left = left_over(fit)
    length = int(np.clip(PERIODS * run.recording.rate / run.middle_frequency, SHORTEST, max(len(left) // 8, SHORTEST)))
    frequency, middle, power = spectrogram(left, run.recording.rate, nperseg=length, noverlap=length // 2)
    inside = frequency <= run.reduction_band
    noise = 2 * run.densities[0](frequency[inside]) / run.recording.rate  # one-sided
    z = np.sqrt(power[inside] / noise[:, None])
    mesh = axes.pcolormesh(
        time[0] + middle,
        frequency[inside],
        z,
        norm=LogNorm(LEAST, max(float(z.max()), 10 * LEAST)),
        cmap="viridis",
        shading="nearest",
    )
    figure.colorbar(mesh, label="|residual| over noise")
    axes.set_xlabel(f"time in {run.name} [s]")
    axes.set_ylabel("frequency [Hz]")
    return figure
