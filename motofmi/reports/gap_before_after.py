"""The residuals of one run, before and after: over time, by order, as a response, in the Nyquist plane, against noise.

The run is the first validation run, else the first that was fitted.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.preprocessing.harmonics import Column
from motofmi.gap.preprocessing.steer_test_run import SteerTestRun
from motofmi.gap.selection.result import Verdict
from motofmi.reports.charts import Axis, Chart, Curve, Line, Panel

ORDERS = (1, 2, 3)
LAGS = 20


def label_of_best(verdict: Verdict) -> str:
    """The label of the curves of the best model, which is the base where no effect is in it; nothing is found where the
    verdict is unknown or tied."""
    if not verdict.best.model.effects:
        return "base"
    found = {"unknown": "with the nearest effects", "tied": "with one of the tied models"}
    return found.get(verdict.verdict, "with the effects found")


def without_and_with(verdict: Verdict) -> list[tuple[Fit, str, str]]:
    """Fit, colour (of a chart) and label of base and best on the validation runs, else on the fitted ones; of the base
    alone if no effect was found."""
    found = [each.fit for each in verdict.validation_gap] if verdict.validation_gap else [verdict.base, verdict.best]
    both = list(zip(found, ("base", "found"), ("base", label_of_best(verdict)), strict=True))
    return both if verdict.best.model.effects else both[1:]


def shown_run(verdict: Verdict) -> str:
    """A sentence that names the validation runs and the run that is shown."""
    names = [run.name for run in verdict.validation_gap[1].fit.runs] if verdict.validation_gap else []
    return (
        f"Validation runs, not used to fit: {', '.join(names)}. Shown is {names[0]}."
        if names
        else "No validation run: shown is the first that was fitted."
    )


@dataclass(frozen=True)
class _Left:
    """The harmonics of a run's effort (m,): measured, and the residuals of a fit."""

    run: SteerTestRun
    columns: list[Column]
    measured: np.ndarray
    left: np.ndarray

    @classmethod
    def of(cls, found: Fit) -> "_Left":
        run: SteerTestRun = found.runs[0]
        return cls(
            run, run.reduction.columns, run.effort.data, found.residuals[: len(run.effort.data)] * run.effort.deviation
        )

    def windows(self, values: np.ndarray) -> np.ndarray:
        """The rms (w,) of such numbers (m,) over each window's samples."""
        samples = np.array([last - first for first, last, _ in self.run.reduction.bases])
        return np.sqrt(np.bincount([c.window for c in self.columns], values**2, len(samples)) / samples)

    def order(self, k: int) -> np.ndarray:
        """The places (w, 2) of the cosines and sines of an order."""
        return np.array([i for i, c in enumerate(self.columns) if c.order == k and c.degree == 0], int).reshape(-1, 2)

    def amplitudes(self, values: np.ndarray, k: int) -> np.ndarray:
        """Amplitude (w,) of an order in such numbers (m,)."""
        samples = np.array(
            [np.subtract(*self.run.reduction.bases[self.columns[i].window][1::-1]) for i, _ in self.order(k)]
        )
        return np.hypot(*values[self.order(k)].T) * np.sqrt(2 / samples)

    def frequency(self, k: int = 1) -> np.ndarray:
        return np.array([self.columns[i].frequency for i, _ in self.order(k)])

    def response(self, values: np.ndarray) -> np.ndarray:
        """Such numbers (m,) at the first order over the motion's (w,), complex."""
        motion = self.run.reduction.reduce(self.run.motion_at(self.run.recording.time)[0])
        cos, sin = self.order(1).T
        return (values[cos] - 1j * values[sin]) / (motion[cos] - 1j * motion[sin])


def figures(shown: Sequence[tuple[Fit, str, str]]) -> list[tuple[Chart, str]]:
    """The charts of a swept or stepped run, with their captions."""
    name = shown[0][0].runs[0].name
    left = [(_Left.of(fit), colour, label) for fit, colour, label in shown]
    return [
        (
            _response(left),
            f"{name}: first harmonic of the torque over the imposed angle, and the difference of each model to what "
            "was "
            "measured.",
        ),
        (
            _over_time(left),
            f"{name}: the recording, and the residuals of its harmonics in each window, against the noise.",
        ),
        (_by_order(left), f"{name}: amplitude of the residuals at each order of the excitation, against the noise."),
        (_nyquist(left), "The first harmonic as impedance in the Nyquist plane."),
        (
            whiteness(shown, _in_time(left[0][0].columns)),
            f"{name}: residuals in units of the noise against the normal "
            "distribution, and how they "
            "depend on their neighbours in time; noise alone stays within the lines (95 %).",
        ),
    ]


