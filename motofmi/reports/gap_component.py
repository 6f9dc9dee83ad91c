"""Figures of a component's gap: where the base deviates, recording, response, Nyquist plane, whiteness."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.fft import idct

from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.preprocessing.sampled_run import SampledRun
from motofmi.gap.selection.result import Verdict
from motofmi.recordings.resampling import LONG, varies
from motofmi.reports.charts import Axis, Cells, Chart, Curve, Panel
from motofmi.reports.gap_before_after import shown_run, whiteness, without_and_with
from motofmi.reports.gap_report import Pictures
from motofmi.reports.report import Section, Table

MEASURED = "measured"
DRIVEN = 1e-4  # of an input's largest power spectrum, above which the response is shown
LEAST = 0.5  # of the noise; lower end of the map's colour scale
TALL, WIDE = 40, 60  # most cells of the map along frequency and time
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
              "no oscillation" if m["damping_ratio"][0] is None else f"{m['damping_ratio'][0]:.4g}")
             for label in ("before", "after") for m in result["modes"][label]]  # fmt: skip
    return Section(
        "Modes of the component at rest", [], [], [Table(("model", "frequency [Hz]", "damping ratio [1]"), modes)]
    )


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
        (measured, "measured", MEASURED),
        *((measured - left_over(fit)[2], colour, label) for fit, colour, label in shown),
    ]


def _recording(shown: Sequence[tuple[Fit, str, str]]) -> Chart:
    run: SampledRun = shown[0][0].runs[0]
    name = run.experiment.outputs[0]
    unit, time = run.recording.units[name], left_over(shown[0][0])[0]
    outputs = [
        Curve(label, *_interrupted(time, values), colour, width=1.0) for values, colour, label in _outputs(shown)
    ]
    residuals = [
        Curve(label, *_interrupted(time, left_over(fit)[2]), colour, width=1.0) for fit, colour, label in shown
    ]
    axis = Axis(f"time in {run.name}", "s")
    return Chart([Panel(axis, Axis(name.replace("_", " "), unit), outputs, height=250),
                  Panel(axis, Axis("difference to measured", unit), residuals, height=230)], linked=True)  # fmt: skip


def _interrupted(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Time and values (n,) with a value that is not a number in every gap of the recording, where no line is drawn."""
    steps = np.diff(time)
    gaps = np.flatnonzero(steps > LONG * np.median(steps)) + 1
    return np.insert(time, gaps, (time[gaps - 1] + time[gaps]) / 2), np.insert(values, gaps, np.nan)


def _loops(shown: Sequence[tuple[Fit, str, str]]) -> list[tuple[Chart, str]]:
    """The force over the deflection and the rate of an imposed motion."""
    run: SampledRun = shown[0][0].runs[0]
    if not run.experiment.imposed:
        return []
    component: Any = shown[0][0].model.component
    motion, force, panels = run.inputs(left_over(shown[0][0])[0]), run.experiment.outputs[0], []
    for place in (component.imposed, component.rate):
        curves = [Curve(label, motion[place], values, colour, width=1.0) for values, colour, label in _outputs(shown)]
        panels.append(
            Panel(
                Axis(place.replace("_", " "), component.table[place].unit),
                Axis(force.replace("_", " "), run.recording.units[force]),
                curves,
                hover="point",
                height=320,
            )
        )
    return [(Chart(panels, columns=2), f"{run.name}: the force over deflection and over rate.")]


