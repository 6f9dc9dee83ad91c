"""Where the base deviates significantly (by the false-discovery rate), over recording, response, orders and
directions."""

from collections.abc import Collection, Mapping

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.localisation.harmonic_places import of_output
from motofmi.gap.localisation.locating import Place
from motofmi.gap.preprocessing.steer_test_run import Output, SteerTestRun
from motofmi.reports.figures import COLOURS, new_figure
from motofmi.reports.gap_tables import axis_of

MISS = "#c00000"


def gap_map(found: Fit, places: Collection[Place], index: int = 0, of: int = 0) -> Figure:
    """An output of a run over time, its response over frequency, its orders by band, its directions and amplitudes.

    Red marks significant misfit; a darker red means a larger excess.
    """
    run: SteerTestRun = found.runs[index]
    output = run.outputs[of]
    unit = run.recording.units[output.column]
    start = sum(len(r.data) for r in found.runs[:index]) + of * len(output.data)
    every = list(of_output(run, output, found.residuals[start : start + len(output.data)]))
    missed = [p for p in every if p in places]
    picture, (over_time, over_frequency, orders, directions) = new_figure(rows=4, height=11.5)
    over_time.plot(run.recording.time, output.measured, color=COLOURS["reference"], linewidth=0.4)
    over_time.set(xlabel=f"time in {run.name} [s]", ylabel=f"{output.column} [{unit}]")
    _shade(over_time, missed, "time")
    frequency, size = _response(run, output)
    over_frequency.semilogy(frequency, size, ".-", color=COLOURS["rider"])
    over_frequency.set(xlabel="frequency [Hz]", ylabel=f"first harmonic, output\nover motion [{unit}/{run.unit}]")
    _shade(over_frequency, missed, "frequency")
    _draw_orders(picture, orders, {p: p.order for p in every if p.axis.endswith("frequency") and p.order}, missed)
    orders.set_xlim(over_frequency.get_xlim())
    _draw_directions(directions, [p for p in every if p.axis.endswith(("direction", "amplitude"))], missed)
    return picture


def _shade(axes, places: list[Place], axis: str) -> None:
    for place in places:
        if place.axis.endswith(axis) and not place.order:
            axes.axvspan(
                place.start,
                place.end,
                color=MISS,
                linewidth=0,
                alpha=float(np.clip(0.1 + 0.15 * np.log10(1 + max(place.excess, 0.0)), 0.1, 0.5)),
            )


def _draw_orders(picture: Figure, axes, order_of: Mapping[Place, int], missed: list[Place]) -> None:
    """Each order over the bands of the excitation, coloured by the misfit, framed where it is significant."""
    colours = ScalarMappable(LogNorm(0.5, 100.0), "Greys")
    for clear in (False, True):  # framed bars last, on top of the others
        shown = [p for p in order_of if (p in missed) == clear]
        axes.bar([p.start for p in shown], 0.84, [p.end - p.start for p in shown], [order_of[p] - 0.42 for p in shown],
                 align="edge", color=colours.to_rgba(np.array([p.excess + 1 for p in shown])),
                 edgecolor=MISS if clear else "#bbbbbb", linewidth=1.6 if clear else 0.5)  # fmt: skip
    picture.colorbar(colours, ax=axes, label="reduced chi-square")
    axes.set(
        xlabel="frequency of the excitation [Hz]; framed red: significant",
        ylabel="order [1]",
        yticks=sorted(set(order_of.values())),
    )


def _draw_directions(axes, cells_of_directions: list[Place], missed: list[Place]) -> None:
    """Reduced chi-square by amplitude and direction."""
    labels = [_label(p) for p in cells_of_directions]
    colours = [MISS if p in missed else COLOURS["reference"] for p in cells_of_directions]
    axes.barh(labels[::-1], [p.excess + 1 for p in cells_of_directions][::-1], color=colours[::-1])
    axes.axvline(1.0, color="black", linewidth=0.8)
    axes.set(xlabel="reduced chi-square; 1: noise alone")


def _label(place: Place) -> str:
    word = axis_of(place.axis, place.order, place.unit).split(" over ")[-1].removeprefix("direction, ")
    return word if place.unit == "1" else f"{word} {place.start:.2g} to {place.end:.2g} {place.unit}"


def _response(run: SteerTestRun, output: Output) -> tuple[np.ndarray, np.ndarray]:
    """Frequency (w,) and the first harmonic of the output over that of the motion (w,), by window."""
    columns = run.reduction.columns
    pairs = np.array([i for i, c in enumerate(columns) if c.order == 1 and c.degree == 0]).reshape(-1, 2)
    motion = run.reduction.reduce(run.motion_at(run.recording.time)[0])
    size = np.hypot(*output.data[pairs.T]) / np.hypot(*motion[pairs.T])
    frequency = np.array([columns[i].frequency for i in pairs[:, 0]])
    order = np.argsort(frequency)
    return frequency[order], size[order]