def _over_time(left: Sequence[tuple[_Left, str, str]]) -> Chart:
    first, time_axis = left[0][0], Axis("time", "s")
    output, bases = first.run.effort, first.run.reduction.bases
    unit = first.run.recording.units[output.column]
    recorded = Curve("recording", first.run.recording.time, output.measured, "measured", width=0.8)
    time = np.array([first.run.recording.time[(begin + end) // 2] for begin, end, _ in bases])
    curves = [Curve(label, time, of.windows(of.left), colour) for of, colour, label in left]
    noise = Curve("noise", time, first.windows(output.deviation), "measured", "dashed")
    return Chart(
        [
            Panel(time_axis, Axis(output.column.replace("_", " "), unit), [recorded], height=220),
            Panel(time_axis, Axis("residual, rms", unit, log=True), [*curves, noise], height=240),
        ],
        linked=True,
    )


def _by_order(left: Sequence[tuple[_Left, str, str]]) -> Chart:
    first = left[0][0]
    unit, panels = first.run.recording.units[first.run.effort.column], []
    for k in ORDERS:
        curves = [
            Curve(label, of.frequency(k), of.amplitudes(of.left, k), colour, "both", width=1)
            for of, colour, label in left
        ]
        noise = Curve(
            "noise", first.frequency(k), first.amplitudes(first.run.effort.deviation, k), "measured", "dashed"
        )
        panels.append(
            Panel(
                Axis("frequency of the excitation", "Hz"),
                Axis(f"amplitude, order {k}", unit, log=True),
                [*curves, noise],
                height=220,
            )
        )
    return Chart(panels)


def _response(left: Sequence[tuple[_Left, str, str]]) -> Chart:
    size, phase, frequency = [], [], Axis("frequency", "Hz")
    for of, values, style, colour, label in _measured_and_modelled(left):
        order = np.argsort(of.frequency())
        at, response = of.frequency()[order], of.response(values)[order]
        size.append(Curve(label, at, np.abs(response), colour, style))
        phase.append(Curve(label, at, np.angle(response, deg=True), colour, style))
    difference = []
    for of, colour, label in left:
        order = np.argsort(of.frequency())
        difference.append(
            Curve(label, of.frequency()[order], np.abs(of.response(of.left)[order]), colour, "both", width=1)
        )
    return Chart(
        [
            Panel(frequency, Axis("torque over angle", "N.m/rad"), size, height=190),
            Panel(frequency, Axis("difference to measured", "N.m/rad", log=True), difference, height=190),
            Panel(frequency, Axis("phase", "deg"), phase, height=160),
        ],
        linked=True,
    )


def _nyquist(left: Sequence[tuple[_Left, str, str]]) -> Chart:
    curves = []
    for of, values, style, colour, label in _measured_and_modelled(left):
        order = np.argsort(of.frequency())
        response = of.response(values)[order]
        curves.append(
            Curve(
                label, response.real, response.imag, colour, style, text=[f"{f:.3g} Hz" for f in of.frequency()[order]]
            )
        )
    return Chart(
        [
            Panel(
                Axis("real part of torque over angle", "N.m/rad"),
                Axis("imaginary part", "N.m/rad"),
                curves,
                hover="point",
                height=380,
            )
        ]
    )


def _measured_and_modelled(left: Sequence[tuple[_Left, str, str]]) -> list[tuple[_Left, np.ndarray, str, str, str]]:
    first = left[0][0]
    return [
        (first, first.measured, "points", "measured", "measured"),
        *(
            (of, of.measured + of.left, "dashed" if colour == "base" else "line", colour, label)
            for of, colour, label in left
        ),
    ]


def _in_time(columns: Sequence[Column]) -> np.ndarray:
    """The places of a run's data, one kind of number after the other, each over time."""
    part = np.zeros(len(columns), int)  # of an order and degree: cosine, then sine
    for i in range(1, len(columns)):
        alike = (columns[i].window, columns[i].order, columns[i].degree) == (
            columns[i - 1].window,
            columns[i - 1].order,
            columns[i - 1].degree,
        )
        part[i] = part[i - 1] + 1 if alike else 0
    return np.array(
        sorted(range(len(columns)), key=lambda i: (columns[i].order, columns[i].degree, part[i], columns[i].window))
    )


def whiteness(shown: Sequence[tuple[Fit, str, str]], sequence: np.ndarray | None = None) -> Chart:
    """Residuals of the first run in units of the noise, and their correlation with their neighbours in a
    sequence of data (m,)."""
    bins, lags, spread, neighbours, count = np.linspace(-6, 6, 61), np.arange(1, LAGS + 1), [], [], 1
    for fit, colour, label in shown:
        left = fit.residuals[: len(fit.runs[0].data)]
        left = left if sequence is None else left[sequence]
        count = len(left)
        density, _ = np.histogram(np.clip(left, -6, 6), bins, density=True)
        spread.append(Curve(label, (bins[1:] + bins[:-1]) / 2, density, colour))
        neighbours.append(
            Curve(label, lags, [float(left[:-k] @ left[k:]) / float(left @ left) for k in lags], colour, "both")
        )
    spread.append(Curve("noise alone", bins, np.exp(-(bins**2) / 2) / np.sqrt(2 * np.pi), "measured", "dashed"))
    bound = 1.96 / np.sqrt(count)
    return Chart(
        [
            Panel(Axis("residual over noise", "1"), Axis("probability density", "1"), spread, height=260),
            Panel(
                Axis("lag", "1"),
                Axis("autocorrelation", "1"),
                neighbours,
                lines=[Line(-bound), Line(bound, "95 % of noise alone")],
                height=260,
            ),
        ],
        columns=2,
    )