def _responses(shown: Sequence[tuple[Fit, str, str]]) -> list[tuple[Chart, str]]:
    """Frequency response with the difference of each model, and Nyquist plane, where a recorded input drives the
    component."""
    run: SampledRun = shown[0][0].runs[0]
    inputs = [n for n in run.experiment.inputs if varies(run.recording[n])]
    if not inputs:
        return []
    from scipy.signal import csd, welch  # noqa: PLC0415 - imported on use: it takes 0.5 s

    rate = run.recording.rate
    drive = np.concatenate([run.recording[inputs[0]][first:last] for first, last in run.segments])
    n = min(len(drive) // 4, 2048)
    _, power = welch(drive, rate, nperseg=n)
    size, plane, difference, measured = [], [], [], np.zeros(0)
    for values, colour, label in _outputs(shown):
        style = "points" if label == MEASURED else "dashed" if colour == "base" else "line"
        frequency, cross = csd(drive, values, rate, nperseg=n)
        inside = (frequency > 0) & (frequency < run.reduction_band) & (power > DRIVEN * power.max())
        at, response = frequency[inside], (cross / power)[inside]
        size.append(Curve(label, at, np.abs(response), colour, style))
        plane.append(Curve(label, response.real, response.imag, colour, style, text=[f"{f:.3g} Hz" for f in at]))
        if label == MEASURED:
            measured = response
        else:
            difference.append(Curve(label, at, np.abs(response - measured), colour, width=1.0))
    output, cause = run.experiment.outputs[0], inputs[0]
    ratio = f"{output} / {cause}".replace("_", " ")
    units = f"({run.recording.units[output]})/({run.recording.units[cause]})"
    axis = Axis("frequency", "Hz", log=True)
    return [
        (
            Chart(
                [
                    Panel(axis, Axis(f"modulus of {ratio}", units, log=True), size, height=280),
                    Panel(axis, Axis("difference to measured", units, log=True), difference, height=220),
                ],
                linked=True,
            ),
            "Frequency response of the first output to the first input.",
        ),
        (
            Chart(
                [
                    Panel(
                        Axis(f"real part of {ratio}", units),
                        Axis("imaginary part", units),
                        plane,
                        hover="point",
                        height=380,
                    )
                ]
            ),
            "The same in the Nyquist plane.",
        ),
    ]


def _map(fit: Fit) -> Chart:
    from scipy.signal import spectrogram  # noqa: PLC0415 - imported on use: it takes 0.5 s

    run: SampledRun = fit.runs[0]
    time, _, left = left_over(fit)
    length = int(np.clip(PERIODS * run.recording.rate / run.middle_frequency, SHORTEST, max(len(left) // 8, SHORTEST)))
    frequency, middle, power = spectrogram(left, run.recording.rate, nperseg=length, noverlap=length // 2)
    inside = frequency <= run.reduction_band
    noise = 2 * run.densities[0](frequency[inside]) / run.recording.rate  # one-sided
    z = power[inside] / noise[:, None]
    rows, columns = (
        np.unique(np.linspace(0, size, most + 1).astype(int)) for size, most in zip(z.shape, (TALL, WIDE), strict=True)
    )
    rows, columns = rows[:-1], columns[:-1]
    mean = np.add.reduceat(np.add.reduceat(z, rows, axis=0), columns, axis=1)
    mean /= np.outer(np.diff([*rows, z.shape[0]]), np.diff([*columns, z.shape[1]]))
    low, left_edges = _edges(frequency[inside], rows), _edges(time[0] + middle, columns)
    y, x = np.meshgrid(low[:-1], left_edges[:-1], indexing="ij")
    y_end, x_end = np.meshgrid(low[1:], left_edges[1:], indexing="ij")
    value = np.sqrt(mean)
    cells = Cells(x.ravel(), x_end.ravel(), y.ravel(), y_end.ravel(), value.ravel(), "residual over noise [1]", LEAST,
                  max(float(value.max()), 10 * LEAST))  # fmt: skip
    return Chart(
        [
            Panel(
                Axis(f"time in {run.name}", "s", low=float(left_edges[0]), high=float(left_edges[-1])),
                Axis("frequency", "Hz", low=float(low[0]), high=float(low[-1])),
                cells=cells,
                hover="point",
                height=340,
            )
        ]
    )


def _edges(values: np.ndarray, firsts: np.ndarray) -> np.ndarray:
    """The edges of cells that begin at some of ascending values, half-way between neighbours."""
    step = values[1] - values[0] if len(values) > 1 else 1.0
    return np.append(values[firsts], values[-1] + step) - step / 2
