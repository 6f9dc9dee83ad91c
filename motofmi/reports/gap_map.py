"""Where the base deviates significantly (by the false-discovery rate), over recording, response, orders and
directions."""

from collections.abc import Collection, Mapping

import numpy as np

from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.localisation.harmonic_places import of_output
from motofmi.gap.localisation.locating import Place
from motofmi.gap.preprocessing.steer_test_run import Output, SteerTestRun
from motofmi.reports.charts import Axis, Cells, Chart, Curve, Line, Panel, Shade
from motofmi.reports.gap_tables import axis_of


def gap_map(found: Fit, places: Collection[Place], index: int = 0, of: int = 0) -> Chart:
    """An output of a run over time, its response over frequency, its orders by band, its directions and amplitudes.

    Red marks significant misfit; a darker red means a larger excess.
    """
    run: SteerTestRun = found.runs[index]
    output = run.outputs[of]
    unit = run.recording.units[output.column]
    start = sum(len(r.data) for r in found.runs[:index]) + of * len(output.data)
    every = list(of_output(run, output, found.residuals[start : start + len(output.data)]))
    missed = [p for p in every if p in places]
    frequency, size = _response(run, output)
    low, high = float(frequency.min()), float(frequency.max())
    return Chart(
        [
            Panel(
                Axis(f"time in {run.name}", "s"),
                Axis(output.column.replace("_", " "), unit),
                [Curve("recording", run.recording.time, output.measured, width=0.8)],
                shades=_shades(missed, "time"),
                height=210,
            ),
            Panel(
                Axis("frequency", "Hz", low=low, high=high),
                Axis("first harmonic, output over motion", f"{unit}/{run.unit}", log=True),
                [Curve("response", frequency, size, "found", "both", width=1)],
                shades=_shades(missed, "frequency"),
                height=230,
            ),
            _orders({p: p.order for p in every if p.axis.endswith("frequency") and p.order}, missed, low, high),
            _directions([p for p in every if p.axis.endswith(("direction", "amplitude"))], missed),
        ]
    )


def _shades(places: list[Place], axis: str) -> list[Shade]:
    return [
        Shade(
            p.start,
            p.end,
            "significant misfit",
            opacity=float(np.clip(0.1 + 0.15 * np.log10(1 + max(p.excess, 0.0)), 0.1, 0.5)),
        )
        for p in places
        if p.axis.endswith(axis) and not p.order
    ]


def _orders(order_of: Mapping[Place, int], missed: list[Place], low: float, high: float) -> Panel:
    """Each order over the bands of the excitation, coloured by the misfit, framed where it is significant."""
    shown = sorted(order_of, key=lambda p: p in missed)  # framed cells last, on top of the others
    order = np.array([order_of[p] for p in shown], float)
    cells = Cells(
        [p.start for p in shown],
        [p.end for p in shown],
        order - 0.42,
        order + 0.42,
        [p.excess + 1 for p in shown],
        "reduced chi-square [1]",
        0.5,
        100.0,
        [p in missed for p in shown],
    )
    return Panel(
        Axis("frequency of the excitation; framed: significant", "Hz", low=low, high=high),
        Axis("order", "1", low=0.0, high=float(order.max(initial=1) + 1)),
        cells=cells,
        hover="point",
        height=190,
    )


def _directions(cells: list[Place], missed: list[Place]) -> Panel:
    """Reduced chi-square by amplitude and direction."""
    labels = [_label(p) for p in cells]
    bars = [
        Curve(name, [p.excess + 1 for p in kept], [cells.index(p) for p in kept], colour, "bars")
        for name, colour, kept in (
            ("significant misfit", "significant", [p for p in cells if p in missed]),
            ("consistent with the noise", "measured", [p for p in cells if p not in missed]),
        )
        if kept
    ]
    return Panel(
        Axis("reduced chi-square", "1", low=0.0),
        Axis("amplitude or direction", "", names=labels),
        bars,
        lines=[Line(1.0, "noise alone", across="x")],
        hover="point",
        height=80 + 34 * len(labels),
    )


def _label(place: Place) -> str:
    word = axis_of(place.axis, place.order, place.unit).split(" over ")[-1].removeprefix("direction, ")
    ends = dict.fromkeys(f"{end:.2g}" for end in (place.start, place.end))  # one number where they are the same
    return word if place.unit == "1" else f"{word} {' to '.join(ends)} {place.unit}"


def _response(run: SteerTestRun, output: Output) -> tuple[np.ndarray, np.ndarray]:
    """Frequency (w,) and the first harmonic of the output over that of the motion (w,), by window."""
    columns = run.reduction.columns
    pairs = np.array([i for i, c in enumerate(columns) if c.order == 1 and c.degree == 0]).reshape(-1, 2)
    motion = run.reduction.reduce(run.motion_at(run.recording.time)[0])
    size = np.hypot(*output.data[pairs.T]) / np.hypot(*motion[pairs.T])
    frequency = np.array([columns[i].frequency for i in pairs[:, 0]])
    order = np.argsort(frequency)
    return frequency[order], size[order]
